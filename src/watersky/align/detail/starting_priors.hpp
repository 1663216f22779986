// SPDX-License-Identifier: MIT
#pragma once
/// What is assumed before any image was looked at.
#include "watersky/align/alignment.hpp"
#include "watersky/align/detail/adjustment.hpp"

namespace watersky::align {

/// Sigmas of the recorded poses' errors: as said, or, where that is zero, a share of the height and
/// half a degree.
void set_navigation_priors(AdjustmentPriors& priors, const PoseSigma& said, double height_m);

/// All of them but the jitter. `height_m` above the sea, typical; `said` as above.
[[nodiscard]] AdjustmentPriors starting_priors(const Flight& flight, const AlignParameters& p,
                                               const PoseSigma& said, double height_m);

/// One sigma of frames' own delays, from their arrivals and the even times under them.
[[nodiscard]] double arrival_jitter_s(const std::vector<double>& received_s,
                                      const std::vector<double>& even_s);

}  // namespace watersky::align
