// SPDX-License-Identifier: MIT
#pragma once
/// What all benchmarks share: a stopwatch, and one JSON line a figure.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

namespace watersky::bench {

/// {"name":…, "value":…, "unit":…}; names are dotted and never change.
inline void print_figure(const char* name, double value, const char* unit) {
  std::printf("{\"name\":\"%s\", \"value\":%.6g, \"unit\":\"%s\"}\n", name, value, unit);
  std::fflush(stdout);
}

/// Wall time of one call, seconds.
template <class Body>
double seconds_of(const Body& body) {
  const auto start = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

}  // namespace watersky::bench
