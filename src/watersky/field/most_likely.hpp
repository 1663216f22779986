// SPDX-License-Identifier: MIT
#pragma once
/// The most likely map of the Ising model: one map as a whole, not the likeliest label of each
/// cell.
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"
#include "watersky/field/ising.hpp"

namespace watersky::field {

/// The map of least energy: CV_8U, 1 ice, 0 water, kUnseen where `log_odds` (CV_32F) is NaN. Among
/// several of the same energy the one with the least ice, so that a cell at even odds is water, as
/// where P(ice) > 1/2 is asked for.
///
/// A minimum cut (Greig, Porteous and Seheult 1989) is exact for two labels; log-odds and couplings
/// are rounded to 2^-24 before, and nothing after. Cells that all their neighbours together cannot
/// outvote are decided first, and then those that follow from them, which leaves the optimum as it
/// is; the rest is cut by Boykov and Kolmogorov's algorithm (2004). Takes 57 bytes a cell; how long
/// it takes: experiments/smoothing.
[[nodiscard]] Result<cv::Mat> most_likely(const cv::Mat& log_odds, double coupling);

}  // namespace watersky::field
