// SPDX-License-Identifier: MIT
#pragma once
/// Where body, gimbal and camera are on the Earth at any moment.
#include <Eigen/Core>

#include "watersky/sim/aircraft.hpp"
#include "watersky/sim/detail/earth.hpp"
#include "watersky/sim/renderer.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::sim {

/// Of a frame that was turned by yaw, then pitch, then roll about its own down, right, forward
/// axes: its axes as columns.
[[nodiscard]] Eigen::Matrix3d turned(double yaw_rad, double pitch_rad, double roll_rad);

/// platform_from_camera, as it is recorded.
[[nodiscard]] Eigen::Matrix3d nominal_mount(const CameraSetup& setup);

struct EarthPose {
  Eigen::Matrix3d rotation;  ///< axes as columns, earth-centred
  Eigen::Vector3d origin_m;
};

/// Immutable; safe to share between threads.
class Motion {
 public:
  Motion(const Scenario& scenario, const Aircraft& aircraft, const Geodetic& anchor);

  [[nodiscard]] EarthPose body(double t_s) const;
  /// The gimbal's rotation against what its record is relative to.
  [[nodiscard]] Eigen::Matrix3d recorded_gimbal(double t_s) const;
  [[nodiscard]] EarthPose camera(double t_s) const;
  [[nodiscard]] ScenePose camera_in_scene(double t_s) const;
  /// platform_from_camera, as it is
  [[nodiscard]] const Eigen::Matrix3d& mount() const { return mount_; }
  /// The camera's true place on its platform.
  [[nodiscard]] const Eigen::Vector3d& lever_arm_m() const { return lever_arm_m_; }
  [[nodiscard]] const Aircraft& aircraft() const { return aircraft_; }

 private:
  [[nodiscard]] Eigen::Matrix3d gimbal(const AircraftState& state, const Eigen::Matrix3d& axes,
                                       double t_s) const;

  Aircraft aircraft_;
  SeaSurface surface_;
  CameraSetup setup_;
  Eigen::Matrix3d mount_;
  Eigen::Vector3d lever_arm_m_;
  BandLimitedNoise jitter_yaw_, jitter_pitch_, jitter_roll_;
};

}  // namespace watersky::sim
