// SPDX-License-Identifier: MIT
#pragma once
/// P(ice) of each cell by the Ising model: what its own looks and all its neighbours say together.
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"
#include "watersky/field/ising.hpp"

namespace watersky::field {

struct Marginals {
  cv::Mat probability;  ///< CV_32F; NaN where `log_odds` is
  int iterations = 0;
  double last_change = 0.0;  ///< the largest of a P(ice), in the last iteration
};

/// Loopy belief propagation (Pearl 1988; Murphy, Weiss and Jordan 1999): each iteration visits
/// every cell once, until no P(ice) changes by more than `tolerance`. More evidence of ice makes
/// no message say less ice, so there is no oscillation to damp. With coupling 0 P(ice) is that of
/// the log-odds to the bit.
///
/// It is not exact where cells form loops. Against enumeration on 4 x 4 cells and against mean
/// field: experiments/smoothing, docs/smoothing.md. Takes 40 bytes a cell.
[[nodiscard]] Result<Marginals> marginals(const cv::Mat& log_odds, double coupling,
                                          int max_iterations = 100, double tolerance = 1e-3);

}  // namespace watersky::field
