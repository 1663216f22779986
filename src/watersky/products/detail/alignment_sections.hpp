// SPDX-License-Identifier: MIT
#pragma once
/// Parts that the report of an alignment and that of a map have in common.
#include <string>

#include "watersky/products/alignment_run.hpp"

namespace watersky::detail {

/// How far apart the frames' ideas of one place are: as given, with a constant delay, after.
[[nodiscard]] std::string disagreement_table(const Alignment& alignment);

/// Each quantity that was looked for: given, found, one sigma before and after.
[[nodiscard]] std::string estimates_table(const Alignment& alignment);

/// The delay's course with its sigma, and each frame's own; empty when none was estimated.
[[nodiscard]] std::string delay_chart(const AlignmentRun& run);

/// Position and attitude that were found to be wrong, over time; empty when nothing was.
[[nodiscard]] std::string corrections_charts(const AlignmentRun& run);

/// "0.252 ± 0.003 s".
[[nodiscard]] std::string with_sigma(double value, double sigma, const std::string& unit);

/// All of these in short, for the report of a map.
[[nodiscard]] std::string alignment_section(const AlignmentRun& run);

}  // namespace watersky::detail
