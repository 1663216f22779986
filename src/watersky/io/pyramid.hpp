// SPDX-License-Identifier: MIT
#pragma once
/// Rasters at half the size, aware of what was seen.
#include <opencv2/core/mat.hpp>
#include <vector>

namespace watersky {

/// Half the size, rounded up; a cell stands for up to 2 x 2. CV_32F: mean of those not NaN, NaN
/// when all are. CV_8UC4: mean colour of those seen (fourth channel not 0), seen when any is.
/// CV_16U and CV_64F: the north-west one.
[[nodiscard]] cv::Mat halved(const cv::Mat& raster);

/// Halved until the longer side is at most `max_side`, each step kept; empty when it already is.
[[nodiscard]] std::vector<cv::Mat> pyramid(const cv::Mat& raster, int max_side);

}  // namespace watersky
