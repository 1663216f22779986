// SPDX-License-Identifier: MIT
#include "watersky/io/lsf_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/real_data.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/files.hpp"
#include "watersky/wire/gzip.hpp"
#include "watersky/wire/imc.hpp"

namespace watersky {
namespace {

using imc::Message;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using Bytes = std::vector<std::uint8_t>;

constexpr double kStart_s = 1.7e9;
constexpr std::uint16_t kX8 = 0x0C0C;

Message message(const char* name) { return Message(*imc::Schema::builtin().find(name)); }

struct Maker {
  Bytes log;

  Maker& send(const Message& m, double t, std::uint16_t source = kX8) {
    const auto order = log.size() % 2 == 0 ? std::endian::little : std::endian::big;
    const Bytes packet = imc::encode(m, {kStart_s + t, source, 1, 0xFFFF, 255}, order).value();
    log.insert(log.end(), packet.begin(), packet.end());
    return *this;
  }
  static Message state(double lat_deg, double lon_deg, double height_m) {
    Message m = message("EstimatedState");
    m.set("lat", Angle::degrees(lat_deg).radians()).set("lon", Angle::degrees(lon_deg).radians());
    return m.set("height", height_m).set("phi", 0.1).set("psi", 0.5);
  }
  /// A reference that stays, and an offset from it that moves.
  Maker& relative(double t, double north_m, double east_m, double down_m) {
    Message m = state(78.2, 15.6, 40.0);
    m.set("x", north_m).set("y", east_m).set("z", down_m);
    return send(m, t);
  }
};

Result<AutopilotLog> parsed(const Maker& maker) {
  return parse_lsf(maker.log, imc::Schema::builtin(), "Data.lsf");
}
double geoid_m(double lat_deg, double lon_deg) {
  return egm96_above_ellipsoid_m(Angle::degrees(lat_deg), Angle::degrees(lon_deg)).value();
}

TEST(LsfLog, BothStylesOfEstimatedStateSayTheSame) {
  const Datum reference({Angle::degrees(78.2), Angle::degrees(15.6), 40.0});
  Maker relative, absolute;
  for (int k = 0; k < 50; ++k) {
    const double north = 40.0 * k, east = 25.0 * k, down = -100.0 - k;
    relative.relative(k, north, east, down);
    const Geodetic g = reference.geodetic(Point<World>{{north, east, 0}});
    absolute.send(Maker::state(g.latitude.degrees(), g.longitude.degrees(), 40.0 - down), k);
  }
  const AutopilotLog a = parsed(relative).value(), b = parsed(absolute).value();
  ASSERT_EQ(a.positions.size(), 50u);
  ASSERT_EQ(b.positions.size(), 50u);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_NEAR(a.positions[i].latitude.degrees(), b.positions[i].latitude.degrees(), 1e-9);
    EXPECT_NEAR(a.positions[i].longitude.degrees(), b.positions[i].longitude.degrees(), 1e-9);
    EXPECT_NEAR(a.positions[i].height_geoid_m, b.positions[i].height_geoid_m, 1e-4);
  }
  EXPECT_NEAR(a.positions[0].height_geoid_m, 140.0 - geoid_m(78.2, 15.6), 1e-6);
  EXPECT_NEAR(yaw_pitch_roll(a.attitudes[0].ned_from_body).roll.radians(), 0.1, 1e-6);
  EXPECT_NEAR(to_seconds(a.attitudes[7].time), kStart_s + 7, 1e-6);
  EXPECT_FALSE(a.home_height_geoid_m.has_value());
}

TEST(LsfLog, WhatCameBeforeDuneKnewItsPlaceIsLeftOut) {
  Maker maker;
  for (int k = 0; k < 5; ++k) maker.send(Maker::state(0.0001 * k, 0, 0), k);
  for (int k = 5; k < 20; ++k) maker.relative(k, k, 0, -100);
  const AutopilotLog log = parsed(maker).value();
  EXPECT_EQ(log.positions.size(), 15u);
  EXPECT_THAT(log.notes, Contains(HasSubstr("5 states from before DUNE knew")));
}

TEST(LsfLog, TheVehicleIsWhoSentMostStates) {
  Maker maker;
  for (int k = 0; k < 20; ++k) {
    maker.relative(k, k, 0, -100);
    if (k < 5) maker.send(Maker::state(60, 10, 5), k + 0.5, 0x0C0D);
  }
  const AutopilotLog log = parsed(maker).value();
  EXPECT_EQ(log.system, kX8);
  EXPECT_EQ(log.positions.size(), 20u);
  EXPECT_THAT(log.notes, Contains(HasSubstr("of 2 vehicles")));
}

Message gps_fix(double utc_s) {
  const std::chrono::sys_days day{
      std::chrono::floor<std::chrono::days>(time_from_seconds(utc_s).value())};
  const std::chrono::year_month_day date{day};
  Message m = message("GpsFix");
  m.set("validity", 7).set("utc_year", static_cast<int>(date.year()));
  m.set("utc_month", static_cast<unsigned>(date.month()));
  m.set("utc_day", static_cast<unsigned>(date.day()));
  return m.set("utc_time", utc_s - to_seconds(Time(day)));
}

TEST(LsfLog, AClockThatGpsContradictsIsCorrectedAndOneThatItDoesNotIsKept) {
  for (const double ahead_s : {-3600.0, 0.0, 5.0}) {
    Maker maker;
    for (int k = 0; k < 100; ++k) {
      maker.relative(k, k, 0, -100);
      maker.send(gps_fix(kStart_s + k + 0.5 - ahead_s - 0.1), k + 0.5);
    }
    const AutopilotLog log = parsed(maker).value();
    const double expected_s = ahead_s == 0 ? kStart_s : kStart_s - ahead_s;
    EXPECT_NEAR(to_seconds(log.attitudes[0].time), expected_s, 0.15) << ahead_s;
    if (ahead_s == 0)
      EXPECT_THAT(log.notes, Not(Contains(HasSubstr("GPS time"))));
    else
      EXPECT_THAT(log.notes, Contains(HasSubstr(ahead_s > 0 ? "ahead of GPS" : "behind GPS")));
  }
}

TEST(LsfLog, OfAClockThatWasSetBackTheLongestPartIsTaken) {
  Maker maker;
  for (int k = 0; k < 20; ++k) maker.relative(1000 + k, k, 0, -100);
  for (int k = 0; k < 50; ++k) maker.relative(k, k, 0, -100);
  const AutopilotLog log = parsed(maker).value();
  EXPECT_EQ(log.attitudes.size(), 47u);  // three packets pass until the new time is believed
  EXPECT_THAT(log.notes, Contains(HasSubstr("set back 1 times")));
}

TEST(LsfLog, RangesAreThoseOfDevicesThatLookDown) {
  Maker maker;
  for (int k = 0; k < 20; ++k) maker.relative(k, k, 0, -100);
  const auto distance = [&](std::optional<double> theta, double value, int valid = 1) {
    Message m = message("Distance");
    m.set("validity", valid).set("value", value);
    if (theta) m.add("location", message("DeviceState").set("theta", *theta));
    maker.send(m, 10);
  };
  distance(-M_PI / 2, 98.5);
  distance(-M_PI / 2, 55, 0);
  distance(0.0, 3);
  distance(std::nullopt, 4);
  const AutopilotLog log = parsed(maker).value();
  ASSERT_EQ(log.ranges.size(), 1u);
  EXPECT_EQ(log.ranges[0].range_m, 98.5);
  EXPECT_THAT(log.notes, Contains(HasSubstr("2 Distances of devices not known to look down")));
}

TEST(LsfLog, HomePositionIsWhereItTookOff) {
  Maker maker;
  for (int k = 0; k < 20; ++k) maker.relative(k, k, 0, -100);
  maker.send(message("HomePosition").set("height", 41.0), 19);
  EXPECT_NEAR(parsed(maker)->home_height_geoid_m.value(), 41.0 - geoid_m(78.2, 15.6), 1e-3);
}

TEST(LsfLog, SaysWhatIsWrong) {
  Maker empty;
  empty.log.assign(100, 'x');
  EXPECT_THAT(parsed(empty).error().message, HasSubstr("holds no IMC packet"));
  Maker blind;
  blind.send(message("Heartbeat"), 0);
  EXPECT_EQ(parsed(blind).error().code, ErrorCode::NotFound);
  const imc::Schema other = imc::Schema::from_xml(
                                "<messages><message id='350' abbrev='EstimatedState'>"
                                "<field abbrev='lat' type='plaintext'/></message></messages>")
                                .value();
  EXPECT_EQ(parse_lsf(blind.log, other, "x").error().code, ErrorCode::Unsupported);
}

TEST(LsfLog, OfARunningDuneGivesItsTrajectory) {
  const auto folder = test::real_data("autopilot_logs/dune_x8");
  if (!folder) GTEST_SKIP() << "the real data is not here";
  const auto text = [&](const char* name) {
    return gunzip(read_bytes(*folder / name).value(), 1 << 24).value().bytes;
  };
  const Bytes log_bytes = text("Data.lsf.gz"), xml = text("IMC.xml.gz");
  const imc::Schema own =
      imc::Schema::from_xml({reinterpret_cast<const char*>(xml.data()), xml.size()}).value();
  const AutopilotLog log = parse_lsf(log_bytes, imc::Schema::builtin(), "Data.lsf.gz").value();
  const AutopilotLog again = parse_lsf(log_bytes, own, "Data.lsf.gz").value();
  EXPECT_EQ(log.system, kX8);
  ASSERT_EQ(log.positions.size(), 641u);
  ASSERT_EQ(again.positions.size(), 641u);
  for (std::size_t i = 0; i < 641; ++i) {
    EXPECT_EQ(log.positions[i].latitude.radians(), again.positions[i].latitude.radians());
    EXPECT_EQ(log.positions[i].time, again.positions[i].time);
  }
  // 858.03 m north and 708.71 m east of the reference at its end, 150 m above the ellipsoid.
  const PositionSample& last = log.positions.back();
  EXPECT_NEAR(last.height_geoid_m + geoid_m(last.latitude.degrees(), last.longitude.degrees()),
              150.0, 1e-3);
  const Datum reference(
      {Angle::radians(1.3652890433603202), Angle::radians(0.2727251489166339), 0});
  const Point<World> p = reference.world({last.latitude, last.longitude, 0.0});
  EXPECT_NEAR(p.v.x(), 858.03, 0.01);
  EXPECT_NEAR(p.v.y(), 708.71, 0.01);
  const Trajectory trajectory = make_trajectory(log, reference).value();
  EXPECT_EQ(trajectory.poses().size(), 641u);
}

}  // namespace
}  // namespace watersky
