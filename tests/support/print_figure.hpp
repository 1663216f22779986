// SPDX-License-Identifier: MIT
#pragma once
/// How experiments print a figure.
#include <cmath>
#include <cstdio>
#include <string>

namespace watersky::study {

/// {"name":…, "value":…, "unit":…}; names are dotted and never change. Not finite: null.
inline void print_figure(const std::string& name, double value, const char* unit = "1") {
  if (std::isfinite(value)) {
    std::printf("{\"name\": \"%s\", \"value\": %.6g, \"unit\": \"%s\"}\n", name.c_str(), value,
                unit);
  } else {
    std::printf("{\"name\": \"%s\", \"value\": null, \"unit\": \"%s\"}\n", name.c_str(), unit);
  }
  std::fflush(stdout);
}

}  // namespace watersky::study
