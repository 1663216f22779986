// SPDX-License-Identifier: MIT
#include "watersky/io/inspect.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/make_photo.hpp"

namespace watersky {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using watersky::test::make_photo;
using watersky::test::Photo;
using watersky::test::TemporaryFolder;
using watersky::test::write;

TEST(Inspect, TellsWhatIsInACalibrationACsvAndAPhotograph) {
  const TemporaryFolder folder;
  write(folder.path() / "camera.yaml",
        std::string("image_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, data: "
                    "[60., 0., 31.5, 0., 60., 23.5, 0., 0., 1.]}\n"));
  write(folder.path() / "poses.csv", std::string("time_s,north_m\n1,2\n3,4\n4,4\n"));
  Photo p;
  p.latitude_deg = -70.5;
  p.longitude_deg = 12;
  write(folder.path() / "a.jpg", make_photo(p));
  EXPECT_EQ(inspect(folder.path() / "camera.yaml")->facts.at("size"), "64x48");
  const Inspection csv = inspect(folder.path() / "poses.csv").value();
  EXPECT_EQ(csv.counts.at("rows"), 3u);
  EXPECT_NEAR(csv.rates_hz.at("rows"), 2.0 / 3.0, 1e-12);
  const Inspection photo = inspect(folder.path() / "a.jpg").value();
  EXPECT_NEAR(photo.extent->south_deg, -70.5, 1e-9);
  EXPECT_THAT(photo.facts.at("camera"), HasSubstr("FC300S"));
}

TEST(Inspect, APhotographOfAnUnknownCameraIsStillInspected) {
  const TemporaryFolder folder;
  Photo p;
  p.make = "Acme";
  p.model = "Eye";
  p.latitude_deg = 1;
  p.longitude_deg = 2;
  p.altitude_m = 3;
  write(folder.path() / "a.jpg", make_photo(p));
  const auto i = inspect(folder.path());
  ASSERT_TRUE(i) << i.error().message;
  EXPECT_EQ(i->kind, "photographs");
  EXPECT_EQ(i->facts.at("intrinsics"), "not known");
  EXPECT_THAT(i->notes, Contains(HasSubstr("--focal-px")));
}

TEST(Inspect, WhatCannotBeReadIsAnError) {
  const TemporaryFolder folder;
  EXPECT_EQ(inspect(folder.path() / "absent").error().code, ErrorCode::NotFound);
  EXPECT_EQ(inspect(folder.path()).error().code, ErrorCode::NotFound);
  write(folder.path() / "x.tlog", std::string("not a log at all"));
  EXPECT_EQ(inspect(folder.path() / "x.tlog").error().code, ErrorCode::InvalidInput);
  write(folder.path() / "x.doc", std::string("x"));
  EXPECT_EQ(inspect(folder.path() / "x.doc").error().code, ErrorCode::Unsupported);
}

// By the data's own description.
TEST(Inspect, CountsWhatTheRealDataHolds) {
  const auto cuav = watersky::test::real_data("cuav_flight");
  const auto brighton = watersky::test::real_data("brighton_beach");
  if (!cuav || !brighton) GTEST_SKIP() << "the real data is not here";
  const Inspection log = inspect(*cuav / "flight.tlog").value();
  EXPECT_EQ(log.kind, "tlog");
  EXPECT_EQ(log.counts.at("ATTITUDE"), 604u);
  EXPECT_EQ(log.counts.at("GLOBAL_POSITION_INT"), 676u);
  EXPECT_NEAR(to_seconds(*log.last - *log.first), 185, 1);
  EXPECT_LT(log.extent->north_deg - log.extent->south_deg, 0.05);
  const Inspection flight = inspect(*cuav).value();
  EXPECT_EQ(flight.kind, "photographs_with_log");
  EXPECT_EQ(flight.counts.at("frames"), 18u);
  const nlohmann::json json = to_json(inspect(*brighton).value());
  EXPECT_EQ(json["kind"], "photographs");
  EXPECT_EQ(json["counts"]["frames"], 18);
  EXPECT_NEAR(json["extent"]["south_deg"].get<double>(), 46.842, 0.01);
  EXPECT_EQ(json["time"]["first"], "2016-06-23T16:31:59.000Z");
}

}  // namespace
}  // namespace watersky
