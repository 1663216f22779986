// SPDX-License-Identifier: MIT
#include "watersky/io/sea_level.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "watersky/geodesy/projection.hpp"
#include "watersky/io/read_options.hpp"

namespace watersky {
namespace {

using ::testing::HasSubstr;

const Geodetic kPlace{Angle::degrees(78.9), Angle::degrees(11.9), 100.0};

TEST(SeaLevelOption, ReadsTheThreeReferences) {
  EXPECT_EQ(parse_sea_level_option("takeoff:-40")->reference, SeaReference::TakeOff);
  EXPECT_EQ(parse_sea_level_option("takeoff:-40")->height_m, -40.0);
  EXPECT_EQ(parse_sea_level_option("geoid:0")->reference, SeaReference::Geoid);
  EXPECT_EQ(parse_sea_level_option("ellipsoid:+143.25")->height_m, 143.25);
}

TEST(SeaLevelOption, AnythingElseIsTheCallersFaultAndNamesTheChoices) {
  for (const char* bad : {"", "0", "takeoff", "takeoff:", "takeoff:x", "sea:0", "geoid:nan",
                          "geoid:1e9", "Geoid:0", "geoid:0m"}) {
    const auto option = parse_sea_level_option(bad);
    ASSERT_FALSE(option) << bad;
    EXPECT_EQ(option.error().code, ErrorCode::Usage);
    EXPECT_THAT(option.error().message, HasSubstr("takeoff:M, geoid:M, ellipsoid:M"));
  }
  for (const char* choice : {"takeoff:", "geoid:", "ellipsoid:"})
    EXPECT_THAT(explain_sea_level(), HasSubstr(choice));
}

TEST(SeaLevel, EachReferenceIsWhereItSays) {
  const double geoid_m = egm96_above_ellipsoid_m(kPlace.latitude, kPlace.longitude).value();
  const auto height = [](const SeaLevelOption& o, const std::optional<TakeOff>& t) {
    return make_sea_level(o, t).value().height_ellipsoid_m(kPlace).value();
  };
  const TakeOff takeoff{158.5, true};
  EXPECT_NEAR(height({SeaReference::Ellipsoid, 7}, takeoff), 7, 1e-12);
  EXPECT_NEAR(height({SeaReference::Geoid, 7}, takeoff), geoid_m + 7, 1e-9);
  EXPECT_NEAR(height({SeaReference::TakeOff, -40}, takeoff), geoid_m + 118.5, 1e-9);
}

TEST(SeaLevel, WhatTheRecordingLacksIsSaid) {
  EXPECT_THAT(make_sea_level({SeaReference::TakeOff, -40}, std::nullopt).error().message,
              HasSubstr("geoid:M"));
  EXPECT_THAT(make_sea_level({SeaReference::Geoid, 0}, TakeOff{0, false}).error().message,
              HasSubstr("takeoff:M"));
}

TEST(MountOption, IsRollPitchYaw) {
  const auto m = parse_mount_option("1,-90,45").value();
  EXPECT_NEAR(m.roll.degrees(), 1, 1e-12);
  EXPECT_NEAR(m.pitch.degrees(), -90, 1e-12);
  EXPECT_NEAR(m.yaw.degrees(), 45, 1e-12);
  for (const char* bad : {"", "1,2", "1,2,3,4", "a,b,c", "1,2,", "1,2,nan", "1,2,361"})
    EXPECT_EQ(parse_mount_option(bad).error().code, ErrorCode::Usage) << bad;
}

TEST(LeverArmOption, IsForwardRightDown) {
  EXPECT_EQ(parse_lever_arm_option("0.3,-1,0.1").value(), Eigen::Vector3d(0.3, -1, 0.1));
  for (const char* bad : {"", "1,2", "1,2,3,4", "a,b,c", "1,2,nan", "1,2,101"})
    EXPECT_EQ(parse_lever_arm_option(bad).error().code, ErrorCode::Usage) << bad;
}

}  // namespace
}  // namespace watersky
