// SPDX-License-Identifier: MIT
#pragma once
/// How strongly neighbouring cells hold together, from the map itself.
#include <cstddef>
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"
#include "watersky/field/ising.hpp"

namespace watersky::field {

struct CouplingEstimate {
  double coupling = 0.0;        ///< to smooth with; 0 when nothing was seen
  double best_foretelling = 0;  ///< by which the others best foretell a cell
  std::size_t cells = 0;        ///< seen cells that were asked
};

/// Share of what foretelling can win that the chosen coupling wins.
inline constexpr double kForetellingShare = 0.25;

/// How well the other cells foretell what each cell showed is the mean of log P(evidence of i |
/// evidence of all the others): a pseudo-likelihood (Besag 1975) of the evidence, not of labels,
/// since those of a thin map are mostly noise. P(ice) of a cell by all the others is what belief
/// propagation tells it, so one run a coupling judges all cells.
///
/// Its maximum is not what to smooth with. It makes good for evidence that is worth more than it
/// says, as (2.31) with the thesis's P1 and P2 is, and small floes pay for it: P(ice) is calibrated
/// best there, but the IoU falls by up to 0.16. The chosen coupling is the least that wins
/// kForetellingShare of what the maximum wins over independent cells; where smoothing has nothing
/// to win, that costs the most likely map less than 0.001 of IoU (experiments/smoothing).
///
/// Up to 16 windows of 128 cells stand for a larger map. Evidence that errs alike in neighbouring
/// cells looks like ice that holds together, and makes both couplings too large.
[[nodiscard]] Result<CouplingEstimate> estimate_coupling(const cv::Mat& log_odds);

}  // namespace watersky::field
