// SPDX-License-Identifier: MIT
#include "watersky/flight/thermal_scale.hpp"

#include <cmath>
#include <string>

namespace watersky {
namespace {

Result<double> positive(double x, const char* what) {
  if (x > 0 && std::isfinite(x)) return x;
  return Error{ErrorCode::OutOfRange, std::string(what) + " outside the camera's calibration"};
}

}  // namespace

Result<double> kelvin_of(double counts, const ThermalScale& scale) {
  if (const auto* linear = std::get_if<LinearThermalScale>(&scale))
    return positive(linear->kelvin_per_count * counts + linear->kelvin_at_zero, "counts");
  const auto& p = std::get<PlanckThermalScale>(scale);
  return positive(p.b / std::log(p.r1 / (p.r2 * (counts + p.o)) + p.f), "counts");
}

Result<double> counts_of(double kelvin, const ThermalScale& scale) {
  WATERSKY_CHECK(positive(kelvin, "a temperature"));
  if (const auto* linear = std::get_if<LinearThermalScale>(&scale)) {
    if (linear->kelvin_per_count == 0.0)
      return Error{ErrorCode::InvalidInput, "a scale of 0 K a count"};
    return (kelvin - linear->kelvin_at_zero) / linear->kelvin_per_count;
  }
  const auto& p = std::get<PlanckThermalScale>(scale);
  const double counts = p.r1 / (p.r2 * (std::exp(p.b / kelvin) - p.f)) - p.o;
  if (!std::isfinite(counts))
    return Error{ErrorCode::OutOfRange, "a temperature outside the camera's calibration"};
  return counts;
}

}  // namespace watersky
