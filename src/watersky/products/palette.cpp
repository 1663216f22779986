// SPDX-License-Identifier: MIT
#include "watersky/products/palette.hpp"

#include <cmath>
#include <cstdio>

namespace watersky {

std::string hex(const Rgb& color) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", color.red, color.green, color.blue);
  return text;
}

Rgb color_at(Ramp ramp, double position) {
  if (!(position > ramp.front().at)) return ramp.front().color;
  for (std::size_t i = 1; i < ramp.size(); ++i) {
    if (position > ramp[i].at) continue;
    const double t = (position - ramp[i - 1].at) / (ramp[i].at - ramp[i - 1].at);
    const auto mix = [t](std::uint8_t a, std::uint8_t b) {
      return static_cast<std::uint8_t>(std::lround(a + t * (b - a)));
    };
    const Rgb& a = ramp[i - 1].color;
    const Rgb& b = ramp[i].color;
    return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
  }
  return ramp.back().color;
}

}  // namespace watersky
