// SPDX-License-Identifier: MIT
#pragma once
/// What experiments say of many values.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace watersky::study {

/// The value that a share of the finite ones does not exceed, linear in between; NaN without one.
[[nodiscard]] inline double quantile(std::vector<double> values, double share) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - std::floor(at)) * (values[above] - values[below]);
}

[[nodiscard]] inline double median(std::vector<double> values) {
  return quantile(std::move(values), 0.5);
}

/// NaN without values.
[[nodiscard]] inline double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

/// NaN where a value is not finite: what a contender cannot do once, it cannot do at worst.
[[nodiscard]] inline double largest(const std::vector<double>& values) {
  if (values.empty()) return std::nan("");
  for (const double v : values)
    if (!std::isfinite(v)) return std::nan("");
  return *std::max_element(values.begin(), values.end());
}

[[nodiscard]] inline double smallest(const std::vector<double>& values) {
  std::vector<double> negative;
  negative.reserve(values.size());
  for (const double v : values) negative.push_back(-v);
  return -largest(negative);
}

/// One value of each.
template <class Thing, class Value>
[[nodiscard]] std::vector<double> each(const std::vector<Thing>& things, Value value) {
  std::vector<double> out;
  out.reserve(things.size());
  for (const Thing& thing : things) out.push_back(value(thing));
  return out;
}

}  // namespace watersky::study
