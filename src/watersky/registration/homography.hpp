// SPDX-License-Identifier: MIT
#pragma once
/// Homographies: applied, composed with scales, fitted to point pairs with their covariance.
#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>

#include "watersky/registration/registration.hpp"

namespace watersky {

/// Where `p` goes; NaN where it goes to infinity or behind the camera (denominator not positive).
[[nodiscard]] cv::Point2d apply(const Eigen::Matrix3d& homography, cv::Point2d p);

/// Centres of the corner pixels: top left, top right, bottom right, bottom left.
[[nodiscard]] std::array<cv::Point2d, 4> corners_of(cv::Size size);

/// The largest distance between where two homographies put the corner pixels; infinite where one
/// of them puts one nowhere.
[[nodiscard]] double corner_error_px(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b,
                                     cv::Size size);

/// What a view down at nearly flat water cannot do between two frames: mirror, fold, zoom beyond
/// 2.5, squeeze one way beyond 2, or vary its scale over the picture beyond 2.5. `expected_scale`
/// is that of B's pixels over A's.
[[nodiscard]] bool is_plausible(const Eigen::Matrix3d& b_from_a, cv::Size a_size,
                                double expected_scale = 1.0);

/// The least squares fit to `pairs` from `start`, of errors in B weighted by their covariances, in
/// a few Gauss-Newton steps.
/// Its covariance is scaled by the residuals. Neighbouring pairs may err alike (windows overlap,
/// the scene is not quite flat), so residuals are summed by patches of the picture and the larger
/// of the covariance that this gives and of the plain one is taken. nullopt when the pairs (at
/// least 5) do not determine a homography.
[[nodiscard]] std::optional<HomographyFit> fit_homography(std::span<const PointPair> pairs,
                                                          const Eigen::Matrix3d& start,
                                                          cv::Size a_size);

}  // namespace watersky
