// SPDX-License-Identifier: MIT
#pragma once
/// Elliptic spots of an image that differ from their surroundings.
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace watersky::detail {

/// A spot as an ellipse: its centre and the second moments of its area.
struct Blob {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();       ///< px
  Eigen::Matrix2d moments = Eigen::Matrix2d::Identity();  ///< px²; a disc of radius r has r²/4
  double contrast = 0.0;       ///< levels, against the background; positive for a bright spot
  double edge_width_px = 0.0;  ///< 10 % to 90 %; 0 until refined
  [[nodiscard]] double area_px2() const;
};

/// Spots in `gray` (CV_32F) of one polarity that stand out of the mean over a window of
/// `window_px`, at most a few thousand.
[[nodiscard]] std::vector<Blob> find_blobs(const cv::Mat& gray, int window_px, bool bright,
                                           double noise);

/// Standard deviation of what differs from pixel to pixel in `gray` (CV_32F).
[[nodiscard]] double noise_of(const cv::Mat& gray);

/// The same spot measured by how much of each pixel it covers. nullopt where its surroundings are
/// not on the image or the spot is not told from them.
[[nodiscard]] std::optional<Blob> refine_blob(const cv::Mat& gray, const Blob& blob);

}  // namespace watersky::detail
