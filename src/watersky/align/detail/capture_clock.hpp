// SPDX-License-Identifier: MIT
#pragma once
/// The regular clock behind frames that carry a counter.
#include <cstdint>
#include <optional>
#include <vector>

namespace watersky::align {

/// captured = start + period counter, up to a constant delay.
struct CaptureClock {
  double start_s = 0.0, period_s = 0.0;
  double jitter_s = 0.0;  ///< one sigma of the arrivals about their middle course
};

/// The line under the arrivals: nothing arrives before it was captured, so the earliest arrivals
/// tell the clock and the others how late they were. nullopt for fewer than 8 frames, or
/// counters that do not rise.
[[nodiscard]] std::optional<CaptureClock> fit_capture_clock(
    const std::vector<std::uint64_t>& counters, const std::vector<double>& received_s);

}  // namespace watersky::align
