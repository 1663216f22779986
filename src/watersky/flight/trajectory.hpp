// SPDX-License-Identifier: MIT
#pragma once
/// Poses in time.
#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"
#include "watersky/geo/rigid3.hpp"

namespace watersky {

/// One sigma of a pose. Zero: not known.
struct PoseSigma {
  Eigen::Vector3d position_north_east_down_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d roll_pitch_yaw_rad = Eigen::Vector3d::Zero();
};

struct StampedPose {
  Time time;
  Rigid3<World, Body> world_from_body{Eigen::Quaterniond::Identity(), Point<World>{}};
  std::optional<PoseSigma> sigma;
  /// How position and attitude err together, where that is known (an alignment's result): position
  /// [m], then a rotation vector [rad] that turns the attitude, both along World's axes.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance{};
};

/// The body's motion, interpolated between bracketing poses and never extrapolated.
class Trajectory {
 public:
  Trajectory() = default;
  /// Poses must be finite and their times strictly increasing: InvalidInput names the first that
  /// is not, counting from 1.
  [[nodiscard]] static Result<Trajectory> make(std::vector<StampedPose> poses);

  [[nodiscard]] const std::vector<StampedPose>& poses() const { return poses_; }
  [[nodiscard]] bool empty() const { return poses_.empty(); }

  /// Position linearly, rotation along the great circle (slerp), sigma the larger of the two
  /// neighbours'. At a pose's own time exactly that pose. OutOfRange, with the distance in time,
  /// before the first pose, after the last, or in a gap longer than `max_gap`.
  [[nodiscard]] Result<StampedPose> at(Time time, Duration max_gap) const;

 private:
  std::vector<StampedPose> poses_;
};

/// The gimbal's recorded attitude.
struct StampedRotation {
  Time time;
  Eigen::Quaterniond rotation;
};

/// What a gimbal's angles are relative to: the aircraft's body, or north, east, down where the
/// aircraft is.
enum class GimbalReference { Body, NorthEastDown };

/// Rotations in time, under the same rules as Trajectory; made unit quaternions here.
class RotationTrack {
 public:
  RotationTrack() = default;
  [[nodiscard]] static Result<RotationTrack> make(std::vector<StampedRotation> rotations);
  [[nodiscard]] const std::vector<StampedRotation>& rotations() const { return rotations_; }
  [[nodiscard]] Result<Eigen::Quaterniond> at(Time time, Duration max_gap) const;

 private:
  std::vector<StampedRotation> rotations_;
};

}  // namespace watersky
