// SPDX-License-Identifier: MIT
#pragma once
#include <opencv2/core/mat.hpp>

#include "watersky/target_calibration/target.hpp"

namespace watersky::detail {

/// The chessboard in `gray` (CV_8U); its own size where none is asked for. NotFound without one.
[[nodiscard]] Result<DetectedTarget> detect_chessboard(const cv::Mat& gray,
                                                       std::optional<TargetSize> size);

/// How much of the squares' contrast there is already a quarter of the way from a corner to their
/// middles: nearly all on a chessboard, little between circles, among which the detector finds
/// corners too.
[[nodiscard]] double squareness(const cv::Mat& gray, const DetectedTarget& board);

}  // namespace watersky::detail
