// SPDX-License-Identifier: MIT
#pragma once
/// Where the estimate of the delay starts.
#include "watersky/align/detail/adjustment.hpp"

namespace watersky::align {

/// The state of an adjustment with one delay and nothing else.
[[nodiscard]] AdjustmentState without_errors(const Adjustment& adjustment, double delay_s);

struct DelaySearch {
  double given_s = 0.0;  ///< stands where no valley is seen
  double from_s = -0.1, to_s = 0.8;
  std::size_t most_pairs = 400;  ///< of frames
};

/// The delay in a range under which the navigation's motion explains the images' best, by steps of
/// 10 ms. nullopt: none does better than `given_s` by more than a twentieth.
[[nodiscard]] std::optional<double> search_delay(const Adjustment& adjustment,
                                                 const DelaySearch& how);

}  // namespace watersky::align
