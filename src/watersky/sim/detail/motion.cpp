// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "watersky/sim/detail/motion.hpp"
#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::uint64_t jitter_seed(const Scenario& scenario, int axis) {
  return mix(static_cast<std::uint64_t>(scenario.seed), static_cast<std::uint64_t>(Stream::Gusts),
             100 + axis);
}

}  // namespace

Eigen::Matrix3d turned(double yaw, double pitch, double roll) {
  const double cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
  const double cr = std::cos(roll), sr = std::sin(roll);
  Eigen::Matrix3d r;
  r << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  return r;
}

Eigen::Matrix3d nominal_mount(const CameraSetup& setup) {
  // The camera's right, down, forward in the platform's forward, right, down.
  Eigen::Matrix3d looks_forward;
  looks_forward << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return setup.gimbal != 0 ? looks_forward
                           : turned(setup.mount_yaw_deg * kDegree, setup.mount_pitch_deg * kDegree,
                                    setup.mount_roll_deg * kDegree) *
                                 looks_forward;
}

Motion::Motion(const Scenario& scenario, const Aircraft& aircraft, const Geodetic& anchor)
    : aircraft_(aircraft),
      surface_(anchor),
      setup_(scenario.camera),
      mount_(nominal_mount(setup_)),
      lever_arm_m_(setup_.mount_x_m, setup_.mount_y_m, setup_.mount_z_m),
      jitter_yaw_(jitter_seed(scenario, 1), setup_.gimbal_jitter_deg * kDegree,
                  scenario.aircraft.gust_band_hz),
      jitter_pitch_(jitter_seed(scenario, 2), setup_.gimbal_jitter_deg * kDegree,
                    scenario.aircraft.gust_band_hz),
      jitter_roll_(jitter_seed(scenario, 3), setup_.gimbal_jitter_deg * kDegree,
                   scenario.aircraft.gust_band_hz) {
  Random random(static_cast<std::uint64_t>(scenario.seed), Stream::Mount);
  const auto direction = [&random] {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return Eigen::Vector3d(x, y, z).normalized();
  };
  const Eigen::Vector3d axis = direction(), aside = direction();
  if (setup_.mount_error_deg > 0.0)
    mount_ *= Eigen::AngleAxisd(setup_.mount_error_deg * kDegree, axis).toRotationMatrix();
  lever_arm_m_ += setup_.lever_error_m * aside;
}

EarthPose Motion::body(double t_s) const {
  const AircraftState s = aircraft_.at(t_s);
  const Eigen::Vector3d origin = surface_.above(s.north_m, s.east_m, s.height_m);
  return {north_east_down(geodetic_of(origin)) * turned(s.yaw_rad, s.pitch_rad, s.roll_rad),
          origin};
}

Eigen::Matrix3d Motion::gimbal(const AircraftState& state, const Eigen::Matrix3d& axes,
                               double t_s) const {
  return axes * turned(state.course_rad + setup_.mount_yaw_deg * kDegree + jitter_yaw_.at(t_s),
                       setup_.mount_pitch_deg * kDegree + jitter_pitch_.at(t_s),
                       setup_.mount_roll_deg * kDegree + jitter_roll_.at(t_s));
}

Eigen::Matrix3d Motion::recorded_gimbal(double t_s) const {
  const AircraftState s = aircraft_.at(t_s);
  const Eigen::Matrix3d axes =
      north_east_down(geodetic_of(surface_.above(s.north_m, s.east_m, s.height_m)));
  const Eigen::Matrix3d platform = gimbal(s, axes, t_s);
  if (setup_.gimbal == 1)
    return (axes * turned(s.yaw_rad, s.pitch_rad, s.roll_rad)).transpose() * platform;
  return axes.transpose() * platform;
}

EarthPose Motion::camera(double t_s) const {
  const AircraftState s = aircraft_.at(t_s);
  const Eigen::Vector3d origin = surface_.above(s.north_m, s.east_m, s.height_m);
  const Eigen::Matrix3d axes = north_east_down(geodetic_of(origin));
  const Eigen::Matrix3d platform =
      setup_.gimbal != 0 ? gimbal(s, axes, t_s) : axes * turned(s.yaw_rad, s.pitch_rad, s.roll_rad);
  return {platform * mount_, origin + platform * lever_arm_m_};
}

ScenePose Motion::camera_in_scene(double t_s) const {
  const EarthPose pose = camera(t_s);
  return {surface_.axes().transpose() * pose.rotation,
          surface_.axes().transpose() * (pose.origin_m - surface_.origin())};
}

}  // namespace watersky::sim
