// SPDX-License-Identifier: MIT
#pragma once
/// Ice concentration (CF `sea_ice_area_fraction`): the fraction of the sea that ice covers.
/// Melt ponds count as whatever the segmentation took them for.
#include <cstddef>
#include <opencv2/core/mat.hpp>

namespace watersky::ice {

struct Concentration {
  std::size_t seen_cells = 0;
  double seen_area_m2 = 0.0;
  /// The mean of P(ice) over the seen cells: the expected fraction. NaN when nothing was seen.
  double expected = 0.0;
  /// The fraction of the seen cells with P(ice) above the threshold. NaN when nothing was seen.
  double thresholded = 0.0;
};

/// Over all cells seen. `probability`: CV_32F, NaN where never seen. What was not seen counts
/// neither as ice nor as water.
[[nodiscard]] Concentration concentration(const cv::Mat& probability, double cell_m,
                                          double threshold = 0.5);

/// Expected concentration per block of `block_cells` x `block_cells` cells from the north-west
/// corner, CV_32F; the last column and row of blocks may be cut. NaN where less than
/// `min_seen_fraction` of a block's cells was seen.
[[nodiscard]] cv::Mat concentration_blocks(const cv::Mat& probability, int block_cells,
                                           double min_seen_fraction = 0.5);

}  // namespace watersky::ice
