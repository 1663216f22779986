// SPDX-License-Identifier: MIT
#include "watersky/flight/known_points.hpp"

#include <gtest/gtest.h>

namespace watersky {
namespace {

Time at_s(double s) { return Time(seconds(s)); }

AnchorPlace place(double lat_deg, double lon_deg, double height_m) {
  return {Angle::degrees(lat_deg), Angle::degrees(lon_deg), height_m, HeightAbove::Ellipsoid};
}

TEST(Anchor, OneThatStandsIsThereAtAnyTime) {
  Anchor anchor;
  anchor.place = place(78.9, 11.9, 31.0);
  EXPECT_DOUBLE_EQ(anchor.at(at_s(-1e9))->latitude.degrees(), 78.9);
  EXPECT_DOUBLE_EQ(anchor.at(at_s(1e9))->height_m, 31.0);
}

TEST(Anchor, OneThatMovesIsBetweenItsFixesAndNowhereElse) {
  Anchor anchor{.name = "beacon", .place = {}, .track = {}, .sightings = {}};
  anchor.track = {{at_s(0), place(78.0, 179.9, 10.0)},
                  {at_s(100), place(79.0, -179.9, 20.0)},
                  {at_s(2000), place(79.0, -179.9, 20.0)}};
  const auto middle = anchor.at(at_s(25));
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->latitude.degrees(), 78.25, 1e-12);
  // Over the date line, not around the Earth.
  EXPECT_NEAR(middle->longitude.degrees(), 179.95, 1e-9);
  EXPECT_NEAR(middle->height_m, 12.5, 1e-12);
  EXPECT_DOUBLE_EQ(anchor.at(at_s(0))->latitude.degrees(), 78.0);
  EXPECT_DOUBLE_EQ(anchor.at(at_s(2000))->latitude.degrees(), 79.0);
  for (const double t : {-0.001, 2000.001, 1000.0})
    EXPECT_EQ(anchor.at(at_s(t)).error().code, ErrorCode::OutOfRange) << t;
}

TEST(Anchor, OneWithoutPlaceOrFixIsNowhere) { EXPECT_FALSE(Anchor{}.at(at_s(0))); }

}  // namespace
}  // namespace watersky
