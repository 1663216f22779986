// SPDX-License-Identifier: MIT
#pragma once
/// Between pixels and the directions that the estimator works with: lens, sea plane, lens.
#include <Eigen/Core>
#include <optional>

#include "watersky/align/detail/adjustment.hpp"
#include "watersky/camera/camera_model.hpp"

namespace watersky::align {

/// Directions over z of one camera to those of another, by the sea plane. nullopt where a camera
/// looks along it.
[[nodiscard]] std::optional<Eigen::Matrix3d> plane_homography(const ModelCamera& from,
                                                              const ModelCamera& to);

class SightingGeometry {
 public:
  explicit SightingGeometry(const CameraModel& camera)
      : camera_(camera), matrix_(camera.camera_matrix()), matrix_inverse_(matrix_.inverse()) {}

  /// Two sightings of a place, full-size pixels. nullopt where a pixel has no direction.
  [[nodiscard]] std::optional<Tie> tie(const Eigen::Vector2d& host_px, const Eigen::Vector2d& px,
                                       const Eigen::Matrix2d& covariance_px2) const;
  /// Of pixels of a frame by pixels of a host, around a host's pixel; `plane` by
  /// plane_homography().
  [[nodiscard]] Eigen::Matrix2d step_between(const Eigen::Matrix3d& plane,
                                             const Eigen::Vector2d& host_px) const;
  /// Full-size pixels of one frame to those of another, distortion left out: where to look.
  [[nodiscard]] std::optional<Eigen::Matrix3d> expected(const ModelCamera& from,
                                                        const ModelCamera& to) const;

 private:
  CameraModel camera_;
  Eigen::Matrix3d matrix_, matrix_inverse_;
};

}  // namespace watersky::align
