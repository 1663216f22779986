// SPDX-License-Identifier: MIT
#pragma once
/// Parts of every picture that show neither water nor ice: the aircraft's own parts, the bow of
/// the ship, a caption.
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"

namespace watersky {

/// A user's mask as Segmenter wants it: `mask` of any image type in the camera's full size, 0 (in
/// all channels) where the picture is not to be used. Of the size of a reduced image, a pixel is
/// valid only if all that it was made of is. InvalidInput when the mask covers another field
/// (its size is no whole multiple of `size`, give or take the rest of a reduction) or all of it.
[[nodiscard]] Result<cv::Mat> valid_from_mask(const cv::Mat& mask, cv::Size size);

/// Valid in both; either may be empty: all valid.
[[nodiscard]] cv::Mat both_valid(const cv::Mat& a, const cv::Mat& b);

}  // namespace watersky
