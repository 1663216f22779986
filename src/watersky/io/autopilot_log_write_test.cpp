// SPDX-License-Identifier: MIT
#include "watersky/io/autopilot_log_write.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "watersky/geo/rotation.hpp"
#include "watersky/io/dataflash_log.hpp"
#include "watersky/io/lsf_log.hpp"

namespace watersky {
namespace {

constexpr Time kStart{std::chrono::seconds(1'795'000'000)};

/// Half a minute over the 180° meridian, turning, with a gimbal, ranges and 40 pictures.
AutopilotLog some_log() {
  AutopilotLog log;
  for (int i = 0; i < 600; ++i) {
    const double t = 0.05 * i + 1e-6 * i;  // not on whole milliseconds
    const Time time = kStart + seconds(t);
    log.attitudes.push_back(
        {time, rotation_from({Angle::radians(2.0 + 0.2 * t), Angle::radians(0.1 * std::sin(t)),
                              Angle::radians(0.3 * std::cos(0.7 * t))})});
    log.positions.push_back({time, Angle::degrees(78.2 + 1e-5 * i),
                             Angle::degrees(std::remainder(179.997 + 1e-5 * i, 360.0)),
                             120.0 + 0.01 * i});
    if (i % 5 == 0)
      log.gimbal.push_back({time, rotation_from({Angle::radians(2.0 + 0.1 * t), Angle::degrees(-80),
                                                 Angle::degrees(1)})});
    if (i % 15 == 7) log.feedback.push_back({time + std::chrono::microseconds(1234), i / 15});
    if (i % 10 == 0) log.ranges.push_back({time, 100.0 + 0.02 * i, 0.05});
  }
  log.home_height_geoid_m = 12.0;
  return log;
}

struct Bounds {
  double time_s, place_m, height_m, angle_rad;
};

void expect_same(const AutopilotLog& is, const AutopilotLog& was, const Bounds& bounds) {
  ASSERT_EQ(is.attitudes.size(), was.attitudes.size());
  ASSERT_EQ(is.positions.size(), was.positions.size());
  for (std::size_t i = 0; i < was.attitudes.size(); ++i) {
    ASSERT_NEAR(to_seconds(is.attitudes[i].time - was.attitudes[i].time), 0, bounds.time_s) << i;
    ASSERT_LT(is.attitudes[i].ned_from_body.angularDistance(was.attitudes[i].ned_from_body),
              bounds.angle_rad);
    const PositionSample &a = is.positions[i], &b = was.positions[i];
    ASSERT_NEAR(to_seconds(a.time - b.time), 0, bounds.time_s);
    constexpr double kMetresPerRadian = 6.38e6;
    ASSERT_NEAR(a.latitude.radians() * kMetresPerRadian, b.latitude.radians() * kMetresPerRadian,
                bounds.place_m);
    ASSERT_NEAR(std::remainder(a.longitude.radians() - b.longitude.radians(), 2 * M_PI) *
                    kMetresPerRadian * std::cos(b.latitude.radians()),
                0, bounds.place_m);
    ASSERT_NEAR(a.height_geoid_m, b.height_geoid_m, bounds.height_m);
  }
  ASSERT_EQ(is.ranges.size(), was.ranges.size());
  for (std::size_t i = 0; i < was.ranges.size(); ++i) {
    EXPECT_NEAR(to_seconds(is.ranges[i].time - was.ranges[i].time), 0, bounds.time_s);
    EXPECT_NEAR(is.ranges[i].range_m, was.ranges[i].range_m, 0.0051);
  }
}

void expect_same_pictures_and_gimbal(const AutopilotLog& is, const AutopilotLog& was,
                                     double time_s) {
  ASSERT_EQ(is.feedback.size(), was.feedback.size());
  for (std::size_t i = 0; i < was.feedback.size(); ++i) {
    EXPECT_NEAR(to_seconds(is.feedback[i].time - was.feedback[i].time), 0, 2e-6);
    EXPECT_EQ(is.feedback[i].image_index, was.feedback[i].image_index);
  }
  ASSERT_EQ(is.gimbal.size(), was.gimbal.size());
  for (std::size_t i = 0; i < was.gimbal.size(); ++i) {
    EXPECT_NEAR(to_seconds(is.gimbal[i].time - was.gimbal[i].time), 0, time_s);
    EXPECT_LT(is.gimbal[i].rotation.angularDistance(was.gimbal[i].rotation), 1e-6);
  }
  EXPECT_NEAR(*is.home_height_geoid_m, *was.home_height_geoid_m, 0.002);
}

TEST(AutopilotLogWrite, TelemetryIsReadBackToTheMillisecondAndTheCentimetre) {
  const AutopilotLog was = some_log();
  const auto bytes = encode_log(was, LogFormat::Tlog);
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto is = parse_tlog(*bytes, "x.tlog");
  ASSERT_TRUE(is) << is.error().message;
  EXPECT_TRUE(is->notes.empty()) << is->notes.front();
  expect_same(*is, was, {0.51e-3, 0.006, 0.00051, 1e-6});
  expect_same_pictures_and_gimbal(*is, was, 0.51e-3);
  EXPECT_NEAR(is->ranges[3].sigma_m, 0.05, 1e-9);
}

TEST(AutopilotLogWrite, DataFlashIsReadBackToTheMicrosecond) {
  const AutopilotLog was = some_log();
  const auto bytes = encode_log(was, LogFormat::DataFlash);
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto is = parse_dataflash(*bytes, "x.bin");
  ASSERT_TRUE(is) << is.error().message;
  expect_same(*is, was, {2e-6, 0.006, 1e-4, 1e-6});
  expect_same_pictures_and_gimbal(*is, was, 2e-6);
}

TEST(AutopilotLogWrite, LsfHoldsPosesAndRanges) {
  const AutopilotLog was = some_log();
  const auto bytes = encode_log(was, LogFormat::Lsf);
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto is = parse_lsf(*bytes, imc::Schema::builtin(), "Data.lsf");
  ASSERT_TRUE(is) << is.error().message;
  expect_same(*is, was, {1e-6, 1e-4, 1e-4, 1e-6});
  EXPECT_TRUE(is->feedback.empty());
}

TEST(AutopilotLogWrite, NothingToWriteIsSaid) {
  EXPECT_EQ(encode_log(AutopilotLog{}, LogFormat::Tlog).error().code, ErrorCode::NotFound);
}

}  // namespace
}  // namespace watersky
