// SPDX-License-Identifier: MIT
#include "watersky/sim/hover.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
/// Of a swing's reach, what the slow wave takes.
constexpr double kSlowShare = 0.7;

/// Seconds, of x, y, height and heading. At the default reaches the fastest of them together
/// are a little above 0.5 m/s.
struct Periods {
  double slow_from, slow_to, quick_from, quick_to;
};
constexpr std::array<Periods, 4> kPeriods{
    {{12, 17, 6, 9}, {19, 27, 7, 10}, {14, 24, 7, 11}, {9, 16, 4, 7}}};

/// One sigma about each of two axes, of a tilt drawn from the range.
double tilt_rad(const HoverParameters& p, std::uint64_t seed) {
  return Random(mix(seed, 1)).uniform(p.hover_least_tilt_deg, p.hover_most_tilt_deg) * kDegree /
         std::numbers::sqrt2;
}

}  // namespace

double Hover::Swing::at(double t_s) const {
  return kSlowShare * std::sin(slow_rad_s * t_s + slow_phase) +
         (1.0 - kSlowShare) * std::sin(quick_rad_s * t_s + quick_phase);
}

double Hover::Swing::steepest_1_s() const {
  return kSlowShare * slow_rad_s + (1.0 - kSlowShare) * quick_rad_s;
}

Result<Hover> Hover::make(const HoverParameters& parameters, std::uint64_t seed) {
  WATERSKY_CHECK(validate(parameters));
  if (parameters.hover_lowest_m > parameters.hover_highest_m)
    return Error{ErrorCode::Usage, "hover_lowest_m must not be above hover_highest_m"};
  if (parameters.hover_least_tilt_deg > parameters.hover_most_tilt_deg)
    return Error{ErrorCode::Usage, "hover_least_tilt_deg must not be above hover_most_tilt_deg"};
  return Hover(parameters, seed);
}

Hover::Hover(const HoverParameters& p, std::uint64_t seed)
    : p_(p),
      roll_(mix(seed, 2), tilt_rad(p, seed), p.hover_band_hz),
      pitch_(mix(seed, 3), tilt_rad(p, seed), p.hover_band_hz) {
  Random random(mix(seed, 4));
  const auto rad_s = [&](double from, double to) {
    return 2.0 * std::numbers::pi / random.uniform(from, to);
  };
  const auto phase = [&] { return random.uniform(0.0, 2.0 * std::numbers::pi); };
  for (std::size_t i = 0; i < swings_.size(); ++i) {
    const Periods& periods = kPeriods[i];
    swings_[i].slow_rad_s = rad_s(periods.slow_from, periods.slow_to);
    swings_[i].quick_rad_s = rad_s(periods.quick_from, periods.quick_to);
    swings_[i].slow_phase = phase();
    swings_[i].quick_phase = phase();
  }
  const double fastest_m_s = std::hypot(
      p.hover_reach_x_m * swings_[0].steepest_1_s(), p.hover_reach_y_m * swings_[1].steepest_1_s(),
      0.5 * (p.hover_highest_m - p.hover_lowest_m) * swings_[2].steepest_1_s());
  const double slower = fastest_m_s > p.hover_speed_m_s ? p.hover_speed_m_s / fastest_m_s : 1.0;
  for (Swing& swing : swings_) {
    swing.slow_rad_s *= slower;
    swing.quick_rad_s *= slower;
  }
}

AircraftState Hover::at(double t_s) const {
  const double x = p_.hover_x_m + p_.hover_reach_x_m * swings_[0].at(t_s);
  const double y = p_.hover_y_m + p_.hover_reach_y_m * swings_[1].at(t_s);
  const double azimuth = p_.hover_azimuth_deg * kDegree;
  AircraftState state;
  state.north_m = x * std::cos(azimuth) - y * std::sin(azimuth);
  state.east_m = x * std::sin(azimuth) + y * std::cos(azimuth);
  state.height_m = 0.5 * (p_.hover_lowest_m + p_.hover_highest_m) +
                   0.5 * (p_.hover_highest_m - p_.hover_lowest_m) * swings_[2].at(t_s);
  state.course_rad = azimuth + p_.hover_yaw_deg * kDegree;
  state.yaw_rad = state.course_rad + p_.hover_reach_yaw_deg * kDegree * swings_[3].at(t_s);
  state.roll_rad = roll_.at(t_s);
  state.pitch_rad = pitch_.at(t_s);
  state.on_leg = true;
  return state;
}

}  // namespace watersky::sim
