// SPDX-License-Identifier: MIT
#include "watersky/sim/detail/known_points.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/sim/detail/random.hpp"
#include "watersky/sim/lens.hpp"

namespace watersky::sim {

namespace {

/// Nothing is recorded as known better than this.
constexpr double kLeastSigma_m = 0.01, kLeastSigma_px = 0.05;

/// The anchor's true place, earth-centred, as the ice has carried it.
Eigen::Vector3d anchor_at(const Scenario& scenario, const SeaSurface& surface, double t_s) {
  const KnownPointParameters& p = scenario.known_points;
  return surface.above(p.anchor_north_m + scenario.drift_north_m_s * t_s,
                       p.anchor_east_m + scenario.drift_east_m_s * t_s, p.anchor_height_m);
}

}  // namespace

Anchor recorded_anchor(const Scenario& scenario, const Motion& motion, const Geodetic& scene,
                       const std::vector<std::pair<std::string, double>>& frames, Time start) {
  const KnownPointParameters& p = scenario.known_points;
  const SeaSurface surface(scene);
  Random random(static_cast<std::uint64_t>(scenario.seed), Stream::KnownPoints);
  const double north = random.normal(), east = random.normal(), down = random.normal();
  const auto recorded = [&](double t_s) {
    const Eigen::Vector3d real = anchor_at(scenario, surface, t_s);
    const Geodetic place =
        geodetic_of(real + p.anchor_sigma_m * north_east_down(geodetic_of(real)) *
                               Eigen::Vector3d(north, east, down));
    return AnchorPlace{place.latitude, place.longitude, place.height_ellipsoid_m,
                       HeightAbove::Ellipsoid};
  };
  Anchor anchor;
  anchor.name = "anchor";
  anchor.sigma_m = anchor.sigma_height_m = std::max(kLeastSigma_m, p.anchor_sigma_m);
  const bool drifts = scenario.drift_north_m_s != 0.0 || scenario.drift_east_m_s != 0.0;
  if (drifts) {
    constexpr double kEvery_s = 10.0;
    const double last_s = frames.empty() ? 0.0 : frames.back().second;
    for (double t = -kEvery_s; t < last_s + 2 * kEvery_s; t += kEvery_s)
      anchor.track.push_back({start + seconds(t), recorded(t)});
  } else {
    anchor.place = recorded(0.0);
  }

  const Lens lens(scenario.lens);
  const double width = scenario.lens.width_px, height = scenario.lens.height_px;
  const double readout_s = scenario.sensor.readout_s;
  const double noise_u = p.anchor_sigma_px;
  std::vector<AnchorSighting> seen;
  for (const auto& [name, t_s] : frames) {
    // Where the shutter rolls, the row says when it was seen, and that the row.
    Eigen::Vector2d px(0.5 * (width - 1), 0.5 * (height - 1));
    bool visible = true;
    for (int step = 0; step < (readout_s > 0 ? 4 : 1) && visible; ++step) {
      const double row_s = t_s + readout_s * (px.y() / (height - 1) - 0.5);
      const EarthPose camera = motion.camera(row_s);
      const Eigen::Vector3d direction =
          camera.rotation.transpose() * (anchor_at(scenario, surface, row_s) - camera.origin_m);
      const auto found = lens.pixel(direction);
      visible = found.has_value();
      if (visible) px = *found;
    }
    const double u = noise_u * random.normal(), v = noise_u * random.normal();
    constexpr double kEdge_px = 4.0;
    if (!visible || px.x() < kEdge_px || px.y() < kEdge_px || px.x() > width - 1 - kEdge_px ||
        px.y() > height - 1 - kEdge_px)
      continue;
    seen.push_back({name, {px.x() + u, px.y() + v}, std::max(kLeastSigma_px, noise_u)});
  }
  // A person marks some of them.
  const std::size_t most =
      p.anchor_sightings == 0 ? seen.size()
                              : std::min(seen.size(), static_cast<std::size_t>(p.anchor_sightings));
  for (std::size_t k = 0; k < most; ++k)
    anchor.sightings.push_back(seen[(2 * k + 1) * seen.size() / (2 * most)]);
  return anchor;
}

std::vector<RangeSample> recorded_ranges(const Scenario& scenario, const Motion& motion,
                                         const Geodetic& scene, Time start, double from_s,
                                         double to_s) {
  const KnownPointParameters& p = scenario.known_points;
  const SeaSurface surface(scene);
  Random random(mix(static_cast<std::uint64_t>(scenario.seed),
                    static_cast<std::uint64_t>(Stream::KnownPoints), 1));
  std::vector<RangeSample> out;
  for (double t = from_s; t <= to_s; t += 1.0 / p.range_rate_hz) {
    const EarthPose body = motion.body(t);
    // Along the beam to the paraboloid of the sea: its curvature over the slant is nothing, so two
    // steps of Newton's are exact to the rounding.
    const Eigen::Vector3d from = surface.axes().transpose() * (body.origin_m - surface.origin());
    const Eigen::Vector3d beam = surface.axes().transpose() * body.rotation.col(2);
    double range_m = 0.0;
    for (int step = 0; step < 3; ++step) {
      const Eigen::Vector3d at = from + range_m * beam;
      range_m += (surface.down_m(at.x(), at.y()) - at.z()) / beam.z();
    }
    const double noise_m = p.range_noise_m * random.normal();
    if (!(beam.z() > 0.1)) continue;
    out.push_back({start + seconds(t), range_m + noise_m, p.range_noise_m});
  }
  return out;
}

}  // namespace watersky::sim
