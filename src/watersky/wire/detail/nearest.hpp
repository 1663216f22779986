// SPDX-License-Identifier: MIT
#pragma once
#include <cmath>
#include <limits>
#include <type_traits>

namespace watersky::detail {

/// `value` as a T: floating point as it is, whole numbers the nearest, beyond the range of T its
/// nearest end, NaN zero.
template <class T>
[[nodiscard]] T nearest(double value) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    if (std::isnan(value)) return 0;
    // The largest 64 bit values are no doubles: comparing with their rounded-up double keeps the
    // cast below in range.
    constexpr auto kLow = std::numeric_limits<T>::min();
    constexpr auto kHigh = std::numeric_limits<T>::max();
    const double whole = std::nearbyint(value);
    return whole <= static_cast<double>(kLow)    ? kLow
           : whole >= static_cast<double>(kHigh) ? kHigh
                                                 : static_cast<T>(whole);
  }
}

}  // namespace watersky::detail
