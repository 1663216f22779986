// SPDX-License-Identifier: MIT
#include "watersky/sim/aircraft.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {
namespace {

constexpr double kGravity_m_s2 = 9.81;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSteepestBank_rad = 70.0 * kDegree;
constexpr double kRollIn_s = 1.0;

Eigen::Vector2d moved(double north, double east, double azimuth, double curvature, double s) {
  if (curvature == 0.0) return {north + s * std::cos(azimuth), east + s * std::sin(azimuth)};
  const double end = azimuth + curvature * s;
  return {north + (std::sin(end) - std::sin(azimuth)) / curvature,
          east - (std::cos(end) - std::cos(azimuth)) / curvature};
}

}  // namespace

Result<Aircraft> Aircraft::make(const AircraftParameters& parameters, std::uint64_t seed) {
  WATERSKY_CHECK(validate(parameters));
  Aircraft aircraft(parameters, seed);
  if (parameters.hover.hovers) {
    WATERSKY_TRY(aircraft.hover_, Hover::make(parameters.hover, mix(seed, 6)));
    return aircraft;
  }
  if (aircraft.bank(1.0 / parameters.turn_radius_m) > kSteepestBank_rad)
    return Error{ErrorCode::Usage,
                 "at speed_m_s the turns would need more than 70 deg of bank; raise turn_radius_m"};
  return aircraft;
}

Aircraft::Aircraft(const AircraftParameters& p, std::uint64_t seed)
    : p_(p),
      roll_(mix(seed, 1), p.gust_roll_deg * kDegree, p.gust_band_hz),
      pitch_(mix(seed, 2), p.gust_pitch_deg * kDegree, p.gust_band_hz),
      yaw_(mix(seed, 3), p.gust_yaw_deg * kDegree, p.gust_band_hz),
      up_(mix(seed, 4), p.gust_height_m, 0.25 * p.gust_band_hz),
      aside_(mix(seed, 5), p.gust_aside_m, 0.25 * p.gust_band_hz) {
  const double azimuth = p.leg_azimuth_deg * kDegree;
  const Eigen::Vector2d along(std::cos(azimuth), std::sin(azimuth)), right(-along.y(), along.x());
  const Eigen::Vector2d start = Eigen::Vector2d(p.survey_north_m, p.survey_east_m) -
                                0.5 * p.leg_length_m * along -
                                0.5 * (p.legs - 1) * p.leg_spacing_m * right;
  segments_.push_back({0.0, p.leg_length_m, 0.0, start.x(), start.y(), azimuth, 0.0, true});
  const double radius = p.turn_radius_m, half_turn = std::numbers::pi;
  for (int leg = 1; leg < p.legs; ++leg) {
    const double side = leg % 2 == 1 ? 1.0 / radius : -1.0 / radius;
    if (p.leg_spacing_m >= 2.0 * radius) {
      append(0.5 * half_turn * radius, side, false);
      append(p.leg_spacing_m - 2.0 * radius, 0.0, false);
      append(0.5 * half_turn * radius, side, false);
    } else {
      // Out to the far side, round, and back: the three circles touch when the middles of the
      // outer two are spacing + 2 radii apart and each lies 2 radii from the middle one's.
      const double out = std::acos((0.5 * p.leg_spacing_m + radius) / (2.0 * radius));
      append(out * radius, -side, false);
      append((half_turn + 2.0 * out) * radius, side, false);
      append(out * radius, -side, false);
    }
    append(p.leg_length_m, 0.0, true);
  }
}

void Aircraft::append(double length_m, double curvature, bool leg) {
  const Segment& last = segments_.back();
  const Eigen::Vector2d start =
      moved(last.north_m, last.east_m, last.azimuth_rad, last.curvature_1_m, last.length_m);
  segments_.push_back({last.start_m + last.length_m, length_m, curvature, start.x(), start.y(),
                       last.azimuth_rad + last.curvature_1_m * last.length_m,
                       last.bank_integral + last.length_m * bank(last.curvature_1_m), leg});
}

double Aircraft::bank(double curvature) const {
  return std::atan(p_.speed_m_s * p_.speed_m_s * curvature / kGravity_m_s2);
}

const Aircraft::Segment& Aircraft::segment_at(double along_m) const {
  const auto after = std::upper_bound(segments_.begin(), segments_.end(), along_m,
                                      [](double s, const Segment& x) { return s < x.start_m; });
  return after == segments_.begin() ? segments_.front() : *(after - 1);
}

double Aircraft::bank_integral(double along_m) const {
  const Segment& segment = segment_at(along_m);
  return segment.bank_integral + (along_m - segment.start_m) * bank(segment.curvature_1_m);
}

double Aircraft::duration_s() const {
  if (hover_) return hover_->duration_s();
  return (segments_.back().start_m + segments_.back().length_m) / p_.speed_m_s;
}

AircraftState Aircraft::at(double t_s) const {
  if (hover_) return hover_->at(t_s);
  const double s = t_s * p_.speed_m_s;
  const Segment& segment = segment_at(s);
  const double into = s - segment.start_m;
  const Eigen::Vector2d track =
      moved(segment.north_m, segment.east_m, segment.azimuth_rad, segment.curvature_1_m, into);
  const double course = segment.azimuth_rad + segment.curvature_1_m * into;
  const double aside = aside_.at(t_s);
  const double roll_in_m = kRollIn_s * p_.speed_m_s;
  const double banked =
      (bank_integral(s + 0.5 * roll_in_m) - bank_integral(s - 0.5 * roll_in_m)) / roll_in_m;
  AircraftState state;
  state.north_m = track.x() - aside * std::sin(course);
  state.east_m = track.y() + aside * std::cos(course);
  state.height_m = p_.height_m + up_.at(t_s);
  state.yaw_rad = course + p_.crab_deg * kDegree + yaw_.at(t_s);
  state.pitch_rad = p_.trim_pitch_deg * kDegree + pitch_.at(t_s);
  state.roll_rad = banked + roll_.at(t_s);
  state.course_rad = course;
  state.on_leg = segment.leg && into >= 0.0 && into <= segment.length_m;
  return state;
}

}  // namespace watersky::sim
