// SPDX-License-Identifier: MIT
#pragma once
/// What every registrar asks of a picture before it looks at it.
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"

namespace watersky::detail {

/// 8 or 16 bit with 1 or 3 channels, and `valid` CV_8UC1 of its size or empty.
[[nodiscard]] Status check_frame(const cv::Mat& image, const cv::Mat& valid);

/// One channel; the image itself when it has one.
[[nodiscard]] cv::Mat gray_of(const cv::Mat& image);

/// 8 bit; of 16 bit the range that is used, so that 30 counts of contrast are seen.
[[nodiscard]] cv::Mat gray_8_bit(const cv::Mat& image);

}  // namespace watersky::detail
