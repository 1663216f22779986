// SPDX-License-Identifier: MIT
#pragma once
/// Planes at twice their size, row by row, as cv::resize by two interpolates them.
#include <opencv2/core/mat.hpp>

namespace watersky::detail {

/// Row `y` of `half` (CV_32FC1) at twice its size: 2 * half.cols values into `row`, with `between`
/// for half.cols values on the way.
void enlarged_row(const cv::Mat& half, int y, float* between, float* row);

}  // namespace watersky::detail
