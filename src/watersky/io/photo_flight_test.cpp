// SPDX-License-Identifier: MIT
#include "watersky/io/photo_flight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/make_photo.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/exif.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/read_flight.hpp"

namespace watersky {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using watersky::test::Bytes;
using watersky::test::make_photo;
using watersky::test::Photo;
using watersky::test::TemporaryFolder;
using watersky::test::write;

/// 40 m above take-off, looking straight down, image top east, 11 m further north each second.
Photo photo(int i) {
  Photo p;
  p.width_px = 400;
  p.height_px = 300;
  p.focal_mm = 3.61;
  p.latitude_deg = 78.9 + 1e-4 * i;
  p.longitude_deg = 11.9;
  p.altitude_m = 198.3;
  p.taken = "2016:06:23 16:31:" + std::to_string(10 + i);
  p.dji = {{"GimbalYawDegree", "+90.00"},  {"GimbalPitchDegree", "-90.00"},
           {"GimbalRollDegree", "+0.00"},  {"FlightYawDegree", "+80.00"},
           {"FlightPitchDegree", "+2.00"}, {"FlightRollDegree", "-3.00"},
           {"RelativeAltitude", "+40.00"}, {"AbsoluteAltitude", "+198.30"}};
  return p;
}

std::string name(int i) { return "DJI_00" + std::to_string(10 + i) + ".JPG"; }

const SeaLevelOption kSea{SeaReference::TakeOff, -5.0};

TEST(PhotoFlight, APointRightOfTheImageCentreLiesSouthWhenTheImageTopIsEast) {
  const TemporaryFolder folder;
  for (int i = 0; i < 3; ++i) write(folder.path() / name(i), make_photo(photo(i)));
  ReadOptions options;
  options.sea_level = kSea;
  const auto flight = read_flight(folder.path(), options);
  ASSERT_TRUE(flight) << flight.error().message;
  ASSERT_EQ(flight->frames.size(), 3u);
  const auto pose = flight->camera_pose(flight->frames[2], Duration{0});
  ASSERT_TRUE(pose) << pose.error().message;
  // 45 m above the sea, whatever the nominal altitudes say.
  EXPECT_NEAR(-pose->sea_from_camera.origin().v.z(), 45.0, 1e-6);
  const auto direction = [&](double x, double y, double z) {
    return (pose->sea_from_camera * Vector<Camera>{{x, y, z}}).v;
  };
  EXPECT_LT((direction(0, 0, 1) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);   // down
  EXPECT_LT((direction(0, -1, 0) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-9);  // image top: east
  EXPECT_LT((direction(1, 0, 0) - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-9);  // image right: south
  // Two ten-thousandths of a degree of latitude at 78.9 N, by the meridian's radius of curvature.
  EXPECT_NEAR(pose->world_from_camera.origin().v.x(), 22.33, 0.01);
  EXPECT_FALSE(flight->mount.assumed);
  EXPECT_THAT(flight->calibration.description, HasSubstr("Phantom 3"));
}

TEST(PhotoFlight, TheNominalAltitudeEntersOnlyAgainstGeoidOrEllipsoid) {
  const TemporaryFolder a, b;
  for (int i = 0; i < 3; ++i) {
    Photo p = photo(i);
    write(a.path() / name(i), make_photo(p));
    p.dji["AbsoluteAltitude"] = "+300.00";
    write(b.path() / name(i), make_photo(p));
  }
  const auto height = [](const TemporaryFolder& folder, const SeaLevelOption& sea) {
    ReadOptions options;
    options.sea_level = sea;
    const Flight flight = read_flight(folder.path(), options).value();
    return flight.camera_pose(flight.frames[0], Duration{0}).value().sea_from_camera.origin().v.z();
  };
  EXPECT_NEAR(height(a, kSea), height(b, kSea), 1e-6);
  EXPECT_NEAR(height(a, {SeaReference::Geoid, 0}), -198.3, 1e-6);
  EXPECT_NEAR(height(b, {SeaReference::Geoid, 0}), -300.0, 1e-6);
}

TEST(PhotoFlight, RtkHeightsAreAboveTheEllipsoidAndHaveSigmas) {
  const TemporaryFolder folder;
  for (int i = 0; i < 2; ++i) {
    Photo p = photo(i);
    p.dji["RtkFlag"] = "50";
    p.dji["RtkStdLat"] = "0.011";
    p.dji["RtkStdLon"] = "0.012";
    p.dji["RtkStdHgt"] = "0.03";
    write(folder.path() / name(i), make_photo(p));
  }
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::Ellipsoid, 0};
  const Flight flight = read_flight(folder.path(), options).value();
  const auto pose = flight.camera_pose(flight.frames[1], Duration{0}).value();
  EXPECT_NEAR(pose.camera.height_ellipsoid_m, 198.3, 1e-6);
  ASSERT_TRUE(pose.sigma);
  EXPECT_EQ(pose.sigma->position_north_east_down_m, Eigen::Vector3d(0.011, 0.012, 0.03));
  options.sea_level = kSea;
  const Flight by_takeoff = read_flight(folder.path(), options).value();
  EXPECT_NEAR(
      by_takeoff.camera_pose(by_takeoff.frames[1], Duration{0})->sea_from_camera.origin().v.z(),
      -45.0, 0.01);
}

TEST(PhotoFlight, MarksGiveSigmasAndTimes) {
  // The form of DJI's own files; GPS week 1902 begins 2016-06-19.
  const std::string mrk =
      "10\t407400.500000\t[1902]\t   -51,N\t   -79,E\t   "
      "242,V\t78.90000000,Lat\t11.90000000,Lon\t77.894,Ellh\t0.012127, 0.011934, 0.027352\t50,Q\n"
      "10\t407400.500000\t[1902]\t0,N\t0,E\t0,V\t60.00000000,Lat\t11.90000000,Lon\t77.894,Ellh\t9, "
      "9, 9\t50,Q\n"
      "not a mark\n";
  const auto marks = parse_rtk_marks(mrk);
  ASSERT_THAT(marks, SizeIs(2));
  EXPECT_EQ(to_iso8601(marks[0].utc.value()), "2016-06-23T17:09:42.500Z");  // 18 s behind GPS
  const TemporaryFolder folder;
  write(folder.path() / name(0), make_photo(photo(0)));
  write(folder.path() / name(1), make_photo(photo(1)));
  write(folder.path() / "Timestamp.MRK", mrk);
  const Flight flight = read_photo_flight(folder.path(), {}).value().flight;
  ASSERT_TRUE(flight.frames[0].own_pose->sigma);
  EXPECT_EQ(flight.frames[0].own_pose->sigma->position_north_east_down_m.z(), 0.027352);
  EXPECT_FALSE(flight.frames[1].own_pose->sigma);
}

TEST(PhotoFlight, WithoutAttitudeAPhotographIsLeftOutOrTakenAsNadirWhenTold) {
  const TemporaryFolder folder;
  for (int i = 0; i < 4; ++i) {
    Photo p = photo(i);
    p.dji = {{"RelativeAltitude", "+40.00"}, {"AbsoluteAltitude", "+198.30"}};
    p.longitude_deg = 11.9 + 5e-4 * i;  // 11.2 m north and 10.8 m east each
    write(folder.path() / name(i), make_photo(p));
  }
  const Flight none = read_photo_flight(folder.path(), {}).value().flight;
  EXPECT_EQ(none.frames.size(), 0u);
  ASSERT_THAT(none.left_out, SizeIs(4));
  EXPECT_THAT(none.left_out[0].reason, HasSubstr("no attitude"));

  ReadOptions options;
  options.assume_nadir = true;
  options.sea_level = kSea;
  const Flight flight = read_flight(folder.path(), options).value();
  ASSERT_EQ(flight.frames.size(), 4u);
  const auto pose = flight.camera_pose(flight.frames[1], Duration{0}).value();
  const Eigen::Vector3d top = (pose.sea_from_camera * Vector<Camera>{{0, -1, 0}}).v;
  EXPECT_NEAR(Angle::radians(std::atan2(top.y(), top.x())).degrees(), 43.9, 0.5);
  ASSERT_TRUE(pose.sigma);
  EXPECT_GT(pose.sigma->roll_pitch_yaw_rad.minCoeff(), 0.05);
  EXPECT_THAT(flight.notes, Contains(HasSubstr("straight down")));
}

TEST(PhotoFlight, ABodyAttitudeAloneNeedsAMount) {
  const TemporaryFolder folder;
  Photo p = photo(0);
  for (const char* key : {"GimbalYawDegree", "GimbalPitchDegree", "GimbalRollDegree"})
    p.dji.erase(key);
  write(folder.path() / name(0), make_photo(p));
  const Flight assumed = read_photo_flight(folder.path(), {}).value().flight;
  EXPECT_TRUE(assumed.mount.assumed);
  EXPECT_THAT(assumed.notes, Contains(HasSubstr("straight down")));
  ReadOptions options;
  options.mount = parse_mount_option("0,-60,0").value();
  EXPECT_FALSE(read_photo_flight(folder.path(), options).value().flight.mount.assumed);
}

TEST(PhotoFlight, MixedCamerasAreNamed) {
  for (int kind = 0; kind < 3; ++kind) {
    const TemporaryFolder folder;
    write(folder.path() / name(0), make_photo(photo(0)));
    Photo other = photo(1);
    if (kind == 0) other.model = "FC330";
    if (kind == 1) other.height_px = 225;
    if (kind == 2) other.focal_mm = 5.0;
    write(folder.path() / name(1), make_photo(other));
    const auto flight = read_flight(folder.path());
    ASSERT_FALSE(flight) << kind;
    EXPECT_THAT(flight.error().message,
                AllOf(HasSubstr("two cameras are mixed"), HasSubstr(name(0)), HasSubstr(name(1))));
  }
}

TEST(PhotoFlight, ACalibrationForAnotherShapeIsRefusedAndOneOfTheSameIsScaled) {
  const TemporaryFolder folder;
  write(folder.path() / name(0), make_photo(photo(0)));
  const auto yaml = [](int w, int h) {
    return "image_width: " + std::to_string(w) + "\nimage_height: " + std::to_string(h) +
           "\ncamera_matrix: {rows: 3, cols: 3, data: [2000., 0., 999.5, 0., 2000., 562., 0., 0., "
           "1.]}\n";
  };
  write(folder.path() / "camera.yaml", yaml(1640, 922));
  const auto wrong = read_flight(folder.path());
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message,
              AllOf(HasSubstr("1640x922"), HasSubstr("400x300"), HasSubstr(name(0))));
  write(folder.path() / "camera.yaml", yaml(2000, 1500));
  const auto scaled = read_flight(folder.path());
  ASSERT_TRUE(scaled) << scaled.error().message;
  EXPECT_NEAR(scaled->camera.focal_px(), 400, 1e-9);
  EXPECT_THAT(scaled->notes, Contains(HasSubstr("scaled")));
}

TEST(PhotoFlight, AnEmptyFolderAndPhotographsWithoutPositionSayWhatToDo) {
  const TemporaryFolder folder;
  const auto empty = read_flight(folder.path());
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::NotFound);
  EXPECT_THAT(empty.error().message, HasSubstr("holds no photographs"));
  Photo p = photo(0);
  p.latitude_deg.reset();
  write(folder.path() / name(0), make_photo(p));
  EXPECT_THAT(read_flight(folder.path()).error().message, HasSubstr("--log"));
  EXPECT_EQ(read_flight(folder.path() / "absent").error().code, ErrorCode::NotFound);
}

TEST(PhotoFlight, ATruncatedPhotographStaysAndItsLoaderSaysWhy) {
  const TemporaryFolder folder;
  for (int i = 0; i < 3; ++i) write(folder.path() / "images" / name(i), make_photo(photo(i)));
  Bytes cut = make_photo(photo(3));
  cut.resize(cut.size() - 1000);
  write(folder.path() / "images" / name(3), cut);
  write(folder.path() / "images" / name(4), Bytes(cut.begin(), cut.begin() + 100));
  const Flight flight = read_flight(folder.path()).value();
  ASSERT_EQ(flight.frames.size(), 4u);
  EXPECT_TRUE(flight.frames[2].load({}));
  EXPECT_THAT(flight.frames[3].load({}).error().message, HasSubstr(name(3)));
  ASSERT_THAT(flight.left_out, SizeIs(1));
  EXPECT_EQ(flight.left_out[0].file, name(4));
}

TEST(PhotoFlight, NoHeightAboveTakeOffMeansNoTakeOffSeaLevel) {
  const TemporaryFolder folder;
  Photo p = photo(0);
  p.dji.erase("RelativeAltitude");
  write(folder.path() / name(0), make_photo(p));
  ReadOptions options;
  options.sea_level = kSea;
  EXPECT_THAT(read_flight(folder.path(), options).error().message, HasSubstr("take-off"));
  options.sea_level = SeaLevelOption{SeaReference::Geoid, 0};
  const Flight flight = read_flight(folder.path(), options).value();
  EXPECT_NEAR(flight.camera_pose(flight.frames[0], Duration{0})->sea_from_camera.origin().v.z(),
              -198.3, 1e-6);
}

TEST(PhotoFlight, BrightonBeachIsReadWhole) {
  const auto data = watersky::test::real_data("brighton_beach");
  if (!data) GTEST_SKIP() << "the real data is not here";
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, 0};
  const auto flight = read_flight(*data, options);
  ASSERT_TRUE(flight) << flight.error().message;
  ASSERT_EQ(flight->frames.size(), 18u);
  EXPECT_THAT(flight->left_out, SizeIs(0));
  EXPECT_NEAR(flight->camera.focal_px(), 2340, 10);
  const auto t = CsvTable::parse(read_text(*data / "poses.csv").value(), "poses.csv").value();
  for (std::size_t row = 0; row < t.rows(); ++row) {
    const auto value = [&](const char* column) {
      return t.number(row, t.column(column).value()).value();
    };
    const ImageFrame& frame = flight->frames[row];
    EXPECT_EQ("images/" + frame.name, t.cell(row, 0));
    EXPECT_EQ(frame.captured_at,
              parse_exif_time(t.cell(row, t.column("DateTimeOriginal").value())));
    const auto pose = flight->camera_pose(frame, Duration{0}).value();
    EXPECT_NEAR(pose.camera.latitude.degrees(), value("GPSLatitude"), 1e-11);
    EXPECT_NEAR(pose.camera.longitude.degrees(), value("GPSLongitude"), 1e-11);
    EXPECT_NEAR(-pose.sea_from_camera.origin().v.z(), value("RelativeAltitude"), 1e-6);
    // The image's top points where the gimbal's yaw says; its pitch is up to 0.1° off nadir.
    const Eigen::Vector3d top = (pose.sea_from_camera * Vector<Camera>{{0, -1, 0}}).v;
    EXPECT_NEAR(
        (Angle::radians(std::atan2(top.y(), top.x())) - Angle::degrees(value("GimbalYawDegree")))
            .wrapped()
            .degrees(),
        0, 0.01);
    const Eigen::Vector3d axis = (pose.sea_from_camera * Vector<Camera>{{0, 0, 1}}).v;
    EXPECT_NEAR(Angle::radians(std::acos(std::min(1.0, axis.z()))).degrees(),
                90 + value("GimbalPitchDegree"), 0.01);
    // The body's attitude, against the angles of the file.
    const YawPitchRoll body =
        yaw_pitch_roll(flight->datum.world_from_ned_rotation(pose.camera).conjugate() *
                       frame.own_pose->world_from_body.rotation());
    EXPECT_NEAR(body.roll.degrees(), value("FlightRollDegree"), 1e-9);
    EXPECT_NEAR(body.pitch.degrees(), value("FlightPitchDegree"), 1e-9);
    EXPECT_NEAR((body.yaw - Angle::degrees(value("FlightYawDegree"))).wrapped().degrees(), 0, 1e-9);
  }
}

}  // namespace
}  // namespace watersky
