// SPDX-License-Identifier: MIT
#pragma once
/// Rasters as pictures inside a page.
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/products/palette.hpp"

namespace watersky::detail {

/// Index 0 is transparent, 1 to 255 run along the ramp.
[[nodiscard]] Result<std::string> png_data_uri(const cv::Mat& index, Ramp ramp);

/// A grey picture, for SVG masks: 0 and 255.
[[nodiscard]] Result<std::string> mask_data_uri(const cv::Mat& mask);

/// A JPEG that is made already.
[[nodiscard]] std::string jpeg_data_uri(const std::string& jpeg);

/// JPEG, quality 82; the fourth channel is dropped.
[[nodiscard]] Result<std::string> jpeg_data_uri(const cv::Mat& bgra);

}  // namespace watersky::detail
