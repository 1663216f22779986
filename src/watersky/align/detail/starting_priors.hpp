// SPDX-License-Identifier: MIT
#pragma once
/// What is assumed before any image was looked at.
#include <array>
#include <utility>

#include "watersky/align/alignment.hpp"
#include "watersky/align/detail/adjustment.hpp"

namespace watersky::align {

/// How far a camera's clock wanders against the poses', per root second.
constexpr double kClockWalk_s = 1e-4;

/// One place of eight takes no part in the adjustment: it judges.
[[nodiscard]] constexpr bool judges(int place) { return place % 8 == 7; }

/// Shares of the sigmas that are assumed of poses which say nothing of them: how good they are is
/// tried, as exact poses under uneven times look like bad poses under even ones.
constexpr std::array<double, 3> kNavigationIdeas{1.0, 0.2, 0.03};

/// Correlation times of positions' and attitudes' errors, s, that are tried: satellite navigation
/// with an attitude filter, the default, and what wanders within seconds.
constexpr std::array<std::pair<double, double>, 2> kCorrelationIdeas_s{{{30.0, 10.0}, {2.0, 2.0}}};

/// Ties share errors (those of their place's first sighting, of tracking, of compressed pictures),
/// so evidence counts the same news many times, and looser poses always explain some of it. Of
/// these ideas, which trust the poses ever more, the last one counts whose evidence is within this
/// of the best, per tie. Measured on simulated flights: exact poses wrongly taken for bad gain at
/// most 0.017, bad ones rightly above 1 (docs/decisions/0013).
constexpr double kSameNavigation = 0.02;

/// Sigmas of the recorded poses' errors: as said, or, where that is zero, a share of the height and
/// half a degree.
void set_navigation_priors(AdjustmentPriors& priors, const PoseSigma& said, double height_m);

/// All of them but the jitter. `height_m` above the sea, typical; `said` as above.
[[nodiscard]] AdjustmentPriors starting_priors(const Flight& flight, const AlignParameters& p,
                                               const PoseSigma& said, double height_m);

}  // namespace watersky::align
