// SPDX-License-Identifier: MIT
#pragma once
/// What the smoothing could have been made of instead.
#include <cstddef>
#include <opencv2/core/mat.hpp>

namespace watersky::study {

/// P(ice) by naive mean field, half of each step taken, until no P(ice) changes by more than 1e-3
/// or for 200 iterations. CV_32F, NaN where `log_odds` is.
[[nodiscard]] cv::Mat mean_field(const cv::Mat& log_odds, double coupling);

struct BoostCut {
  cv::Mat labels;         ///< CV_8U: 1 ice, 0 water; 255 where `log_odds` is NaN
  std::size_t bytes = 0;  ///< of the graph
};
/// The most likely map by boost::boykov_kolmogorov_max_flow, all cells at once.
[[nodiscard]] BoostCut boost_cut(const cv::Mat& log_odds, double coupling);

}  // namespace watersky::study
