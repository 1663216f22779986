// SPDX-License-Identifier: MIT
#pragma once
/// Outlines along cell edges.
#include <opencv2/core/mat.hpp>
#include <vector>

namespace watersky::ice::detail {

/// A simple closed line over corners of cells: corner (x, y) is the north-west corner of cell
/// (x, y). `signed_area_cells` is positive for an outer line, negative for a hole.
struct CornerRing {
  int piece = 0;  ///< label of the 4-connected piece it bounds
  std::vector<cv::Point> corners;
  double signed_area_cells = 0.0;
  double edge_cells = 0.0;  ///< length
};

/// All outlines of the ice in `ice` (CV_8U, 255 ice, 0 not; its outermost rows and columns must
/// be 0), with ice on the left seen from above. `pieces` (CV_32S) labels its 4-connected pieces.
/// Each piece has exactly one outer line; lines that would touch themselves are parted there.
/// Changes `ice` (255 becomes 254 where a line ran along a cell's north edge).
[[nodiscard]] std::vector<CornerRing> trace_outlines(cv::Mat& ice, const cv::Mat& pieces);

}  // namespace watersky::ice::detail
