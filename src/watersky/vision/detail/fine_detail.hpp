// SPDX-License-Identifier: MIT
#pragma once
/// What half the image's size leaves out: narrow leads, brash, the pixel at an edge.
///
/// The networks work at half size. A pixel that is brighter than the half-size picture says is a
/// little more likely what bright pixels are: its log-odds move by a learned weight times the
/// difference, less where the difference is mostly the camera's noise.
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "watersky/vision/detail/ice_features.hpp"

namespace watersky::detail {

/// The differences, times what noise leaves of their worth. `gray`: CV_8UC1, CV_16UC1 or CV_32FC1
/// at the image's size, in the levels of `scene`.
class FineDetail {
 public:
  FineDetail(const cv::Mat& gray, const IceScene& scene, const LevelStatistics& levels);

  /// P(ice) at the image's size from `p_half` at half of it.
  [[nodiscard]] cv::Mat applied_to(const cv::Mat& p_half, float weight) const;
  /// One row of the differences, and of `p_half` enlarged: image width each.
  void row(const cv::Mat& p_half, int y, std::vector<float>& p, std::vector<float>& detail) const;

 private:
  cv::Mat smooth_;  ///< the image, averaged over 3x3
  cv::Mat half_;
  float scale_ = 0.0F;
};

/// Pixels to learn the weight from.
struct DetailSample {
  float p = 0.5F;
  float detail = 0.0F;
  float ice = 0.0F;  ///< truth, 0 or 1
};
/// Logistic regression of one number. Never below 0: a bright pixel is not less like bright ones.
[[nodiscard]] float fit_detail_weight(std::span<const DetailSample> samples);

}  // namespace watersky::detail
