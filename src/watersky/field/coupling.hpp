// SPDX-License-Identifier: MIT
#pragma once
/// How strongly neighbouring cells hold together, from the map itself.
#include <cstddef>
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"
#include "watersky/field/ising.hpp"

namespace watersky::field {

struct CouplingEstimate {
  double coupling = 0.0;  ///< 0 when nothing was seen
  std::size_t cells = 0;  ///< seen cells that were asked
};

/// The coupling by which the other cells best foretell what each cell showed: the maximum of the
/// mean of log P(evidence of i | evidence of all the others). It is a pseudo-likelihood (Besag
/// 1975) of the evidence, not of labels: those of a thin map are mostly noise. P(ice) of a cell by
/// all the others is what belief propagation tells it, so one run a coupling judges all cells.
///
/// Up to 16 windows of 128 cells stand for a larger map. Evidence that errs alike in neighbouring
/// cells looks like ice that holds together, and makes the estimate too large.
[[nodiscard]] Result<CouplingEstimate> estimate_coupling(const cv::Mat& log_odds);

}  // namespace watersky::field
