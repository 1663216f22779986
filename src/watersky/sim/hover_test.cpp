// SPDX-License-Identifier: MIT
#include "watersky/sim/hover.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "watersky/sim/aircraft.hpp"

namespace watersky::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

HoverParameters turned_room() {
  HoverParameters p;
  p.hovers = true;
  p.hover_azimuth_deg = 37.0;
  p.hover_x_m = -0.6;
  p.hover_y_m = 1.6;
  return p;
}

TEST(Hover, StaysInItsBoxBelowItsSpeedAndUsesBoth) {
  const HoverParameters p = turned_room();
  const double c = std::cos(37.0 * kDegree), s = std::sin(37.0 * kDegree);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Hover hover = Hover::make(p, seed).value();
    EXPECT_EQ(hover.duration_s(), 60.0);
    double fastest = 0.0, reach_x = 0.0, reach_y = 0.0, low = 9.0, high = 0.0, yaw = 0.0;
    AircraftState before = hover.at(0.0);
    for (double t = 0.01; t < 60.0; t += 0.01) {
      const AircraftState now = hover.at(t);
      const double x = now.north_m * c + now.east_m * s - p.hover_x_m;
      const double y = now.east_m * c - now.north_m * s - p.hover_y_m;
      reach_x = std::max(reach_x, std::abs(x));
      reach_y = std::max(reach_y, std::abs(y));
      low = std::min(low, now.height_m);
      high = std::max(high, now.height_m);
      yaw = std::max(yaw, std::abs(now.yaw_rad - 37.0 * kDegree));
      fastest =
          std::max(fastest, std::hypot(now.north_m - before.north_m, now.east_m - before.east_m,
                                       now.height_m - before.height_m) /
                                0.01);
      EXPECT_TRUE(now.on_leg);
      before = now;
    }
    EXPECT_LE(reach_x, p.hover_reach_x_m);
    EXPECT_LE(reach_y, p.hover_reach_y_m);
    EXPECT_GE(low, p.hover_lowest_m);
    EXPECT_LE(high, p.hover_highest_m);
    EXPECT_LE(yaw, 35.0 * kDegree);
    EXPECT_LE(fastest, p.hover_speed_m_s);
    EXPECT_GT(reach_x, 0.8 * p.hover_reach_x_m);
    EXPECT_GT(reach_y, 0.8 * p.hover_reach_y_m);
    EXPECT_LT(low, 1.25);
    EXPECT_GT(high, 1.75);
    EXPECT_GT(yaw, 28.0 * kDegree);
    EXPECT_GT(fastest, 0.3);
  }
}

TEST(Hover, TiltsByTwoToFourDegrees) {
  double least = 90.0, most = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Hover hover = Hover::make(turned_room(), seed).value();
    double power = 0.0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const AircraftState state = hover.at(0.05 * i);
      power += state.roll_rad * state.roll_rad + state.pitch_rad * state.pitch_rad;
    }
    const double tilt_deg = std::sqrt(power / kSteps) / kDegree;
    least = std::min(least, tilt_deg);
    most = std::max(most, tilt_deg);
  }
  EXPECT_NEAR(least, 2.0, 0.3);
  EXPECT_NEAR(most, 4.0, 0.3);
}

TEST(Hover, IsAnAircraftOfWhichEverySeedFliesAnotherPath) {
  AircraftParameters p;
  p.hover = turned_room();
  const Aircraft a = Aircraft::make(p, 1).value(), b = Aircraft::make(p, 2).value();
  EXPECT_EQ(a.duration_s(), 60.0);
  EXPECT_EQ(a.at(12.3).north_m, Aircraft::make(p, 1)->at(12.3).north_m);
  EXPECT_NE(a.at(12.3).north_m, b.at(12.3).north_m);
  EXPECT_TRUE(std::isfinite(a.at(-1e4).north_m) && std::isfinite(a.at(1e6).height_m));
}

TEST(Hover, RefusesABoxUpsideDown) {
  HoverParameters p = turned_room();
  p.hover_lowest_m = 2.0;
  EXPECT_EQ(Hover::make(p, 1).error().code, ErrorCode::Usage);
  p = turned_room();
  p.hover_least_tilt_deg = 5.0;
  EXPECT_EQ(Hover::make(p, 1).error().code, ErrorCode::Usage);
  p = turned_room();
  p.hover_speed_m_s = NAN;
  EXPECT_EQ(Hover::make(p, 1).error().code, ErrorCode::Usage);
}

}  // namespace
}  // namespace watersky::sim
