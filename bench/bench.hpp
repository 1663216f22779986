// SPDX-License-Identifier: MIT
#pragma once
/// What all benchmarks share: a stopwatch, and one JSON line a figure.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
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

/// Processor time of this thread for one call, seconds: what else the machine does counts less. For
/// bodies that start no threads.
template <class Body>
double cpu_seconds_of(const Body& body) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double start = now();
  body();
  return now() - start;
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

}  // namespace watersky::bench
