// SPDX-License-Identifier: MIT
#include "watersky/align/detail/evidence.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "watersky/align/detail/flight_edit.hpp"

namespace watersky::detail {

namespace {

/// Of a pair's tie points; they come spread over what it shares.
constexpr std::size_t kPointsUsed = 12;
/// Poses without a sigma of their own: GNSS and an autopilot's attitude.
constexpr double kUsualPosition_m = 1.0, kUsualPositionOfHeight = 0.02;
constexpr Angle kUsualAttitude = Angle::degrees(0.7);
/// Intrinsics that do not say how good they are.
constexpr double kUsualFocalSigma = 0.02;

/// The frames of the pairs alone, and the poses around their times.
Flight part_of(const Flight& flight, const std::vector<std::size_t>& frames,
               std::span<const PlacedFrame> posed, Duration max_gap) {
  Flight part(flight.name, flight.datum, flight.camera);
  part.calibration = flight.calibration;
  part.mount = flight.mount;
  part.gimbal_reference = flight.gimbal_reference;
  part.sea_level = flight.sea_level;
  part.delay_s = flight.delay_s;
  std::vector<Time> times;
  std::map<std::size_t, Time> time_of;
  for (const PlacedFrame& frame : posed) time_of[frame.frame] = frame.pose.time;
  for (const std::size_t i : frames) {
    ImageFrame frame = flight.frames[i];
    frame.load = nullptr;
    part.frames.push_back(std::move(frame));
    times.push_back(time_of.at(i));
  }
  std::sort(times.begin(), times.end());
  const Duration reach = max_gap + seconds(kDelays * kDelayStep_s);
  const auto kept = [&](const auto& samples) {
    std::vector<std::decay_t<decltype(samples[0])>> out;
    for (const auto& sample : samples) {
      const auto after = std::lower_bound(times.begin(), times.end(), sample.time - reach);
      if (after != times.end() && *after <= sample.time + reach) out.push_back(sample);
    }
    return out;
  };
  // What was in order stays so.
  part.trajectory = Trajectory::make(kept(flight.trajectory.poses())).value();
  part.gimbal = RotationTrack::make(kept(flight.gimbal.rotations())).value();
  return part;
}

double usual_noise_m(std::span<const PlacedFrame> posed) {
  std::vector<double> noise_m;
  for (const PlacedFrame& frame : posed) {
    const double height_m = std::abs(frame.height_m());
    double position_m = std::min(kUsualPosition_m, kUsualPositionOfHeight * height_m);
    double attitude = kUsualAttitude.radians();
    if (frame.pose.sigma) {
      const PoseSigma& s = *frame.pose.sigma;
      if (s.position_north_east_down_m.head<2>().norm() > 0)
        position_m = s.position_north_east_down_m.head<2>().norm() / std::numbers::sqrt2;
      if (s.roll_pitch_yaw_rad.norm() > 0) attitude = s.roll_pitch_yaw_rad.head<2>().maxCoeff();
    }
    noise_m.push_back(std::numbers::sqrt2 * std::hypot(position_m, height_m * attitude));
  }
  return std::max(median_of(std::move(noise_m)), 1e-3);
}

/// The area of a footprint as the poses have it; for frames without a sight of the sea the height.
double usual_side_m(std::span<const PlacedFrame> posed) {
  std::vector<double> sides_m;
  for (const PlacedFrame& frame : posed) {
    double twice_m2 = 0.0;
    const auto& line = frame.footprint_m;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Eigen::Vector2d a = line[i] - line[0], b = line[i + 1] - line[0];
      twice_m2 += a.x() * b.y() - a.y() * b.x();
    }
    sides_m.push_back(line.empty() ? std::abs(frame.height_m())
                                   : std::sqrt(0.5 * std::abs(twice_m2)));
  }
  return median_of(std::move(sides_m));
}

}  // namespace

Evidence make_evidence(const Flight& flight, std::span<const PlacedFrame> posed,
                       const std::vector<RegisteredPair>& pairs, Duration max_gap) {
  std::set<std::size_t> used;
  for (const RegisteredPair& pair : pairs) used.insert({pair.a, pair.b});
  std::vector<std::size_t> frames(used.begin(), used.end());
  const auto index = [&](std::size_t frame) {
    return static_cast<std::size_t>(std::lower_bound(frames.begin(), frames.end(), frame) -
                                    frames.begin());
  };
  std::vector<PairRays> rays;
  for (const RegisteredPair& pair : pairs)
    rays.push_back(pair_rays(flight.camera, pair, index(pair.a), index(pair.b), kPointsUsed));
  std::vector<double> heights_m;
  for (const PlacedFrame& frame : posed) heights_m.push_back(std::abs(frame.height_m()));
  const double noise_m = usual_noise_m(posed);
  const double cap_m = std::max(2.0 * median_of(std::move(heights_m)), 10.0 * noise_m);
  Evidence out{part_of(flight, frames, posed, max_gap),
               frames,
               Disagreement(std::move(rays), noise_m, cap_m),
               max_gap,
               usual_side_m(posed),
               kUsualFocalSigma,
               false};
  if (flight.calibration.focal_sigma_px > 0)
    out.focal_sigma = flight.calibration.focal_sigma_px / flight.camera.focal_px();
  out.poses_of_frames =
      std::any_of(flight.frames.begin(), flight.frames.end(),
                  [](const ImageFrame& frame) { return frame.own_pose.has_value(); });
  return out;
}

Status take_out(const MetadataFinding& finding, Evidence& evidence) {
  if (finding.fault != MetadataFault::TurnedImages) return apply(finding, evidence.flight);
  std::vector<PairRays> pairs = evidence.disagreement.pairs();
  const auto turn = [&](std::size_t frame, auto& rays) {
    if (!std::binary_search(finding.frames.begin(), finding.frames.end(), evidence.frames[frame]))
      return;
    std::rotate(rays.begin(), rays.begin() + finding.quarter_turns, rays.end());
  };
  for (PairRays& pair : pairs) {
    turn(pair.a, pair.rays_a);
    turn(pair.b, pair.rays_b);
  }
  evidence.disagreement = Disagreement(std::move(pairs), evidence.disagreement.noise_m(),
                                       evidence.disagreement.cap_m());
  return {};
}

}  // namespace watersky::detail
