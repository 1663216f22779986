// SPDX-License-Identifier: MIT
#include "watersky/ice/concentration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "watersky/base/contract.hpp"

namespace watersky::ice {

Concentration concentration(const cv::Mat& probability, double cell_m, double threshold) {
  WATERSKY_REQUIRE(probability.empty() || probability.type() == CV_32F);
  std::size_t seen = 0;
  std::size_t ice = 0;
  double sum = 0;
  for (int r = 0; r < probability.rows; ++r) {
    const float* p = probability.ptr<float>(r);
    int row_seen = 0;
    int row_ice = 0;
    double row_sum = 0;
    for (int c = 0; c < probability.cols; ++c) {
      const bool known = p[c] == p[c];
      row_seen += known ? 1 : 0;
      row_ice += p[c] > threshold ? 1 : 0;
      row_sum += known ? static_cast<double>(p[c]) : 0.0;
    }
    seen += static_cast<std::size_t>(row_seen);
    ice += static_cast<std::size_t>(row_ice);
    sum += row_sum;
  }
  Concentration result;
  result.seen_cells = seen;
  result.seen_area_m2 = static_cast<double>(seen) * cell_m * cell_m;
  const double n = static_cast<double>(seen);
  result.expected = seen ? sum / n : std::numeric_limits<double>::quiet_NaN();
  result.thresholded =
      seen ? static_cast<double>(ice) / n : std::numeric_limits<double>::quiet_NaN();
  return result;
}

cv::Mat concentration_blocks(const cv::Mat& probability, int block_cells,
                             double min_seen_fraction) {
  WATERSKY_REQUIRE(probability.empty() || probability.type() == CV_32F);
  WATERSKY_REQUIRE(block_cells > 0);
  const int rows = (probability.rows + block_cells - 1) / block_cells;
  const int columns = (probability.cols + block_cells - 1) / block_cells;
  cv::Mat result(rows, columns, CV_32F, cv::Scalar(std::nan("")));
  for (int br = 0; br < rows; ++br) {
    for (int bc = 0; bc < columns; ++bc) {
      const int end_row = std::min((br + 1) * block_cells, probability.rows);
      const int end_column = std::min((bc + 1) * block_cells, probability.cols);
      int cells = 0;
      int seen = 0;
      double sum = 0;
      for (int r = br * block_cells; r < end_row; ++r) {
        for (int c = bc * block_cells; c < end_column; ++c) {
          const float p = probability.at<float>(r, c);
          ++cells;
          if (!std::isnan(p)) {
            ++seen;
            sum += static_cast<double>(p);
          }
        }
      }
      if (seen > 0 && seen >= min_seen_fraction * cells)
        result.at<float>(br, bc) = static_cast<float>(sum / seen);
    }
  }
  return result;
}

}  // namespace watersky::ice
