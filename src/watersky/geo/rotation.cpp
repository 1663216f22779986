// SPDX-License-Identifier: MIT
#include "watersky/geo/rotation.hpp"

#include <algorithm>
#include <cmath>

namespace watersky {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond rotation_from(const YawPitchRoll& angles) {
  return AngleAxisd(angles.yaw.radians(), Vector3d::UnitZ()) *
         AngleAxisd(angles.pitch.radians(), Vector3d::UnitY()) *
         AngleAxisd(angles.roll.radians(), Vector3d::UnitX());
}

YawPitchRoll yaw_pitch_roll(const Quaterniond& parent_from_child) {
  const Eigen::Matrix3d r = parent_from_child.normalized().toRotationMatrix();
  // atan2 keeps full precision near ±90°, where asin(-r20) loses half its digits.
  const double cos_pitch = std::hypot(r(0, 0), r(1, 0));
  const Angle pitch = Angle::radians(std::atan2(-r(2, 0), cos_pitch));
  if (cos_pitch < 1e-9) return {Angle::radians(std::atan2(-r(0, 1), r(1, 1))), pitch, Angle{}};
  // Roll is read after yaw was taken out: close to ±90° each alone loses digits, but so their
  // sum keeps them.
  const double yaw = std::atan2(r(1, 0), r(0, 0)), s = std::sin(yaw), c = std::cos(yaw);
  return {Angle::radians(yaw), pitch,
          Angle::radians(std::atan2(s * r(0, 2) - c * r(1, 2), c * r(1, 1) - s * r(0, 1)))};
}

Quaterniond heading(Angle azimuth) { return quaternion(azimuth, Vector3d::UnitZ()); }

Eigen::Matrix3d skew(const Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Eigen::Matrix3d rotation_matrix(Angle angle, const Vector3d& axis) {
  return cos(angle) * Eigen::Matrix3d::Identity() + sin(angle) * skew(axis) +
         (1 - cos(angle)) * axis * axis.transpose();
}

Quaterniond quaternion(Angle angle, const Vector3d& axis) {
  const Vector3d e = axis * sin(angle * 0.5);
  return {cos(angle * 0.5), e.x(), e.y(), e.z()};
}

Angle angle_between(const Quaterniond& a, const Quaterniond& b) {
  return Angle::radians(a.angularDistance(b));
}

Quaterniond forward_right_down_from_camera() {
  Eigen::Matrix3d r;  // columns: camera x → right, y → down, z → forward
  r << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return Quaterniond(r);
}

Quaterniond camera_rotation(const YawPitchRoll& angles) {
  return rotation_from(angles) * forward_right_down_from_camera();
}

}  // namespace watersky
