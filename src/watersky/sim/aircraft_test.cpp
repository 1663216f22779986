// SPDX-License-Identifier: MIT
#include "watersky/sim/aircraft.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

AircraftParameters calm() {
  AircraftParameters p;
  p.gust_roll_deg = p.gust_pitch_deg = p.gust_yaw_deg = p.gust_height_m = p.gust_aside_m = 0.0;
  return p;
}

// Two legs of 100 m, 40 m apart, heading east first: the first lies to the north, so that the
// second is to its right.
TEST(Aircraft, FliesItsLegsWhereAHandCalculationPutsThem) {
  AircraftParameters p = calm();
  p.legs = 2;
  p.leg_length_m = 100.0;
  p.leg_spacing_m = 40.0;
  p.leg_azimuth_deg = 90.0;
  p.speed_m_s = 10.0;
  p.turn_radius_m = 20.0;
  p.crab_deg = 0.0;
  const Aircraft aircraft = Aircraft::make(p, 1).value();
  const AircraftState start = aircraft.at(0.0), middle = aircraft.at(5.0);
  EXPECT_NEAR(start.north_m, 20.0, 1e-9);
  EXPECT_NEAR(start.east_m, -50.0, 1e-9);
  EXPECT_NEAR(middle.east_m, 0.0, 1e-9);
  EXPECT_NEAR(middle.yaw_rad, 90.0 * kDegree, 1e-12);
  EXPECT_NEAR(middle.roll_rad, 0.0, 1e-9);
  EXPECT_TRUE(middle.on_leg);
  // A half circle of 20 m: π 20 m. Half way round it is furthest east, flies south, banks right.
  const double half_circle_s = std::numbers::pi * 20.0 / 10.0;
  const AircraftState turning = aircraft.at(10.0 + 0.5 * half_circle_s);
  EXPECT_NEAR(turning.north_m, 0.0, 1e-9);
  EXPECT_NEAR(turning.east_m, 70.0, 1e-9);
  EXPECT_NEAR(turning.course_rad, 180.0 * kDegree, 1e-9);
  EXPECT_NEAR(turning.roll_rad, std::atan(100.0 / 20.0 / 9.81), 1e-9);
  EXPECT_FALSE(turning.on_leg);
  const AircraftState end = aircraft.at(aircraft.duration_s());
  EXPECT_NEAR(aircraft.duration_s(), 20.0 + half_circle_s, 1e-9);
  EXPECT_NEAR(end.north_m, -20.0, 1e-9);
  EXPECT_NEAR(end.east_m, -50.0, 1e-9);
}

TEST(Aircraft, MeetsEveryLegAtConstantSpeedWhateverTheSpacing) {
  for (const double spacing : {5.0, 40.0, 119.0, 120.0, 121.0, 300.0}) {
    AircraftParameters p = calm();
    p.leg_spacing_m = spacing;
    p.legs = 4;
    p.leg_azimuth_deg = 30.0;
    const Aircraft aircraft = Aircraft::make(p, 1).value();
    const Eigen::Vector2d right(-std::sin(30 * kDegree), std::cos(30 * kDegree));
    AircraftState before = aircraft.at(0.0);
    for (double t = 0.05; t < aircraft.duration_s(); t += 0.05) {
      const AircraftState s = aircraft.at(t);
      EXPECT_NEAR(std::hypot(s.north_m - before.north_m, s.east_m - before.east_m), 0.9, 1e-3);
      EXPECT_LT(std::abs(s.roll_rad - before.roll_rad), 0.1) << "roll jumps at " << t;
      if (s.on_leg) {
        const double across = right.dot(Eigen::Vector2d(s.north_m, s.east_m)) / spacing + 1.5;
        EXPECT_NEAR(across, std::round(across), 1e-6);
      }
      before = s;
    }
    const double across = right.dot(Eigen::Vector2d(before.north_m, before.east_m)) / spacing + 1.5;
    EXPECT_NEAR(across, 3.0, 1e-6);
  }
}

TEST(Aircraft, RefusesATurnItCannotBank) {
  AircraftParameters p;
  p.speed_m_s = 40.0;
  p.turn_radius_m = 20.0;
  EXPECT_EQ(Aircraft::make(p, 1).error().code, ErrorCode::Usage);
  p.turn_radius_m = NAN;
  EXPECT_EQ(Aircraft::make(p, 1).error().code, ErrorCode::Usage);
}

TEST(BandLimitedNoise, HasItsSigmaAndNothingFasterThanItsBand) {
  const BandLimitedNoise noise(77, 2.5, 0.8);
  double power = 0.0, worst_slope = 0.0;
  constexpr int kSteps = 200000;
  for (int i = 0; i < kSteps; ++i) {
    power += std::pow(noise.at(i * 0.01), 2);
    worst_slope =
        std::max(worst_slope, std::abs(noise.at(i * 0.01 + 0.001) - noise.at(i * 0.01)) / 0.001);
  }
  EXPECT_NEAR(std::sqrt(power / kSteps), 2.5, 0.1);
  // 24 waves in step at the band's edge: no more than sqrt(2 · 24) sigma · 2π 0.8 Hz.
  EXPECT_LT(worst_slope, std::sqrt(48.0) * 2.5 * 2 * std::numbers::pi * 0.8);
  EXPECT_EQ(BandLimitedNoise(77, 0.0, 0.8).at(3.0), 0.0);
  EXPECT_NE(BandLimitedNoise(78, 2.5, 0.8).at(3.0), noise.at(3.0));
}

}  // namespace
}  // namespace watersky::sim
