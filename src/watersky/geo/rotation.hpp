// SPDX-License-Identifier: MIT
#pragma once
/// The parametrisations of a rotation in section 2.1 of the thesis.
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "watersky/base/angle.hpp"

namespace watersky {

/// Aerospace angles, intrinsic about the moving z, y, x axes of a forward-right-down frame:
/// first yaw, then pitch, then roll.
struct YawPitchRoll {
  Angle yaw, pitch, roll;
};

/// parent_from_child for a child turned by `angles` out of the parent.
[[nodiscard]] Eigen::Quaterniond rotation_from(const YawPitchRoll& angles);

/// The inverse of rotation_from. At pitch ±90° yaw and roll turn about one axis: roll is then
/// returned as 0 and yaw carries their sum or difference, so rotation_from still gives the
/// rotation back.
[[nodiscard]] YawPitchRoll yaw_pitch_roll(const Eigen::Quaterniond& parent_from_child);

/// A level child that looks along `azimuth`, clockwise from the parent's first axis (north).
[[nodiscard]] Eigen::Quaterniond heading(Angle azimuth);

/// The cross-product matrix (2.6): skew(a) b = a × b.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// (2.5), for a unit axis.
[[nodiscard]] Eigen::Matrix3d rotation_matrix(Angle angle, const Eigen::Vector3d& axis);

/// (2.7) and (2.8), for a unit axis.
[[nodiscard]] Eigen::Quaterniond quaternion(Angle angle, const Eigen::Vector3d& axis);

/// The angle in [0, π] by which `a` and `b` differ.
[[nodiscard]] Angle angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// forward-right-down from a camera that looks forward with the image top up: the camera's
/// x (right), y (down), z (forward) are right, down and forward.
[[nodiscard]] Eigen::Quaterniond forward_right_down_from_camera();

/// A camera turned by a gimbal's angles on a forward-right-down platform: at zero it looks
/// forward, image top up; pitch -90° looks straight down, image top forward; yaw -90° with it
/// puts the image top to the left.
[[nodiscard]] Eigen::Quaterniond camera_rotation(const YawPitchRoll& angles);

}  // namespace watersky
