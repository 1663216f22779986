// SPDX-License-Identifier: MIT
#pragma once
/// The middle of numbers, or any other share of them.
#include <algorithm>
#include <cmath>
#include <vector>

namespace watersky::align {

/// The value that `share` of them lie below, one of them; 0 of none.
[[nodiscard]] inline double median(std::vector<double> v, double share = 0.5) {
  if (v.empty()) return 0.0;
  const auto at = v.begin() + std::lround(share * static_cast<double>(v.size() - 1));
  std::nth_element(v.begin(), at, v.end());
  return *at;
}

}  // namespace watersky::align
