// SPDX-License-Identifier: MIT
#pragma once
/// What work costs, whatever else the machine does.
#include <ctime>

namespace watersky {

/// CPU time of the calling thread since it began, s.
[[nodiscard]] inline double thread_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace watersky
