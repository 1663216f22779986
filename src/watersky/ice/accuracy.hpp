// SPDX-License-Identifier: MIT
#pragma once
/// How true a map is, where the truth is known.
#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/ice/objects.hpp"

namespace watersky::ice {

struct RasterAccuracy {
  double iou = 0.0;       ///< of ice: cells both call ice over cells either calls ice
  double accuracy = 0.0;  ///< share of cells on which both agree
  /// Mean P(ice) above one half as a fraction less the true fraction, over the cells compared.
  double concentration_error = 0.0;
  std::size_t cells = 0;  ///< seen, and with a truth
};

/// `probability`: CV_32F, NaN where never seen. `truth_share`: CV_32F of the same size, the share
/// of each cell that is ice, NaN where the truth is not known; ice from one half.
[[nodiscard]] RasterAccuracy compare(const cv::Mat& probability, const cv::Mat& truth_share);

struct TruthObject {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();  ///< grid position
  double equivalent_radius_m = 0.0;
};

struct ObjectMatch {
  std::size_t truth = 0;  ///< index
  std::size_t found = 0;  ///< index
  double centroid_error_m = 0.0;
};

/// Pairs truth and findings one to one, nearest first. A pair's centroids lie within the true
/// object's equivalent radius, or one cell where that is more.
[[nodiscard]] std::vector<ObjectMatch> match_objects(const std::vector<IceObject>& found,
                                                     const std::vector<TruthObject>& truth,
                                                     double cell_m);

}  // namespace watersky::ice
