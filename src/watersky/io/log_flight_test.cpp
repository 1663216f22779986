// SPDX-License-Identifier: MIT
#include "watersky/io/log_flight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "support/make_photo.hpp"
#include "watersky/io/autopilot_log.hpp"
#include "watersky/io/name_time.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/wire/tlog.hpp"

namespace watersky {
namespace {

using mavlink::Message;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using watersky::test::Bytes;
using watersky::test::make_photo;
using watersky::test::Photo;
using watersky::test::TemporaryFolder;
using watersky::test::write;

constexpr Time kBoot{std::chrono::seconds(1'533'430'800)};  // 2018-08-05T01:00:00Z

Message message(const char* name) { return Message(*mavlink::find_message(name)); }

/// A log of a straight flight: north at 10 m/s, 80 m above home, heading 30°, roll following time.
/// Messages arrive with a delay that is never below 20 ms.
struct LogMaker {
  std::mt19937 rng{7};
  Bytes log;
  double drift = 0.0;  ///< of the autopilot's crystal
  std::uint8_t system = 1;

  void send(const Message& m, double boot_s, int component = 1) {
    const double delay = 0.020 + std::exponential_distribution(1 / 0.03)(rng);
    const Time stamp = kBoot + seconds(boot_s * (1 + drift) + delay);
    mavlink::append_tlog_record(
        log, stamp, mavlink::encode(m, {system, static_cast<std::uint8_t>(component), 0}).value());
  }
  static double roll(double t) { return 0.1 * std::sin(t); }
  void attitude(double t) {
    Message m = message("ATTITUDE");
    m.set("time_boot_ms", t * 1e3).set("roll", roll(t)).set("yaw", Angle::degrees(30).radians());
    send(m, t);
  }
  void position(double t, double lat0 = 78.9) {
    Message m = message("GLOBAL_POSITION_INT");
    const double north_deg = 10.0 * t / 111'660.0;
    m.set("time_boot_ms", t * 1e3).set("lat", (lat0 + north_deg) * 1e7).set("lon", 11.9e7);
    m.set("alt", 95e3).set("relative_alt", 80e3);
    send(m, t);
  }
  LogMaker& fly(double from, double to) {
    for (int k = static_cast<int>(from * 10); k < to * 10; ++k) {
      attitude(k * 0.1);
      if (k % 2 == 0) position(k * 0.1 + 0.01);
    }
    return *this;
  }
};

std::string utc_name(double t) {
  const std::string iso = to_iso8601(kBoot + seconds(t));
  std::string digits;
  for (const char c : iso)
    if (std::isdigit(static_cast<unsigned char>(c))) digits += c;
  return digits + "Z.jpg";
}

Bytes plain_photo() {
  Photo p;
  p.make = p.model = "";
  return make_photo(p);
}

const std::string kCamera =
    "image_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, data: [60., 0., 31.5, "
    "0., 60., 23.5, 0., 0., 1.]}\n";

void make_folder(const TemporaryFolder& folder, const Bytes& log,
                 std::initializer_list<double> times) {
  write(folder.path() / "camera.yaml", kCamera);
  write(folder.path() / "flight.tlog", log);
  for (const double t : times) write(folder.path() / utc_name(t), plain_photo());
}

TEST(LowerLine, LiesBelowEveryPointAndFindsDriftUnderJitter) {
  std::mt19937 rng(8);
  for (int trial = 0; trial < 50; ++trial) {
    const double slope = std::uniform_real_distribution(-1e-4, 1e-4)(rng);
    std::vector<std::pair<double, double>> xy;
    for (int i = 0; i < 2000; ++i)
      xy.emplace_back(i * 0.5,
                      3.0 + slope * i * 0.5 + std::exponential_distribution(1 / 0.05)(rng));
    const LowerLine line = fit_lower_line(xy, 120, 200e-6);
    for (const auto& [x, y] : xy) EXPECT_LE(line.at(x), y + 1e-9);
    EXPECT_NEAR(line.slope, slope, 5e-6);
    EXPECT_NEAR(line.at(500), 3.0 + slope * 500, 0.002);
  }
}

TEST(LowerLine, IsFlatWhereTheLogIsTooShortToTellDrift) {
  const std::vector<std::pair<double, double>> xy = {{0, 2}, {1, 1}, {2, 5}};
  EXPECT_EQ(fit_lower_line(xy, 120, 1).slope, 0);
  EXPECT_EQ(fit_lower_line(xy, 120, 1).at(7), 1);
  EXPECT_EQ(fit_lower_line(std::span(xy).first(1), 120, 1).at(0), 2);
}

// Arrival is late by 20 ms at least: that much no log can tell. Beyond it boot times rule.
TEST(AutopilotLog, GoesByWhenThingsWereMeasuredAndNotByWhenTheyArrived) {
  for (const double drift : {0.0, 50e-6}) {
    LogMaker maker;
    maker.drift = drift;
    maker.fly(0, 300);
    const AutopilotLog log = parse_tlog(maker.log, "x.tlog").value();
    ASSERT_THAT(log.attitudes, SizeIs(3000));
    double worst = 0;
    for (std::size_t i = 0; i < log.attitudes.size(); ++i) {
      const double t = 0.1 * static_cast<double>(i);
      worst = std::max(
          worst, std::abs(to_seconds(log.attitudes[i].time - kBoot) - (t * (1 + drift) + 0.020)));
    }
    EXPECT_LT(worst, 0.002);
    EXPECT_NEAR(log.home_height_geoid_m.value(), 15.0, 1e-9);
  }
}

TEST(AutopilotLog, PosesAreTheMeasuredMotion) {
  LogMaker maker;
  maker.fly(0, 60);
  const AutopilotLog log = parse_tlog(maker.log, "x.tlog").value();
  const Datum datum({Angle::degrees(78.9), Angle::degrees(11.9), 0});
  const Trajectory trajectory = make_trajectory(log, datum).value();
  for (double t = 1; t < 59; t += 0.37) {
    const auto pose = trajectory.at(kBoot + seconds(t + 0.020), std::chrono::milliseconds(200));
    ASSERT_TRUE(pose) << pose.error().message;
    EXPECT_NEAR(pose->world_from_body.origin().v.x(), 10.0 * t, 0.15);
    const YawPitchRoll a = yaw_pitch_roll(pose->world_from_body.rotation());
    EXPECT_NEAR(a.roll.radians(), LogMaker::roll(t), 2e-3);
    EXPECT_NEAR(a.yaw.degrees(), 30, 0.01);
  }
}

TEST(AutopilotLog, AGapInPositionIsAGapInPoses) {
  LogMaker maker;
  maker.fly(0, 10);
  for (double t = 10; t < 20; t += 0.1) maker.attitude(t);
  maker.fly(20, 30);
  const AutopilotLog log = parse_tlog(maker.log, "x.tlog").value();
  const Trajectory trajectory =
      make_trajectory(log, Datum({Angle::degrees(78.9), Angle::degrees(11.9), 0})).value();
  EXPECT_FALSE(trajectory.at(kBoot + seconds(15), std::chrono::seconds(1)));
  EXPECT_TRUE(trajectory.at(kBoot + seconds(5), std::chrono::seconds(1)));
}

TEST(AutopilotLog, SurvivesARebootOfTheAutopilot) {
  LogMaker maker;
  maker.fly(0, 30);
  // After 40 s of silence boot time begins anew.
  LogMaker second;
  second.fly(0, 30);
  mavlink::TlogReader reader(second.log);
  while (const auto record = reader.next())
    mavlink::append_tlog_record(maker.log, record->received_at + std::chrono::seconds(70),
                                record->frame.bytes);
  const AutopilotLog log = parse_tlog(maker.log, "x.tlog").value();
  EXPECT_NEAR(to_seconds(log.attitudes.back().time - kBoot), 99.9, 0.03);
  EXPECT_THAT(log.notes, Contains(HasSubstr("restarted 1 times")));
}

TEST(AutopilotLog, TakesTheVehicleThatHasPosesAndSaysWhich) {
  LogMaker maker;
  maker.system = 7;
  maker.fly(0, 5);
  maker.system = 2;
  maker.fly(0, 20);
  maker.system = 255;
  maker.send(message("HEARTBEAT"), 1);
  const AutopilotLog log = parse_tlog(maker.log, "x.tlog").value();
  EXPECT_EQ(log.system, 2);
  EXPECT_THAT(log.notes, Contains(HasSubstr("system 2")));
  LogMaker blind;
  for (int i = 0; i < 10; ++i) blind.attitude(i);
  EXPECT_EQ(parse_tlog(blind.log, "x.tlog").error().code, ErrorCode::NotFound);
  EXPECT_EQ(parse_tlog(Bytes(100, 'x'), "x.tlog").error().code, ErrorCode::InvalidInput);
}

// Only of a range finder that looks down, and only what lies within its reach.
TEST(AutopilotLog, ReadsARangeFinderThatLooksDown) {
  LogMaker maker;
  maker.fly(0, 20);
  const auto range = [&](double t, double cm, int orientation, int covariance = 4,
                         int quality = 0) {
    Message m = message("DISTANCE_SENSOR");
    m.set("time_boot_ms", t * 1e3).set("min_distance", 20).set("max_distance", 12000);
    m.set("current_distance", cm).set("orientation", orientation);
    m.set("covariance", covariance).set("signal_quality", quality);
    maker.send(m, t);
  };
  for (int k = 0; k < 50; ++k) range(5 + 0.1 * k, 8000 + k, 25);
  range(11, 9000, 0);         // looks ahead
  range(12, 12000, 25);       // out of reach
  range(13, 20, 25);          // too near
  range(14, 9000, 25, 4, 1);  // said to be invalid
  range(15, 9100, 25, 255, 100);
  const auto log = parse_tlog(maker.log, "flight.tlog");
  ASSERT_TRUE(log) << log.error().message;
  ASSERT_THAT(log->ranges, SizeIs(51));
  EXPECT_NEAR(to_seconds(log->ranges[0].time - kBoot), 5.02, 0.005);
  EXPECT_DOUBLE_EQ(log->ranges[0].range_m, 80.0);
  EXPECT_DOUBLE_EQ(log->ranges[0].sigma_m, 0.02);
  EXPECT_DOUBLE_EQ(log->ranges[50].range_m, 91.0);
  EXPECT_EQ(log->ranges[50].sigma_m, 0.0);

  const TemporaryFolder folder;
  make_folder(folder, maker.log, {6, 8, 10});
  EXPECT_THAT(read_flight(folder.path())->ranges, SizeIs(51));
  // A file beside the photographs, as somebody has put it there, goes before the log.
  write(folder.path() / "range.csv", std::string("time_s,range_m\n1533430806,80\n"));
  write(folder.path() / "gcp_list.txt", "EPSG:4326\n11.9 78.9 NaN 3 4 " + utc_name(8) + " cairn\n");
  const auto flight = read_flight(folder.path());
  ASSERT_TRUE(flight) << flight.error().message;
  EXPECT_THAT(flight->ranges, SizeIs(1));
  ASSERT_THAT(flight->anchors, SizeIs(1));
  EXPECT_EQ(flight->anchors[0].sightings.at(0).frame, utc_name(8));
}

TEST(LogFlight, PlacesPhotographsByTheTimeInTheirNames) {
  const TemporaryFolder folder;
  make_folder(folder, LogMaker().fly(0, 60).log, {10.0, 20.55, 30.25});
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, -5};
  const auto flight = read_flight(folder.path(), options);
  ASSERT_TRUE(flight) << flight.error().message;
  ASSERT_EQ(flight->frames.size(), 3u);
  EXPECT_TRUE(flight->mount.assumed);
  EXPECT_THAT(flight->notes, Contains(HasSubstr("assumed that the camera looks straight down")));
  const auto pose = flight->camera_pose(flight->frames[1], std::chrono::milliseconds(500));
  ASSERT_TRUE(pose) << pose.error().message;
  EXPECT_NEAR(-pose->sea_from_camera.origin().v.z(), 85.0, 1e-3);
  // The image top points forward: 30° from north.
  const Eigen::Vector3d top = (pose->sea_from_camera * Vector<Camera>{{0, -1, 0}}).v;
  EXPECT_NEAR(Angle::radians(std::atan2(top.y(), top.x())).degrees(), 30, 0.5);
}

TEST(LogFlight, FramesOutsideTheLogHaveNoPose) {
  const TemporaryFolder folder;
  make_folder(folder, LogMaker().fly(0, 20).log, {10.0, 30.0});
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, 0};
  const Flight flight = read_flight(folder.path(), options).value();
  ASSERT_EQ(flight.frames.size(), 2u);
  EXPECT_TRUE(flight.camera_pose(flight.frames[0], std::chrono::seconds(1)));
  EXPECT_THAT(flight.camera_pose(flight.frames[1], std::chrono::seconds(1)).error().message,
              HasSubstr("after the last recorded pose"));
}

TEST(LogFlight, ADamagedLogIsReadAndItSaysWhatWasSkipped) {
  const TemporaryFolder folder;
  Bytes log = LogMaker().fly(0, 30).log;
  log.insert(log.begin() + 36 * 40, 100, 0xFD);
  log.resize(log.size() - 7);
  make_folder(folder, log, {10.0});
  const Flight flight = read_flight(folder.path()).value();
  EXPECT_THAT(flight.notes, Contains(HasSubstr("no MAVLink")));
  EXPECT_THAT(flight.notes, Contains(HasSubstr("ends in the middle of a message")));
  EXPECT_TRUE(flight.trajectory.at(*flight.frames[0].captured_at, std::chrono::milliseconds(500)));
}

TEST(LogFlight, CameraFeedbackTellsTimesByCountOrByIndex) {
  LogMaker maker;
  maker.fly(0, 10);
  for (int k = 0; k < 4; ++k) {
    maker.fly(10 + 2 * k, 12 + 2 * k);
    if (k == 2) continue;  // lost by the radio
    Message m = message("CAMERA_FEEDBACK");
    m.set("time_usec", (11.5 + 2 * k) * 1e6).set("img_idx", 100 + k);
    maker.send(m, 11.8 + 2 * k);
    maker.send(m, 11.9 + 2 * k);
  }
  const TemporaryFolder folder;
  write(folder.path() / "camera.yaml", kCamera);
  write(folder.path() / "flight.tlog", maker.log);
  for (const char* name : {"a.jpg", "b.jpg", "c.jpg", "d.jpg"})
    write(folder.path() / name, plain_photo());
  const Flight flight = read_flight(folder.path()).value();
  ASSERT_EQ(flight.frames.size(), 3u);
  EXPECT_THAT(flight.left_out, SizeIs(1));
  EXPECT_EQ(flight.left_out[0].file, "c.jpg");
  EXPECT_EQ(flight.frames[2].name, "d.jpg");
  EXPECT_NEAR(to_seconds(*flight.frames[2].captured_at - kBoot), 17.5 + 0.020, 0.01);
}

TEST(LogFlight, AGimbalInTheLogStandsBetweenBodyAndCamera) {
  LogMaker maker;
  for (int k = 0; k < 200; ++k) {
    maker.attitude(k * 0.1);
    maker.position(k * 0.1 + 0.01);
    Message m = message("GIMBAL_DEVICE_ATTITUDE_STATUS");
    const Eigen::Quaterniond q = rotation_from({Angle::degrees(10), Angle::degrees(-90), {}});
    m.set("time_boot_ms", k * 100)
        .set("q", q.w(), 0)
        .set("q", q.x(), 1)
        .set("q", q.y(), 2)
        .set("q", q.z(), 3);
    m.set("flags", 0x20);  // yaw against the vehicle
    maker.send(m, k * 0.1, 154);
  }
  const TemporaryFolder folder;
  make_folder(folder, maker.log, {10.0});
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, 0};
  const Flight flight = read_flight(folder.path(), options).value();
  EXPECT_FALSE(flight.mount.assumed);
  const auto pose = flight.camera_pose(flight.frames[0], std::chrono::seconds(1)).value();
  const Eigen::Vector3d top = (pose.sea_from_camera * Vector<Camera>{{0, -1, 0}}).v;
  EXPECT_NEAR(Angle::radians(std::atan2(top.y(), top.x())).degrees(), 40,
              0.1);  // 30 of the vehicle, 10 of the gimbal
}

TEST(LogFlight, PhotographsWithoutATimeAreNotGuessedAt) {
  const TemporaryFolder folder;
  make_folder(folder, LogMaker().fly(0, 20).log, {});
  Photo p;
  p.make = p.model = "";
  write(folder.path() / "IMG_1.jpg", make_photo(p));
  EXPECT_THAT(read_flight(folder.path()).error().message, HasSubstr("records no time"));
  p.taken = "2018:08:05 03:00:10";
  write(folder.path() / "IMG_1.jpg", make_photo(p));
  EXPECT_THAT(read_flight(folder.path()).error().message, HasSubstr("no time zone"));
  ReadOptions options;
  options.camera_utc_offset_h = 2.0;
  EXPECT_EQ(read_flight(folder.path(), options)->frames[0].captured_at,
            kBoot + std::chrono::seconds(10));
  p.offset = "+02:00";
  write(folder.path() / "IMG_1.jpg", make_photo(p));
  EXPECT_EQ(read_flight(folder.path())->frames[0].captured_at, kBoot + std::chrono::seconds(10));
  options.name_pattern = "YYYYMMDDhhmmss";
  EXPECT_EQ(read_flight(folder.path(), options).error().code, ErrorCode::Usage);
}

TEST(LogFlight, ADelayMakesTimesArrivals) {
  const TemporaryFolder folder;
  make_folder(folder, LogMaker().fly(0, 20).log, {10.0});
  ReadOptions options;
  options.delay_s = 0.5;
  const Flight flight = read_flight(folder.path(), options).value();
  EXPECT_FALSE(flight.frames[0].captured_at);
  EXPECT_EQ(flight.capture_time(flight.frames[0]).value(), kBoot + std::chrono::milliseconds(9500));
}

TEST(LogFlight, TwoLogsNeedAChoice) {
  const TemporaryFolder folder;
  make_folder(folder, LogMaker().fly(0, 20).log, {10.0});
  write(folder.path() / "other.tlog", std::string("x"));
  EXPECT_THAT(read_flight(folder.path()).error().message, HasSubstr("--log"));
  ReadOptions options;
  options.log = folder.path() / "flight.tlog";
  EXPECT_TRUE(read_flight(folder.path(), options));
}

TEST(NameTime, RecognisesWhatSaysItIsUtc) {
  const auto text = [](const char* stem) {
    const auto t = utc_from_name(stem);
    return t ? to_iso8601(*t) : std::string("none");
  };
  EXPECT_EQ(text("2018080501004480Z"), "2018-08-05T01:00:44.800Z");
  EXPECT_EQ(text("cam0_20180805T010044.48Z_raw"), "2018-08-05T01:00:44.480Z");
  EXPECT_EQ(text("2018-08-05T01-00-44Z"), "2018-08-05T01:00:44.000Z");
  EXPECT_EQ(text("2018-08-05_01-00-44.125Z"), "2018-08-05T01:00:44.125Z");
  EXPECT_EQ(text("1533430844.48"), "2018-08-05T01:00:44.480Z");
  EXPECT_EQ(text("frame1533430844480"), "2018-08-05T01:00:44.480Z");
  EXPECT_EQ(text("1533430844480000"), "2018-08-05T01:00:44.480Z");
  for (const char* local : {"DJI_20180805010044_0001", "20180805_010044", "DJI_0018",
                            "IMG_1533430844_2", "", "2018130501004480Z", "20180805010044804Z9Z8"})
    EXPECT_EQ(text(local),
              std::string(local) == "20180805010044804Z9Z8" ? "2018-08-05T01:00:44.804Z" : "none")
        << local;
}

TEST(NameTime, FollowsAPattern) {
  EXPECT_EQ(to_iso8601(time_from_name("DJI_20180805010044_0001", "YYYYMMDDhhmmss").value()),
            "2018-08-05T01:00:44.000Z");
  EXPECT_EQ(to_iso8601(time_from_name("x05.08.2018 01h00_44,48", "DD.MM.YYYY hh?mm_ss,cc").value()),
            "2018-08-05T01:00:44.480Z");
  EXPECT_FALSE(time_from_name("DJI_0001", "YYYYMMDDhhmmss"));
  EXPECT_FALSE(check_name_pattern("YYYYMMDD"));
  EXPECT_TRUE(check_name_pattern("YYYYMMDDhhmmsscc"));
}

// The data's description: "every frame has log records within 0.25 s; 79 to 83 m above take-off,
// 15 s, heading about 332°, roll up to 10°".
TEST(LogFlight, CuavFlightIsPlacedWhole) {
  const auto data = watersky::test::real_data("cuav_flight");
  if (!data) GTEST_SKIP() << "the real data is not here";
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, 0};
  const auto flight = read_flight(*data, options);
  ASSERT_TRUE(flight) << flight.error().message;
  ASSERT_EQ(flight->frames.size(), 18u);
  EXPECT_EQ(flight->calibration.description, "camera.yaml");
  double highest_roll = 0;
  for (const ImageFrame& frame : flight->frames) {
    const auto pose = flight->camera_pose(frame, std::chrono::milliseconds(500));
    ASSERT_TRUE(pose) << frame.name << ": " << pose.error().message;
    const double height = -pose->sea_from_camera.origin().v.z();
    EXPECT_GT(height, 78.5) << frame.name;
    EXPECT_LT(height, 83.5) << frame.name;
    const auto body = flight->trajectory.at(pose->time, std::chrono::milliseconds(500)).value();
    const YawPitchRoll a = yaw_pitch_roll(body.world_from_body.rotation());
    EXPECT_NEAR((a.yaw - Angle::degrees(332)).wrapped().degrees(), 0, 15) << frame.name;
    highest_roll = std::max(highest_roll, std::abs(a.roll.degrees()));
  }
  EXPECT_GT(highest_roll, 5.0);
  EXPECT_LT(highest_roll, 12.0);
}

}  // namespace
}  // namespace watersky
