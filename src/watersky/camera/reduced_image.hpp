// SPDX-License-Identifier: MIT
#pragma once
/// Images reduced as CameraModel::reduced_by() describes them.
#include <opencv2/core/mat.hpp>

namespace watersky {

/// Each pixel the mean of a whole block of n x n, as JPEG decoders do it; the last blocks are
/// filled up with the image's edge.
[[nodiscard]] cv::Mat reduced_by(const cv::Mat& image, int n);

}  // namespace watersky
