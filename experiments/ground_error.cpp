// SPDX-License-Identifier: MIT
#include "ground_error.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

namespace watersky::study {

namespace {

const double kLevelCosine = std::cos(Angle::degrees(15.0).radians());

/// Where a ray meets the plane of the sea; nullopt above the horizon.
std::optional<Eigen::Vector2d> on_sea(const Rigid3<Sea, Camera>& pose, const Vector<Camera>& ray) {
  const Eigen::Vector3d d = pose.rotation() * ray.v, o = pose.origin().v;
  if (!(o.z() * d.z() < 0.0)) return std::nullopt;
  return (o - o.z() / d.z() * d).head<2>();
}

std::vector<Eigen::Vector2d> errors_of(const Flight& prepared, const ImageFrame& frame,
                                       const CameraModel& camera,
                                       const Rigid3<World, Camera>& real) {
  std::vector<Eigen::Vector2d> errors;
  const auto pose = prepared.camera_pose(frame, kPoseGap);
  if (!pose) return errors;
  // Both by the sea's tangent plane where the frame claims to be: the true camera is some metres
  // off, over which the sea curves by less than a micrometre.
  const Rigid3<Sea, Camera> sea_from_real =
      ecef_from_sea(pose->sea_below).inverse() * prepared.datum.ecef_from_world() * real;
  for (const double across : {0.1, 0.3, 0.5, 0.7, 0.9})
    for (const double down : {0.1, 0.5, 0.9}) {
      const Pixel pixel{across * camera.width_px(), down * camera.height_px()};
      // Each by the camera it believes in: an estimate may have corrected the lens as well.
      const auto claimed = prepared.camera.direction(pixel), actual = camera.direction(pixel);
      if (!claimed || !actual) continue;
      const auto put = on_sea(pose->sea_from_camera, *claimed), is = on_sea(sea_from_real, *actual);
      if (put && is) errors.emplace_back(*put - *is);
    }
  return errors;
}

}  // namespace

bool is_level(const Rigid3<World, Camera>& world_from_camera) {
  // World's down is the local down to 0.01° over a scene.
  return (world_from_camera.rotation() * Eigen::Vector3d::UnitZ()).z() >= kLevelCosine;
}

std::size_t GroundErrors::frames_left_out() const {
  return static_cast<std::size_t>(
      std::count_if(of_frame_m.begin(), of_frame_m.end(), [](const auto& e) { return e.empty(); }));
}

GroundErrors ground_errors(const Flight& prepared, const sim::Simulation& recording, int step) {
  std::map<std::string, const ImageFrame*> claimed;
  for (const ImageFrame& frame : prepared.frames) claimed[frame.name] = &frame;
  GroundErrors out;
  for (std::size_t i = 0; i < recording.truth.frames.size(); i += static_cast<std::size_t>(step)) {
    const Rigid3<World, Camera>& real = recording.truth.frames[i].world_from_camera;
    if (!is_level(real)) continue;
    const auto frame = claimed.find(recording.flight.frames[i].name);
    out.of_frame_m.push_back(frame == claimed.end() ? std::vector<Eigen::Vector2d>{}
                                                    : errors_of(prepared, *frame->second,
                                                                recording.flight.camera, real));
  }
  return out;
}

void keep_common(const std::vector<GroundErrors*>& all) {
  if (all.empty()) return;
  for (std::size_t i = 0; i < all.front()->of_frame_m.size(); ++i) {
    const bool common = std::all_of(all.begin(), all.end(), [&](const GroundErrors* errors) {
      return !errors->of_frame_m[i].empty();
    });
    if (common) continue;
    for (GroundErrors* errors : all) errors->of_frame_m[i].clear();
  }
}

GroundAccuracy judge(const GroundErrors& errors) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0.0, count = 0.0;
  for (const auto& frame : errors.of_frame_m)
    for (const Eigen::Vector2d& error : frame) {
      sum += error;
      squares += error.squaredNorm();
      count += 1.0;
    }
  if (count == 0.0) return {std::nan(""), std::nan("")};
  // About the mean once more, not from the sums: the mean may be a thousand times the rest.
  const Eigen::Vector2d mean = sum / count;
  double rest = 0.0;
  for (const auto& frame : errors.of_frame_m)
    for (const Eigen::Vector2d& error : frame) rest += (error - mean).squaredNorm();
  return {std::sqrt(squares / count), std::sqrt(rest / count)};
}

}  // namespace watersky::study
