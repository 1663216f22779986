// SPDX-License-Identifier: MIT
#include <cmath>
#include <complex>
#include <limits>
#include <map>

#include "ground_error.hpp"
#include "study.hpp"
#include "watersky/camera/sea_plane.hpp"

namespace watersky::study {

namespace {

constexpr double kSpacing_m = 12.0;

Eigen::Vector2d mean_error(const Looks& looks) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Look& look : looks.looks) sum += look.error_m;
  return sum / static_cast<double>(looks.looks.size());
}

/// Root mean square of the errors less an offset that may differ from look to look.
template <class Offset>
double rms(const Looks& looks, Offset offset) {
  double sum = 0.0;
  for (const Look& look : looks.looks) sum += (look.error_m - offset(look)).squaredNorm();
  return std::sqrt(sum / static_cast<double>(looks.looks.size()));
}

}  // namespace

Looks look_at_points(const Flight& prepared, const sim::Simulation& simulation, bool turns) {
  const sim::Truth& truth = simulation.truth;
  Looks out;
  std::vector<Point<World>> places;
  const double north = 0.5 * truth.sea.extent().north_m, east = 0.5 * truth.sea.extent().east_m;
  for (double n = -north + 0.5 * kSpacing_m; n < north; n += kSpacing_m)
    for (double e = -east + 0.5 * kSpacing_m; e < east; e += kSpacing_m) {
      places.push_back(truth.world({n, e}));
      out.points_m.emplace_back(places.back().v.head<2>());
    }

  std::map<std::string, const ImageFrame*> claimed;
  for (const ImageFrame& frame : prepared.frames) claimed[frame.name] = &frame;
  const CameraModel& camera = simulation.flight.camera;
  for (std::size_t i = 0; i < truth.frames.size(); ++i) {
    const Rigid3<World, Camera>& real = truth.frames[i].world_from_camera;
    if (!turns && !is_level(real)) continue;
    ++out.frames;
    const auto frame = claimed.find(simulation.flight.frames[i].name);
    const auto pose = frame == claimed.end()
                          ? Result<CameraPose>(Error{ErrorCode::NotFound, "left out"})
                          : prepared.camera_pose(*frame->second, kPoseGap);
    const auto view = pose ? SeaView::make(prepared.camera, pose->sea_from_camera)
                           : Result<SeaView>(pose.error());
    if (!view) {
      ++out.frames_left_out;
      continue;
    }
    const Rigid3<World, watersky::Sea> world_from_sea =
        prepared.datum.ecef_from_world().inverse() * ecef_from_sea(pose->sea_below);
    const Rigid3<Camera, World> camera_from_world = real.inverse();
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto pixel = camera.project(camera_from_world * places[k]);
      if (!pixel || !camera.contains(*pixel)) continue;
      const auto put = view->sea_point(*pixel);
      if (!put) continue;  // beyond the grazing limit: a map would not use it either
      out.looks.push_back({k, ((world_from_sea * *put).v - places[k].v).head<2>()});
    }
  }
  return out;
}

Accuracy judge(const Looks& looks) {
  Accuracy out;
  if (looks.looks.empty()) {
    const double none = std::nan("");
    return {none, none, none, none};
  }
  const Eigen::Vector2d offset = mean_error(looks);
  std::vector<Eigen::Vector2d> mean(looks.points_m.size(), Eigen::Vector2d::Zero());
  std::vector<double> count(looks.points_m.size(), 0.0);
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Look& look : looks.looks) {
    mean[look.point] += look.error_m;
    count[look.point] += 1.0;
    middle += looks.points_m[look.point] / static_cast<double>(looks.looks.size());
  }
  std::size_t anchor = 0;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < mean.size(); ++k) {
    if (count[k] == 0.0) continue;
    mean[k] /= count[k];
    const double distance_m = (looks.points_m[k] - middle).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    anchor = k;
  }
  out.absolute_m = rms(looks, [](const Look&) { return Eigen::Vector2d::Zero().eval(); });
  out.shape_m = rms(looks, [&](const Look&) -> const Eigen::Vector2d& { return offset; });
  out.sharpness_m =
      rms(looks, [&](const Look& look) -> const Eigen::Vector2d& { return mean[look.point]; });
  out.anchored_m = rms(looks, [&](const Look&) { return mean[anchor]; });
  return out;
}

double floor_m(const Looks& looks, const sim::Truth& truth) {
  // In the plane a turn with a change of size is one complex factor: least squares in closed form.
  using Complex = std::complex<double>;
  const auto complex = [](const Eigen::Vector2d& p) { return Complex(p.x(), p.y()); };
  const auto count = static_cast<double>(truth.frames.size());
  Complex real_mean = 0.0, recorded_mean = 0.0;
  for (const sim::TrueFrame& frame : truth.frames) {
    const Complex real = complex(frame.world_from_body.origin().v.head<2>());
    real_mean += real / count;
    recorded_mean += (real + complex(frame.navigation_error_m.head<2>())) / count;
  }
  Complex product = 0.0;
  double power = 0.0;
  for (const sim::TrueFrame& frame : truth.frames) {
    const Complex real = complex(frame.world_from_body.origin().v.head<2>());
    const Complex recorded = real + complex(frame.navigation_error_m.head<2>());
    product += std::conj(real - real_mean) * (recorded - recorded_mean);
    power += std::norm(real - real_mean);
  }
  const Complex turn_and_size = product / power;
  Looks fitted = looks;
  for (Look& look : fitted.looks) {
    const Complex p = complex(looks.points_m[look.point]);
    const Complex error = recorded_mean + turn_and_size * (p - real_mean) - p;
    look.error_m = {error.real(), error.imag()};
  }
  return judge(fitted).shape_m;
}

}  // namespace watersky::study
