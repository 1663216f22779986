// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <string>

#include "watersky/base/angle.hpp"
#include "watersky/base/parameters.hpp"
#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"

namespace watersky {
namespace {

Result<int> half(int x) {
  if (x % 2 != 0) return Error{ErrorCode::InvalidInput, "odd"};
  return x / 2;
}
Result<int> quarter(int x) {
  WATERSKY_TRY(const int once, half(x));
  return half(once);
}

TEST(Result, TryReturnsTheFirstError) {
  EXPECT_EQ(quarter(8).value(), 2);
  ASSERT_FALSE(quarter(6).ok());
  EXPECT_EQ(quarter(6).error().message, "odd");
  EXPECT_EQ(quarter(6).error().at("numbers.csv:3").message, "numbers.csv:3: odd");
  EXPECT_EQ(quarter(7).value_or(-1), -1);
}

TEST(Time, SecondsKeepMicrosecondsIn2026) {
  const double s = 1795418856.123456;
  EXPECT_NEAR(to_seconds(*time_from_seconds(s)), s, 1e-6);
  EXPECT_EQ(seconds(-0.25).count(), -250'000'000);
  EXPECT_FALSE(time_from_seconds(1e300).has_value());
  EXPECT_FALSE(time_from_seconds(std::nan("")).has_value());
}

TEST(Time, Iso8601HasMillisecondsAndZ) {
  EXPECT_EQ(to_iso8601(*time_from_seconds(1533430844.8)), "2018-08-05T01:00:44.800Z");
  EXPECT_EQ(to_iso8601(*time_from_seconds(-0.5)), "1969-12-31T23:59:59.500Z");
}

TEST(Time, GoesToGpsAndBack) {
  for (double t_s = 400e6; t_s < 2.0e9; t_s += 12'345'678.9) {
    const Time t = std::chrono::round<std::chrono::milliseconds>(time_from_seconds(t_s).value());
    const GpsTime gps = gps_from_utc(t);
    EXPECT_GE(gps.week_ms, 0);
    EXPECT_LT(gps.week_ms, 604'800'000);
    EXPECT_EQ(utc_from_gps(gps.week, gps.week_ms), t) << to_iso8601(t);
  }
}

TEST(Time, OfGpsIsAheadByTheLeapSecondsOfItsDay) {
  EXPECT_EQ(to_iso8601(utc_from_gps(0, 0)), "1980-01-06T00:00:00.000Z");
  // The roll-over of April 2019, and the leap second at the end of 2016 from both sides.
  EXPECT_EQ(to_iso8601(utc_from_gps(2048, 18'000)), "2019-04-07T00:00:00.000Z");
  EXPECT_EQ(to_iso8601(utc_from_gps(1930, 16'000)), "2016-12-31T23:59:59.000Z");
  EXPECT_EQ(to_iso8601(utc_from_gps(1930, 18'000)), "2017-01-01T00:00:00.000Z");
  EXPECT_EQ(to_iso8601(utc_from_gps(1742, 518'416'000)), "2013-06-01T00:00:00.000Z");
}

TEST(Angle, PiRadiansExactly180Degrees) {
  EXPECT_EQ(Angle::degrees(180).radians(), std::numbers::pi);
  EXPECT_NEAR((350_deg).wrapped().degrees(), -10.0, 1e-12);
  EXPECT_NEAR((-180_deg).wrapped().degrees(), 180.0, 1e-12);
}

struct Sample {
  double cell_m = 0.5;
  int count = 3;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.cell_m, ParameterInfo{"cell_m", "m", "edge of a cell", 0.001, 1000.0});
    visit(self.count, ParameterInfo{"count", "1", "how many", 0, 10});
  }
};

TEST(Parameters, TheFirstOneOutOfRangeIsNamedWithItsRangeAndUnit) {
  EXPECT_TRUE(validate(Sample{}).ok());
  const Status bad = validate(Sample{.cell_m = 0.0});
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().message, "cell_m must be from 0.001 to 1000 m, is 0");
  EXPECT_EQ(bad.error().code, ErrorCode::Usage);
  EXPECT_FALSE(validate(Sample{.cell_m = std::nan("")}).ok());
  EXPECT_FALSE(validate(Sample{.count = 11}).ok());
}

}  // namespace
}  // namespace watersky
