// SPDX-License-Identifier: MIT
#pragma once
/// What was found of what all frames share, by name.
#include "watersky/align/alignment.hpp"
#include "watersky/align/detail/adjustment.hpp"

namespace watersky::align {

/// What was looked for has been observed once its sigma is this share of what it was: with less,
/// one flight in a few would be better off with what was given.
inline constexpr double kObserved = 0.25;

/// `before`: the sigmas of the globals at the start; 0: not looked for. `known`: null where nothing
/// was solved, then all stays as it was given.
[[nodiscard]] std::vector<Estimate> estimates_of(const Flight& flight, const Adjustment& adjustment,
                                                 const Globals::Vector& before,
                                                 const Adjustment::Knowledge* known);

/// The mount with what was found; its sigma where something is known.
[[nodiscard]] Mount corrected_mount(const Mount& given, const Adjustment& adjustment,
                                    const Adjustment::Knowledge* known);

}  // namespace watersky::align
