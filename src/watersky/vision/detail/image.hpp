// SPDX-License-Identifier: MIT
#pragma once
/// What every segmenter asks of an image before it looks at it.
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"

namespace watersky::detail {

/// 8 or 16 bit with 1 or 3 channels, and `valid` CV_8UC1 of its size or empty.
[[nodiscard]] Status check_image(const cv::Mat& image, const cv::Mat& valid);

/// One channel; the image itself when it has one.
[[nodiscard]] cv::Mat luminance(const cv::Mat& image);

/// Whether channels differ by more than a camera's tint does.
[[nodiscard]] bool colourful(const cv::Mat& image);

/// Levels as 8 bit: `low` to 0 and `high` to 255, beyond them the ends. An 8-bit image comes back
/// as it is.
[[nodiscard]] cv::Mat to_8_bit(const cv::Mat& gray, double low, double high);

}  // namespace watersky::detail
