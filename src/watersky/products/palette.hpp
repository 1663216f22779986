// SPDX-License-Identifier: MIT
#pragma once
/// The colours of every picture we draw, in one place: report, QGIS styles and GeoPackage agree.
/// Ramps grow in lightness from end to end, so they read alike with any colour vision and in
/// grey; single colours are Okabe and Ito's.
#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace watersky {

struct Rgb {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  bool operator==(const Rgb&) const = default;
};

/// "#08306b".
[[nodiscard]] std::string hex(const Rgb& color);

struct RampStop {
  double at = 0.0;  ///< from 0 to 1
  Rgb color;
};
using Ramp = std::span<const RampStop>;

/// P(ice): open water dark blue, ice nearly white.
inline constexpr std::array<RampStop, 6> kProbabilityRamp{{{0.0, {8, 29, 64}},
                                                           {0.2, {20, 62, 110}},
                                                           {0.4, {44, 105, 150}},
                                                           {0.6, {104, 158, 189}},
                                                           {0.8, {177, 211, 224}},
                                                           {1.0, {247, 252, 255}}}};

/// Looks and times, few or early to many or late: cividis, sampled.
inline constexpr std::array<RampStop, 6> kCountRamp{{{0.0, {0, 34, 78}},
                                                     {0.2, {53, 69, 107}},
                                                     {0.4, {102, 105, 112}},
                                                     {0.6, {148, 142, 119}},
                                                     {0.8, {200, 184, 102}},
                                                     {1.0, {254, 232, 56}}}};

inline constexpr Rgb kTrackColor{213, 94, 0};       ///< vermilion
inline constexpr Rgb kFootprintColor{230, 159, 0};  ///< orange
inline constexpr Rgb kFloeColor{0, 158, 115};       ///< bluish green
inline constexpr Rgb kIcebergColor{204, 121, 167};  ///< reddish purple

/// The colour at a position from 0 to 1, straight between stops; beyond the ends, the ends.
[[nodiscard]] Rgb color_at(Ramp ramp, double position);

}  // namespace watersky
