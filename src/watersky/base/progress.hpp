// SPDX-License-Identifier: MIT
#pragma once
/// How long work tells its caller how far it is. The library itself never prints.
#include <cstddef>
#include <functional>
#include <string_view>

namespace watersky {

/// Called with the name of the stage, the steps done and the steps in all (0: unknown). Called
/// from the thread that does the work; must be cheap.
using Progress = std::function<void(std::string_view stage, std::size_t done, std::size_t total)>;

inline void report(const Progress& progress, std::string_view stage, std::size_t done,
                   std::size_t total) {
  if (progress) progress(stage, done, total);
}

}  // namespace watersky
