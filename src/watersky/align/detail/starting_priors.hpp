// SPDX-License-Identifier: MIT
#pragma once
/// What is assumed before any image was looked at.
#include <array>

#include "watersky/align/alignment.hpp"
#include "watersky/align/detail/adjustment.hpp"

namespace watersky::align {

/// Shares of the sigmas that are assumed of poses which say nothing of them: how good they are is
/// tried, as exact poses under uneven times look like bad poses under even ones.
constexpr std::array<double, 3> kNavigationIdeas{1.0, 0.2, 0.03};

/// Sigmas of the recorded poses' errors: as said, or, where that is zero, a share of the height and
/// half a degree.
void set_navigation_priors(AdjustmentPriors& priors, const PoseSigma& said, double height_m);

/// All of them but the jitter. `height_m` above the sea, typical; `said` as above.
[[nodiscard]] AdjustmentPriors starting_priors(const Flight& flight, const AlignParameters& p,
                                               const PoseSigma& said, double height_m);

}  // namespace watersky::align
