// SPDX-License-Identifier: MIT
#pragma once
/// What the navigation says of the platform, in Local, at any time.
#include <vector>

#include "watersky/align/detail/local_frame.hpp"

namespace watersky::align {

/// The platform by the navigation at one moment. `reference` is what the gimbal turns against:
/// the body, or north, east, down; without a gimbal the body, and `gimbal` is the identity.
struct NavigationSample {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond reference = Eigen::Quaterniond::Identity();  ///< local_from_reference
  Eigen::Quaterniond gimbal = Eigen::Quaterniond::Identity();     ///< reference_from_platform
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d reference_rate_rad_s = Eigen::Vector3d::Zero();  ///< axes of Local
  Eigen::Vector3d gimbal_rate_rad_s = Eigen::Vector3d::Zero();     ///< axes of the reference
};

/// Times are seconds since `epoch()`.
class Navigation {
 public:
  /// Of a flight's trajectory and gimbal. Fails as LocalFrame does.
  [[nodiscard]] static Result<Navigation> make(const Flight& flight, const LocalFrame& frame,
                                               double max_gap_s);

  /// Of poses that are still to come, in order of time: add() and forget_before().
  explicit Navigation(Time epoch, double max_gap_s) : epoch_(epoch), max_gap_s_(max_gap_s) {}
  /// `flight` says what the gimbal turns against. OutOfRange when it does not follow the last;
  /// fails as LocalFrame does.
  [[nodiscard]] Status add(const Flight& flight, const LocalFrame& frame, const StampedPose& pose);
  [[nodiscard]] Status add(const StampedRotation& gimbal);
  /// Poses are kept from the last one before `t_s` on.
  void forget_before(double t_s);
  /// The time of the last pose (and gimbal attitude); nothing after is known. Minus infinity
  /// without any.
  [[nodiscard]] double until_s() const;

  [[nodiscard]] Time epoch() const { return epoch_; }
  [[nodiscard]] double since_epoch_s(Time t) const { return to_seconds(t - epoch_); }
  /// Whether poses (and gimbal attitudes) bracket a time, no farther apart than the longest gap.
  [[nodiscard]] bool covers(double t_s) const;
  /// Beyond the recorded poses as at the first or the last.
  [[nodiscard]] NavigationSample at(double t_s, double gimbal_latency_s = 0.0) const;
  /// One that stands still, of a frame with a pose of its own.
  [[nodiscard]] static Result<NavigationSample> still(
      const Flight& flight, const LocalFrame& frame, const StampedPose& pose,
      const std::optional<Eigen::Quaterniond>& gimbal);
  /// The recorded sigma, zero where there is none: the median over the flight.
  [[nodiscard]] const PoseSigma& typical_sigma() const { return typical_sigma_; }

 private:
  struct Pose {
    double t_s;
    Eigen::Vector3d position_m;
    Eigen::Quaterniond reference;
  };
  struct Turn {
    double t_s;
    Eigen::Quaterniond rotation;
  };
  Navigation() = default;
  [[nodiscard]] Result<Pose> local_pose(const Flight& flight, const LocalFrame& frame,
                                        const StampedPose& pose) const;
  void see_steps();
  [[nodiscard]] Pose pose_at(double t_s) const;
  [[nodiscard]] Eigen::Quaterniond gimbal_at(double t_s) const;

  Time epoch_;
  double max_gap_s_ = 0.5;
  double half_step_s_ = 0.005;  ///< of the differences that give velocities
  std::vector<Pose> poses_;
  std::vector<Turn> gimbal_;
  PoseSigma typical_sigma_;
};

}  // namespace watersky::align
