// SPDX-License-Identifier: MIT
#pragma once
/// From the estimator's flat sea back to poses of the body in World.
#include <Eigen/Core>
#include <optional>

#include "watersky/align/alignment.hpp"
#include "watersky/align/detail/adjustment.hpp"

namespace watersky::align {

/// What a frame's pose is written from, besides the model.
struct FrameWriting {
  const LocalFrame* local = nullptr;
  std::optional<GimbalReference> gimbal_reference;
  /// The body as recorded: of a gimbal against north, east, down the body's attitude plays no part
  /// in the model, and is kept.
  std::optional<Rigid3<World, Body>> recorded{};
  /// What was found of the mount goes into the poses: they are of a body on which the camera sits
  /// as it was given.
  bool fold_mount = false;
  /// Of the camera: position [m], rotation vector [rad], axes of Local.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Of the offset that frames share, m²: goes into the sigma, not the covariance.
  Eigen::Matrix2d shared_m2 = Eigen::Matrix2d::Zero();
};

/// Pose, gimbal, motion and sigmas; times, index and ties are the caller's. Fails as LocalFrame
/// does.
[[nodiscard]] Result<AlignedFrame> aligned_frame(const Adjustment& adjustment, int frame,
                                                 const FrameWriting& how);

}  // namespace watersky::align
