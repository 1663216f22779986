// SPDX-License-Identifier: MIT
#pragma once
/// What a thermal camera's counts mean. Never guessed: a file's own calibration says it, or a
/// person does; else counts are counts.
#include <variant>

#include "watersky/base/result.hpp"

namespace watersky {

/// kelvin = kelvin_per_count · counts + kelvin_at_zero. FLIR's TLinear is 0.04 or 0.01 K a count
/// from 0 K.
struct LinearThermalScale {
  double kelvin_per_count = 0.01;
  double kelvin_at_zero = 0.0;
};

/// FLIR's form of Planck's law: counts = r1 / (r2 (exp(b / kelvin) - f)) - o. It gives the
/// temperature that a black body would have, without the air in between.
struct PlanckThermalScale {
  double r1 = 0.0, b = 0.0, f = 1.0, o = 0.0, r2 = 0.0;
};

using ThermalScale = std::variant<LinearThermalScale, PlanckThermalScale>;

/// OutOfRange for counts that no temperature above 0 K makes.
[[nodiscard]] Result<double> kelvin_of(double counts, const ThermalScale& scale);
/// The inverse.
[[nodiscard]] Result<double> counts_of(double kelvin, const ThermalScale& scale);

}  // namespace watersky
