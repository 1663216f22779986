// SPDX-License-Identifier: MIT
#include "watersky/io/dataflash_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/dataflash_maker.hpp"
#include "support/real_data.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/files.hpp"
#include "watersky/wire/dataflash.hpp"

namespace watersky {
namespace {

using test::DataflashMaker;
using testing::Contains;
using testing::HasSubstr;

constexpr int kWeek = 2446;
constexpr double kWeekStart_s = 16'000;

/// A straight flight: north at 10 m/s from 78.9 N, level, heading 30°, 80 m above home.
struct Maker : DataflashMaker {
  enum : std::uint8_t { kAtt = 1, kPos, kGps, kCam, kTrig, kMnt, kRfnd, kXkf1, kOrgn, kXkq };

  Maker() {
    format(kAtt, "ATT", "Qfff", "TimeUS,Roll,Pitch,Yaw");
    format(kPos, "POS", "QLLff", "TimeUS,Lat,Lng,Alt,RelHomeAlt");
    format(kGps, "GPS", "QBBIHLLe", "TimeUS,I,Status,GMS,GWk,Lat,Lng,Alt");
    format(kCam, "CAM", "QBHLLe", "TimeUS,I,Img,Lat,Lng,Alt");
    format(kTrig, "TRIG", "QB", "TimeUS,I");
    format(kMnt, "MNT", "QBffff", "TimeUS,I,Roll,Pitch,YawB,YawE");
    format(kRfnd, "RFND", "QBfBB", "TimeUS,Instance,Dist,Stat,Orient");
    format(kXkf1, "XKF1", "QBfff", "TimeUS,C,PN,PE,PD");
    format(kOrgn, "ORGN", "QBLLe", "TimeUS,Type,Lat,Lng,Alt");
    format(kXkq, "XKQ", "QBffff", "TimeUS,C,Q1,Q2,Q3,Q4");
  }
  static std::uint64_t us(double s) { return static_cast<std::uint64_t>(std::llround(s * 1e6)); }
  static double latitude_deg(double s) { return 78.9 + 10.0 * s / 111'660.0; }
  static std::int32_t e7(double deg) { return static_cast<std::int32_t>(std::lround(deg * 1e7)); }

  Maker& attitude(double s, float roll_deg = 0) {
    record(kAtt, us(s), roll_deg, 0.0f, 30.0f);
    return *this;
  }
  Maker& position(double s) {
    record(kPos, us(s), e7(latitude_deg(s)), e7(11.9), 95.0f, 80.0f);
    return *this;
  }
  /// Logged `late_s` after its moment.
  Maker& gps(double s, double late_s, std::uint8_t status = 3) {
    record(kGps, us(s + late_s), std::uint8_t{0}, status,
           static_cast<std::uint32_t>(std::lround((kWeekStart_s + s) * 1e3)), std::uint16_t{kWeek},
           e7(latitude_deg(s)), e7(11.9), std::int32_t{9500});
    return *this;
  }
  Maker& fly(double from, double to) {
    for (int k = static_cast<int>(from * 10); k < to * 10; ++k) {
      const double s = k * 0.1;
      attitude(s, static_cast<float>(10 * std::sin(s)));
      position(s + 0.01);
      if (k % 5 == 0) gps(s, 0.02 + 0.01 * (k % 3));
    }
    return *this;
  }
};

Time at(double s) { return utc_from_gps(kWeek, std::llround((kWeekStart_s + s) * 1e3)); }
Result<AutopilotLog> parsed(Maker& maker) { return parse_dataflash(maker.bytes(), "x.bin"); }

TEST(DataflashLogReader, TimeUsBecomesUtcByGpsWeeks) {
  Maker maker;
  maker.fly(1, 60);
  const AutopilotLog log = parsed(maker).value();
  ASSERT_EQ(log.attitudes.size(), 590u);
  // A fix is logged 20 ms late at least: that much no log can tell.
  EXPECT_NEAR(to_seconds(log.attitudes.front().time - at(1.0)), -0.020, 1e-6);
  EXPECT_NEAR(to_seconds(log.attitudes.back().time - at(59.9)), -0.020, 1e-6);
  EXPECT_NEAR(log.home_height_geoid_m.value(), 15.0, 1e-5);
}

TEST(DataflashLogReader, CamTellsTheTimeAloneAndPosesAreInterpolatedThere) {
  Maker maker;
  maker.fly(1, 20);
  // Its own position is nonsense on purpose.
  maker.record(Maker::kTrig, Maker::us(9.9), std::uint8_t{0});
  maker.record(Maker::kCam, Maker::us(10.05), std::uint8_t{0}, std::uint16_t{7}, Maker::e7(10),
               Maker::e7(10), std::int32_t{0});
  maker.attitude(20).position(20);
  const AutopilotLog log = parsed(maker).value();
  ASSERT_EQ(log.feedback.size(), 1u);
  EXPECT_EQ(log.feedback[0].image_index, 7);
  EXPECT_EQ(log.feedback_name, "CAM records");
  const Datum datum({Angle::degrees(78.9), Angle::degrees(11.9), 0});
  const Trajectory trajectory = make_trajectory(log, datum).value();
  const StampedPose pose = trajectory.at(log.feedback[0].time, std::chrono::seconds(1)).value();
  const Geodetic g = datum.geodetic(pose.world_from_body.origin());
  EXPECT_NEAR(g.latitude.degrees(), Maker::latitude_deg(10.05), 2e-7);
  EXPECT_NEAR(yaw_pitch_roll(pose.world_from_body.rotation()).roll.degrees(),
              5 * (std::sin(10.0) + std::sin(10.1)) * 1.0, 0.05);
}

TEST(DataflashLogReader, WithoutAFeedbackPinANoteSaysThatTheShutterCameLater) {
  Maker maker;
  maker.fly(1, 5);
  maker.record(Maker::kCam, Maker::us(3), std::uint8_t{0}, std::uint16_t{1}, 0, 0, 0);
  EXPECT_THAT(parsed(maker)->notes, Contains(HasSubstr("told to shoot")));
}

TEST(DataflashLogReader, TakesTheFilterInUseWherePosIsMissing) {
  Maker maker;
  maker.record(Maker::kOrgn, Maker::us(1), std::uint8_t{0}, Maker::e7(78.9), Maker::e7(11.9),
               std::int32_t{1500});
  maker.record(Maker::kOrgn, Maker::us(1), std::uint8_t{1}, Maker::e7(78.9), Maker::e7(11.9),
               std::int32_t{1400});
  maker.format(20, "XKF4", "QBb", "TimeUS,C,PI");
  for (int k = 10; k < 100; ++k) {
    const double s = k * 0.1;
    maker.record(20, Maker::us(s), std::uint8_t{0}, std::int8_t{1});
    for (std::uint8_t core = 0; core < 2; ++core) {
      maker.record(Maker::kXkf1, Maker::us(s), core, core == 1 ? 100.0f : -5000.0f, 50.0f, -80.0f);
      maker.record(Maker::kXkq, Maker::us(s), core, core == 1 ? 1.0f : 0.0f, 0.0f, 0.0f,
                   core == 1 ? 0.0f : 1.0f);
    }
    if (k % 5 == 0) maker.gps(s, 0.02);
  }
  const AutopilotLog log = parsed(maker).value();
  EXPECT_THAT(log.notes, Contains(HasSubstr("position is from the 90 XKF1 records (also there: "
                                            "GPS)")));
  EXPECT_THAT(log.notes, Contains(HasSubstr("attitude is from the 90 XKQ records")));
  EXPECT_NEAR(log.home_height_geoid_m.value(), 14.0, 1e-9);
  // 100 m north and 50 m east on ArduPilot's sphere: 0.1 µdeg are 11 mm.
  const PositionSample& p = log.positions.front();
  EXPECT_NEAR(p.latitude.degrees(), 78.9 + 100 / 111'318.845, 1e-7);
  EXPECT_NEAR(p.longitude.degrees(), 11.9 + 50 / 111'318.845 / std::cos(78.9 * M_PI / 180), 1e-6);
  EXPECT_NEAR(p.height_geoid_m, 95.0, 1e-9);
  EXPECT_NEAR(
      angle_between(log.attitudes[0].ned_from_body, Eigen::Quaterniond::Identity()).degrees(), 0,
      1e-6);
}

TEST(DataflashLogReader, ASourceThatWasLoggedForAShortTimeIsNotTheBest) {
  Maker maker;
  for (int k = 10; k < 600; ++k) {
    maker.attitude(k * 0.1);
    if (k < 50) maker.position(k * 0.1);
    if (k % 2 == 0) maker.gps(k * 0.1, 0.02);
  }
  EXPECT_THAT(parsed(maker)->notes,
              Contains(HasSubstr("position is from the 295 GPS records (also there: POS)")));
}

TEST(DataflashLogReader, RangesAndGimbalsAreThoseThatCanBeUsed) {
  Maker maker;
  maker.fly(1, 10);
  const auto range = [&](double s, float m, std::uint8_t status, std::uint8_t orient) {
    maker.record(Maker::kRfnd, Maker::us(s), std::uint8_t{0}, m, status, orient);
  };
  range(2, 80.5f, 4, 25);
  range(3, 80.5f, 3, 25);  // out of reach
  range(4, 12.0f, 4, 0);   // looks forward
  maker.record(Maker::kMnt, Maker::us(5), std::uint8_t{0}, 0.0f, -90.0f, 10.0f, 40.0f);
  maker.record(Maker::kMnt, Maker::us(6), std::uint8_t{0}, 0.0f, -60.0f, 10.0f,
               std::numeric_limits<float>::quiet_NaN());
  const AutopilotLog log = parsed(maker).value();
  ASSERT_EQ(log.ranges.size(), 1u);
  EXPECT_NEAR(log.ranges[0].range_m, 80.5, 1e-6);
  ASSERT_EQ(log.gimbal.size(), 2u);
  const auto yaw_40 = rotation_from({Angle::degrees(40), Angle::degrees(-90), {}});
  EXPECT_NEAR(angle_between(log.gimbal[0].rotation, yaw_40).degrees(), 0, 1e-4);
  // Told from the body, whose heading is 30°.
  const auto from_body = rotation_from({Angle::degrees(40), Angle::degrees(-60), {}});
  EXPECT_NEAR(angle_between(log.gimbal[1].rotation, from_body).degrees(), 0, 0.2);
}

TEST(DataflashLogReader, ClocksThatJumpOrRunBackwardsAreTold) {
  Maker maker;
  maker.fly(1, 30);
  maker.attitude(90'000);  // a damaged record
  maker.fly(30, 60);
  maker.fly(1, 10);  // another start behind it
  const AutopilotLog log = parsed(maker).value();
  EXPECT_EQ(log.attitudes.size(), 590u);
  EXPECT_THAT(log.notes, Contains(HasSubstr("restarted 1 times")));
  EXPECT_THAT(log.notes, Contains(HasSubstr("far from their neighbours'")));
}

TEST(DataflashLogReader, WithoutGpsTimeItCountsFromTheStartAndSaysSo) {
  Maker maker;
  for (int k = 10; k < 100; ++k) {
    maker.attitude(k * 0.1).position(k * 0.1);
    maker.gps(k * 0.1, 0.02, 1);  // no fix
  }
  const AutopilotLog log = parsed(maker).value();
  EXPECT_NEAR(to_seconds(log.attitudes.front().time), 1.0, 1e-9);
  EXPECT_THAT(log.notes, Contains(HasSubstr("GPS never told the time")));
}

TEST(DataflashLogReader, SaysWhatIsMissing) {
  const auto error = [](const Bytes& bytes) {
    return parse_dataflash(bytes, "x.bin").error().message;
  };
  EXPECT_THAT(error(Bytes(100, 7)), HasSubstr("x.bin: byte 0"));
  DataflashMaker no_fmt;
  no_fmt.record(1, std::uint64_t{5});
  EXPECT_THAT(error(no_fmt.bytes()), HasSubstr("no FMT record says what that is"));
  Maker blind;
  for (int k = 10; k < 100; ++k) blind.position(k * 0.1);
  EXPECT_THAT(error(blind.bytes()), HasSubstr("holds no attitude"));
  Maker lost;
  for (int k = 10; k < 100; ++k) lost.attitude(k * 0.1);
  EXPECT_THAT(error(lost.bytes()), HasSubstr("holds no position"));
}

// ArduPlane in its own simulator, whose SIM records are the truth.
TEST(DataflashLogReader, PlacesEveryCamRecordOfARealLogWhereTheSimulatorWas) {
  const auto folder = test::real_data("autopilot_logs");
  if (!folder) GTEST_SKIP() << "the real data is not here";
  const Bytes bytes = read_bytes(*folder / "arduplane_sitl_cam.BIN").value();
  const AutopilotLog log = parse_dataflash(bytes, "arduplane_sitl_cam.BIN").value();
  ASSERT_EQ(log.feedback.size(), 25u);
  EXPECT_EQ(log.feedback.front().image_index, 1);
  EXPECT_EQ(log.feedback.back().image_index, 25);
  // CAM.GPSTime is that of the last fix, some tenths old.
  const double behind_s = to_seconds(log.feedback.front().time - utc_from_gps(2446, 16'651'800));
  EXPECT_GT(behind_s, 0.0);
  EXPECT_LT(behind_s, 0.3);
  EXPECT_THAT(log.notes, Contains(HasSubstr("position is from the 1501 POS records")));
  EXPECT_NEAR(log.home_height_geoid_m.value(), 30.08, 0.02);

  // The truth at the CAM records' times, in boot time.
  struct Truth {
    double s, latitude_deg, longitude_deg, height_geoid_m;
    Eigen::Quaterniond ned_from_body;
  };
  std::vector<Truth> truth;
  std::vector<double> cam_s;
  dataflash::Reader reader(bytes);
  while (const auto r = reader.next()) {
    if (r->format->name == "CAM") cam_s.push_back(r->number("TimeUS") * 1e-6);
    if (r->format->name == "SIM")
      truth.push_back(
          {r->number("TimeUS") * 1e-6, r->number("Lat"), r->number("Lng"), r->number("Alt"),
           Eigen::Quaterniond(r->number("Q1"), r->number("Q2"), r->number("Q3"), r->number("Q4"))});
  }
  const Datum datum({log.positions.front().latitude, log.positions.front().longitude, 30.0});
  const Trajectory trajectory = make_trajectory(log, datum).value();
  double worst_m = 0, worst_deg = 0;
  for (std::size_t i = 0; i < 25; ++i) {
    const auto pose = trajectory.at(log.feedback[i].time, std::chrono::milliseconds(200));
    ASSERT_TRUE(pose.ok()) << i << ": " << pose.error().message;
    std::size_t k = 1;
    while (truth[k].s < cam_s[i]) ++k;
    const Truth &a = truth[k - 1], &b = truth[k];
    const double f = (cam_s[i] - a.s) / (b.s - a.s);
    const auto mix = [&](double x, double y) { return x + f * (y - x); };
    const Angle lat = Angle::degrees(mix(a.latitude_deg, b.latitude_deg));
    const Angle lon = Angle::degrees(mix(a.longitude_deg, b.longitude_deg));
    const Geodetic g{
        lat, lon,
        mix(a.height_geoid_m, b.height_geoid_m) + egm96_above_ellipsoid_m(lat, lon).value()};
    worst_m = std::max(worst_m, (datum.world(g).v - pose->world_from_body.origin().v).norm());
    const Eigen::Quaterniond world_from_body =
        datum.world_from_ned_rotation(g) * a.ned_from_body.slerp(f, b.ned_from_body);
    worst_deg = std::max(
        worst_deg, angle_between(world_from_body, pose->world_from_body.rotation()).degrees());
  }
  // The estimator's own errors: it lags in the climbing turn.
  EXPECT_LT(worst_m, 1.5);
  EXPECT_LT(worst_deg, 1.0);
  RecordProperty("worst_m", std::to_string(worst_m));
  RecordProperty("worst_deg", std::to_string(worst_deg));
}

}  // namespace
}  // namespace watersky
