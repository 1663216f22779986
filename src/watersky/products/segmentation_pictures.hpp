// SPDX-License-Identifier: MIT
#pragma once
/// What a segmented image looks like to a person.
#include <opencv2/core/mat.hpp>

#include "watersky/products/palette.hpp"

namespace watersky {

/// Water is tinted as deeply as it is sure; ice keeps its looks.
inline constexpr Rgb kWaterTint{0, 60, 140};
inline constexpr Rgb kIceOutline{255, 120, 0};
/// Stripes where P(ice) is between 0.4 and 0.6.
inline constexpr Rgb kUnsureStripes{240, 228, 66};
/// Stripes where nothing is known.
inline constexpr Rgb kUnknownStripes{204, 121, 167};
inline constexpr Rgb kFalseIce{213, 94, 0};
inline constexpr Rgb kMissedIce{86, 180, 233};

/// A picture to show: BGR, 8 bit. 16-bit levels are stretched from their 1 % to their 99 %
/// quantile.
[[nodiscard]] cv::Mat displayed(const cv::Mat& image);

/// The image with its water tinted, its ice outlined at P(ice) = 1/2, and stripes where the
/// answer is unsure or unknown. `image`: as segmented; `p_ice`: CV_32F of its size, NaN where not
/// known. Returns CV_8UC3.
[[nodiscard]] cv::Mat overlay_picture(const cv::Mat& image, const cv::Mat& p_ice);

/// The image, grey, with what is wrong in colour: kFalseIce where water was called ice,
/// kMissedIce where ice was called water, kUnknownStripes where nothing was said. `ice`: CV_8U,
/// not 0 where the truth is ice; `judged` as in score_segmentation.
[[nodiscard]] cv::Mat error_picture(const cv::Mat& image, const cv::Mat& p_ice, const cv::Mat& ice,
                                    const cv::Mat& judged = {});

/// P(ice) as a file holds it: CV_8U, round(255 P), 128 where it is not known.
[[nodiscard]] cv::Mat probability_picture(const cv::Mat& p_ice);
inline constexpr unsigned char kUnknownProbability = 128;

/// 255 where P(ice) is not known; empty when it is everywhere.
[[nodiscard]] cv::Mat unknown_picture(const cv::Mat& p_ice);

}  // namespace watersky
