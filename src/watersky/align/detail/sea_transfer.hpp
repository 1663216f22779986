// SPDX-License-Identifier: MIT
#pragma once
/// What of the sea a camera sees, and where another camera sees it, with derivatives.
#include <Eigen/Core>
#include <optional>

#include "watersky/align/detail/adjustment.hpp"

namespace watersky::align {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

/// exp(w + dw) = exp(J dw) exp(w), to first order in w.
[[nodiscard]] Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& w);

/// The sea under a ray, and its derivatives by the camera's place and left rotation.
struct SeaHit {
  Eigen::Vector3d at;
  Eigen::Matrix3d by_direction;  ///< by the ray's direction
  Eigen::Matrix3d by_position;
  Eigen::Vector3d ray;
};

/// nullopt of a ray that is too flat, or of a camera under the sea.
[[nodiscard]] std::optional<SeaHit> hit_sea(const ModelCamera& camera,
                                            const Eigen::Vector3d& direction);

/// Of a direction over z by the calibration: of the scaled focal length.
[[nodiscard]] Eigen::Vector3d with_focal(const Eigen::Vector2d& direction, double focal_scale);

/// The place under a ray alone: north, east in Local, m.
[[nodiscard]] std::optional<Eigen::Vector2d> sea_under(const ModelCamera& camera,
                                                       const Eigen::Vector3d& direction);

/// Where a frame sees the place that its host sees in a direction: over z.
[[nodiscard]] std::optional<Eigen::Vector2d> sent(const ModelCamera& host, const ModelCamera& frame,
                                                  const Eigen::Vector2d& host_direction,
                                                  double focal_scale,
                                                  const Eigen::Vector2d& moved_m);

/// Everything a tie's residual depends on.
struct Transfer {
  Eigen::Vector2d residual;  ///< in units of the focal length
  Matrix26 by_host, by_frame;
  Eigen::Vector2d by_focal;
  Eigen::Matrix2d by_drift;
};

[[nodiscard]] std::optional<Transfer> transfer(const ModelCamera& host, const ModelCamera& frame,
                                               const Eigen::Vector2d& host_direction,
                                               const Eigen::Vector2d& frame_direction,
                                               double focal_scale, const Eigen::Vector2d& drift_m_s,
                                               double elapsed_s);

/// What the residual of a known point depends on.
struct SeenKnown {
  Eigen::Vector2d residual;  ///< in units of the focal length
  Eigen::Matrix<double, 2, 3> by_point;
  Matrix26 by_camera;
  Eigen::Vector2d by_focal;
};

/// `camera` is at the row of the sighting, at `t_s`. That the point's own motion shifts it with the
/// camera's delay is left out of the derivatives: ice is slow against an aircraft.
[[nodiscard]] std::optional<SeenKnown> see_known_point(const ModelCamera& camera,
                                                       const KnownPoint& known, double focal_scale,
                                                       double t_s);

}  // namespace watersky::align
