// SPDX-License-Identifier: MIT
#pragma once
/// Zhang's calibration (2000): the lens and where the target was, in one least squares fit.
#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "watersky/target_calibration/detail/lens_jacobian.hpp"
#include "watersky/target_calibration/target.hpp"

namespace watersky::detail {

/// camera_from_target; lengths in spacings of the target.
struct TargetPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

/// One view as the fit takes it.
struct FitPoint {
  Eigen::Vector2d on_target;
  Eigen::Vector2d seen;  ///< px
  double weight = 1.0;   ///< of its squared residual
};
using FitView = std::vector<FitPoint>;

struct LensFit {
  Lens lens;
  std::vector<int> free;  ///< parameters that were estimated
  std::vector<TargetPose> poses;
  double cost = 0.0;  ///< sum of weighted squared residuals, px²
  /// Of the free parameters for residuals of variance 1 px², poses marginalised out; not finite
  /// where the views do not determine them. Empty when it was not asked for.
  Eigen::MatrixXd unit_covariance;
  /// Sum over views of the outer product of their gradients: what clustered errors add up to.
  Eigen::MatrixXd clustered;
};

/// Residual, seen minus projected, in pixels; nullopt where the lens does not show the point.
[[nodiscard]] std::optional<Eigen::Vector2d> residual(const Lens& lens, const TargetPose& pose,
                                                      const FitPoint& point);

/// Levenberg and Marquardt's method from a start. nullopt where the start shows a point nowhere.
[[nodiscard]] std::optional<LensFit> fit_lens(std::span<const FitView> views, const Lens& start,
                                              std::span<const TargetPose> poses,
                                              const std::vector<int>& free,
                                              bool with_covariance = true,
                                              int most_iterations = 60);

/// A start: no distortion, the centre in the middle, and the focal length, of many, under which
/// the homographies (pinhole) or their like (fisheye, pixels turned into angles) look most like
/// rigid planes. nullopt when less than half of the views have a pose under any.
struct LensStart {
  Lens lens;
  std::vector<std::optional<TargetPose>> poses;
};
[[nodiscard]] std::optional<LensStart> start_lens(std::span<const FitView> views, LensModel model,
                                                  int width_px, int height_px);

/// A view's pose, roughly, under a lens that is known. nullopt where there is none.
[[nodiscard]] std::optional<TargetPose> pose_under(const FitView& view, const Lens& lens);

/// Where the picture of a disc's area has its centroid, less the picture of its centre: second
/// order in the radius, and as large as the noise for holes that are seen aslant.
[[nodiscard]] Eigen::Vector2d disc_offset(const Lens& lens, const TargetPose& pose,
                                          const Eigen::Vector2d& centre, double radius);

}  // namespace watersky::detail
