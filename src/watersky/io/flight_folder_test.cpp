// SPDX-License-Identifier: MIT
#include "watersky/io/flight_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "support/make_photo.hpp"
#include "support/random_flight.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/read_flight.hpp"

namespace watersky {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using watersky::test::Dice;
using watersky::test::random_camera;
using watersky::test::random_flight;
using watersky::test::TemporaryFolder;
using watersky::test::write;

TEST(FlightFolder, WhatIsWrittenIsReadBack) {
  const TemporaryFolder folder;
  for (int seed = 0; seed < 24; ++seed) {
    const Flight before = random_flight(seed);
    const auto path = folder.path() / std::to_string(seed);
    const auto left_out = write_flight_folder(before, path);
    ASSERT_TRUE(left_out) << left_out.error().message;
    EXPECT_THAT(*left_out, SizeIs(0));
    const auto after = read_flight(path);
    ASSERT_TRUE(after) << after.error().message;
    EXPECT_THAT(after->notes, SizeIs(0));
    ASSERT_EQ(after->frames.size(), before.frames.size());
    EXPECT_EQ(after->calibration.description, before.calibration.description);
    EXPECT_EQ(after->calibration.focal_sigma_px, before.calibration.focal_sigma_px);
    EXPECT_LT((after->camera.camera_matrix() - before.camera.camera_matrix()).norm(), 1e-9);
    EXPECT_EQ(after->camera.distortion(), before.camera.distortion());
    EXPECT_EQ(after->mount.lever_arm_m, before.mount.lever_arm_m);
    EXPECT_NEAR(after->mount.sigma_rad, before.mount.sigma_rad, 1e-15);
    EXPECT_EQ(after->readout_s, before.readout_s);
    EXPECT_EQ(after->sea_level->sigma_m, before.sea_level->sigma_m);
    for (std::size_t i = 0; i < before.frames.size(); ++i) {
      const ImageFrame& a = before.frames[i];
      const ImageFrame& b = after->frames[i];
      EXPECT_EQ(b.name, a.name);
      EXPECT_EQ(b.captured_at, a.captured_at);
      EXPECT_EQ(b.received_at, a.received_at);
      EXPECT_EQ(b.counter, a.counter);
      EXPECT_EQ(cv::norm(a.load({}).value(), b.load({}).value(), cv::NORM_INF), 0)
          << "pixels changed";
      const auto pa = before.camera_pose(a, std::chrono::seconds(2)).value();
      const auto pb = after->camera_pose(b, std::chrono::seconds(2)).value();
      EXPECT_EQ(pb.time, pa.time);
      EXPECT_LT((pb.world_from_camera.origin().v - pa.world_from_camera.origin().v).norm(), 1e-6)
          << seed;
      EXPECT_LT((pb.sea_from_camera.origin().v - pa.sea_from_camera.origin().v).norm(), 1e-6)
          << seed;
      EXPECT_LT(
          angle_between(pb.world_from_camera.rotation(), pa.world_from_camera.rotation()).radians(),
          1e-7);
      EXPECT_EQ(pb.sigma.has_value(), pa.sigma.has_value());
      if (pa.sigma) {
        EXPECT_LT(
            (pb.sigma->position_north_east_down_m - pa.sigma->position_north_east_down_m).norm(),
            1e-12);
        EXPECT_LT((pb.sigma->roll_pitch_yaw_rad - pa.sigma->roll_pitch_yaw_rad).norm(), 1e-12);
      }
    }
  }
}

// Frames get other names when they are written; an anchor's sightings go with them.
TEST(FlightFolder, KeepsKnownPointsAndRanges) {
  const TemporaryFolder folder;
  Flight before = random_flight(1);
  before.frames[1].name = "film.mp4#120";
  Anchor cairn;
  cairn.name = "cairn";
  cairn.place =
      AnchorPlace{Angle::degrees(78.9), Angle::degrees(11.9), 41.5, HeightAbove::Ellipsoid};
  cairn.sigma_m = 0.05;
  cairn.sightings = {{"film.mp4#120", {10.5, 20.25}, 0.5}, {"elsewhere", {1, 1}, 1}};
  Anchor buoy;
  buoy.name = "buoy";
  buoy.track = {{Time(seconds(1)), {Angle::degrees(79), Angle::degrees(12)}},
                {Time(seconds(61)), {Angle::degrees(79.001), Angle::degrees(12)}}};
  before.anchors = {cairn, buoy};
  before.ranges = {{Time(seconds(1)), 100.25, 0.05}, {Time(seconds(1.1)), 100.5, 0.0}};
  ASSERT_TRUE(write_flight_folder(before, folder.path() / "f"));
  const auto after = read_flight(folder.path() / "f");
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_THAT(after->notes, SizeIs(0));
  ASSERT_THAT(after->anchors, SizeIs(2));
  ASSERT_THAT(after->anchors[0].sightings, SizeIs(1));
  EXPECT_EQ(after->anchors[0].sightings[0].frame, after->frames[1].name);
  EXPECT_EQ(after->anchors[0].sightings[0].px.v, 20.25);
  EXPECT_EQ(after->anchors[0].place->height_m, 41.5);
  EXPECT_THAT(after->anchors[1].track, SizeIs(2));
  ASSERT_THAT(after->ranges, SizeIs(2));
  EXPECT_EQ(after->ranges[0].range_m, 100.25);
  EXPECT_EQ(after->ranges[1].sigma_m, 0.0);
  // Errors name folder, file and line.
  write(folder.path() / "f" / "anchors.csv", std::string("anchor,frame,u_px,v_px\nlost,a,1,2\n"));
  EXPECT_THAT(read_flight(folder.path() / "f").error().message,
              AllOf(HasSubstr("anchors.csv: lost has no place"), HasSubstr("anchor_tracks.csv")));
}

TEST(FlightFolder, FramesTakenInTheSameSecondKeepTheirOwnPoses) {
  Flight f = random_flight(0);
  for (ImageFrame& frame : f.frames) frame.captured_at = f.frames[0].captured_at;
  const TemporaryFolder folder;
  ASSERT_TRUE(write_flight_folder(f, folder.path() / "x"));
  const Flight after = read_flight(folder.path() / "x").value();
  for (std::size_t i = 0; i < f.frames.size(); ++i) {
    const auto pose = after.trajectory.at(*after.frames[i].captured_at, Duration{0}).value();
    EXPECT_LT(
        (pose.world_from_body.origin().v - f.frames[i].own_pose->world_from_body.origin().v).norm(),
        1e-9);
  }
}

TEST(FlightFolder, IsWrittenWholeOrNotAtAllAndNeverOver) {
  const TemporaryFolder folder;
  Flight f = random_flight(1);
  ASSERT_TRUE(write_flight_folder(f, folder.path() / "x"));
  EXPECT_EQ(write_flight_folder(f, folder.path() / "x").error().code, ErrorCode::Exists);
  // A sea that is neither of the kinds a file can hold.
  f.sea_level->height_ellipsoid_m = [](const Geodetic& p) -> Result<double> {
    return 100 * std::sin(50 * p.latitude.radians());
  };
  EXPECT_EQ(write_flight_folder(f, folder.path() / "y").error().code, ErrorCode::Unsupported);
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& e : std::filesystem::directory_iterator(folder.path()))
    ++entries;
  EXPECT_EQ(entries, 1u);
}

TEST(FlightFolder, AFrameWhoseImageCannotBeReadIsLeftOutWithTheReason) {
  Flight f = random_flight(1);
  f.frames[2].load = [](const ImageRequest&) -> Result<cv::Mat> {
    return Error{ErrorCode::InvalidInput, "cut short"};
  };
  const TemporaryFolder folder;
  const auto left_out =
      write_flight_folder(f, folder.path() / "x", {.images = StoredImages::Jpeg}).value();
  ASSERT_THAT(left_out, SizeIs(1));
  EXPECT_EQ(left_out[0].reason, "cut short");
  EXPECT_EQ(read_flight(folder.path() / "x")->frames.size(), 4u);
}

TEST(FlightFolder, KeptImagesAreTheSameBytes) {
  const TemporaryFolder folder;
  const Flight f = random_flight(4);
  ASSERT_TRUE(write_flight_folder(f, folder.path() / "jpeg", {.images = StoredImages::Jpeg}));
  const auto first = read_flight(folder.path() / "jpeg").value();
  ASSERT_TRUE(write_flight_folder(first, folder.path() / "kept", {.images = StoredImages::Keep}));
  const auto kept = read_flight(folder.path() / "kept").value();
  ASSERT_EQ(kept.frames.size(), first.frames.size());
  for (std::size_t i = 0; i < kept.frames.size(); ++i) {
    EXPECT_EQ(kept.frames[i].name, first.frames[i].name);
    EXPECT_EQ(read_bytes(kept.frames[i].file).value(), read_bytes(first.frames[i].file).value());
  }
}

TEST(FlightFolder, AKeptImageThatIsCutShortIsLeftOut) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_flight_folder(random_flight(4), folder.path() / "jpeg",
                                  {.images = StoredImages::Jpeg}));
  const auto flight = read_flight(folder.path() / "jpeg").value();
  std::filesystem::resize_file(flight.frames[1].file,
                               std::filesystem::file_size(flight.frames[1].file) / 2);
  const auto left_out =
      write_flight_folder(flight, folder.path() / "kept", {.images = StoredImages::Keep}).value();
  ASSERT_THAT(left_out, SizeIs(1));
  EXPECT_EQ(left_out[0].file, flight.frames[1].name);
}

TEST(FlightFolder, CompanionsAppearWithItAndKnowWhatIsMissing) {
  Flight f = random_flight(1);
  f.frames[2].load = {};
  const TemporaryFolder folder;
  WriteFlightOptions options;
  options.companions = {{"account.txt", [](const std::vector<LeftOut>& not_written) {
                           return Result<std::string>(not_written.at(0).file);
                         }}};
  ASSERT_TRUE(write_flight_folder(f, folder.path() / "x", options));
  EXPECT_EQ(read_text(folder.path() / "x" / "account.txt").value(), f.frames[2].name);

  EXPECT_EQ(write_flight_folder(f, folder.path() / "x", options).error().code, ErrorCode::Exists);
  options.replace = true;
  options.companions = {{"account.txt", [](const std::vector<LeftOut>&) -> Result<std::string> {
                           return Error{ErrorCode::Io, "no ink"};
                         }}};
  EXPECT_EQ(write_flight_folder(f, folder.path() / "x", options).error().message, "no ink");
  EXPECT_EQ(read_text(folder.path() / "x" / "account.txt").value(), f.frames[2].name)
      << "a failure leaves what was there";
  options.companions.clear();
  ASSERT_TRUE(write_flight_folder(f, folder.path() / "x", options));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "x" / "account.txt"));
}

/// A folder of text files and one image, as a person would make it.
struct HandMade {
  TemporaryFolder folder;
  const std::string yaml =
      "camera: camera.yaml\n"
      "mount: {roll_deg: 0, pitch_deg: -90, yaw_deg: 0, x_m: 0, y_m: 0, z_m: 0}   # camera in "
      "body\n"
      "datum: {lat_deg: 78.9, lon_deg: 11.9, height_ellipsoid_m: 30.0, x_azimuth_deg: 0}\n"
      "sea_above_datum_m: -30.0\nreadout_s: 0.0\ndelay_s: 0.25\n";
  HandMade() {
    write(folder.path() / "camera.yaml",
          std::string("image_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, data: "
                      "[60., 0., 31.5, 0., 60., 23.5, 0., 0., 1.]}\n"));
    poses(
        "time_s,lat_deg,lon_deg,height_ellipsoid_m,roll_deg,pitch_deg,yaw_deg\n10,78.9,11.9,130,0,"
        "0,90\n11,78.9,11.9,130,0,0,90\n");
    frames("file,captured_s,received_s\na.jpg,,10.75\n");
    write(folder.path() / "images/a.jpg", watersky::test::make_photo({}));
    write(folder.path() / "flight.yaml", yaml);
  }
  void poses(const std::string& text) const { write(folder.path() / "poses.csv", text); }
  void frames(const std::string& text) const { write(folder.path() / "frames.csv", text); }
  [[nodiscard]] Result<Flight> read(const ReadOptions& options = {}) const {
    return read_flight(folder.path(), options);
  }
  [[nodiscard]] std::string error() const {
    const auto flight = read();
    return flight ? "no error" : flight.error().message;
  }
};

TEST(FlightFolder, ReadsWhatTheDesignShows) {
  const HandMade made;
  const auto flight = made.read();
  ASSERT_TRUE(flight) << flight.error().message;
  const auto pose = flight->camera_pose(flight->frames[0], std::chrono::seconds(2)).value();
  EXPECT_EQ(pose.time, Time(std::chrono::milliseconds(10500)));  // arrived 0.25 s late
  EXPECT_NEAR(-pose.sea_from_camera.origin().v.z(), 130,
              1e-9);  // the sea is 0 m above the ellipsoid
  const Eigen::Vector3d top = (pose.sea_from_camera * Vector<Camera>{{0, -1, 0}}).v;
  EXPECT_NEAR(top.y(), 1, 1e-9);  // yaw 90: image top east
  EXPECT_FALSE(flight->mount.assumed);
}

TEST(FlightFolder, ATideRaisesTheSea) {
  const HandMade made;
  write(made.folder.path() / "flight.yaml", made.yaml + "tide_m: 1.25\n");
  const auto flight = made.read();
  ASSERT_TRUE(flight) << flight.error().message;
  EXPECT_NEAR(flight->sea_level->height_ellipsoid_m(flight->datum.origin()).value(), 1.25, 1e-9);
  EXPECT_THAT(flight->sea_level->description, HasSubstr("a tide of 1.25 m"));
  write(made.folder.path() / "flight.yaml", made.yaml + "tide_m: high\n");
  EXPECT_THAT(made.error(), HasSubstr("tide_m must be a number"));
}

TEST(FlightFolder, BadPosesNameTheirLineAndTheRemedy) {
  const HandMade made;
  const std::string head = "time_s,north_m,east_m,down_m,qw,qx,qy,qz\n";
  made.poses(head + "1,0,0,-9,1,0,0,0\n2,0,0,-9,1,0,0,0\n2,0,0,-9,1,0,0,0\n");
  EXPECT_THAT(made.error(), AllOf(HasSubstr("poses.csv:4: has the same time as poses.csv:3"),
                                  HasSubstr("remove")));
  made.poses(head + "1,0,0,-9,1,0,0,0\n0.5,0,0,-9,1,0,0,0\n");
  EXPECT_THAT(made.error(), AllOf(HasSubstr("poses.csv:3: is earlier"), HasSubstr("sort")));
  made.poses(head + "nan,0,0,-9,1,0,0,0\n");
  EXPECT_THAT(made.error(), HasSubstr("poses.csv:2: time_s is \"nan\""));
  made.poses(head + "1,0,nan,-9,1,0,0,0\n");
  EXPECT_THAT(made.error(), HasSubstr("poses.csv:2: east_m is \"nan\""));
  made.poses(head + "1,0,0,-9,2,0,0,0\n");
  EXPECT_THAT(made.error(), HasSubstr("no rotation"));
  made.poses("time_s,north_m\n1,2\n");
  EXPECT_THAT(made.error(), HasSubstr("no column east_m"));
  made.poses(
      "time_s,lat_deg,lon_deg,height_ellipsoid_m,roll_deg,pitch_deg,yaw_deg\n1,91,0,0,0,0,0\n");
  EXPECT_THAT(made.error(), HasSubstr("poses.csv:2: is no place"));
  made.poses(head.substr(0, head.size() - 1) + ",sigma_north_m\n1,0,0,-9,1,0,0,0,1\n");
  EXPECT_THAT(made.error(), HasSubstr("not all six"));
}

TEST(FlightFolder, BadFramesNameTheirLineAndTheRemedy) {
  const HandMade made;
  made.frames("file,captured_s\na.jpg,10.5\na.jpg,10.6\n");
  EXPECT_THAT(made.error(), HasSubstr("frames.csv:3: a.jpg is listed twice"));
  made.frames("file,captured_s\na.jpg,soon\n");
  EXPECT_THAT(made.error(), HasSubstr("frames.csv:2: captured_s is \"soon\""));
  made.frames("file\na.jpg\n");
  EXPECT_THAT(made.error(), HasSubstr("neither captured_s nor received_s"));
  made.frames("file,captured_s\n");
  EXPECT_THAT(made.error(), HasSubstr("lists no frame"));
  made.frames("file,captured_s\nabsent.jpg,10.5\na.jpg,10.5\n");
  const Flight flight = made.read().value();
  EXPECT_EQ(flight.frames.size(), 1u);
  ASSERT_THAT(flight.left_out, SizeIs(1));
  EXPECT_EQ(flight.left_out[0].file, "absent.jpg");
}

TEST(FlightFolder, ImagesThatContradictTheCalibrationOrEachOtherAreRefused) {
  const HandMade made;
  watersky::test::Photo other;
  other.width_px = 50;
  write(made.folder.path() / "images/b.jpg", watersky::test::make_photo(other));
  made.frames("file,captured_s\na.jpg,10.5\nb.jpg,10.6\n");
  EXPECT_THAT(made.error(),
              AllOf(HasSubstr("two cameras are mixed"), HasSubstr("a.jpg"), HasSubstr("b.jpg")));
  made.frames("file,captured_s\nb.jpg,10.6\n");
  EXPECT_THAT(made.error(), AllOf(HasSubstr("64x48"), HasSubstr("50x48")));
}

TEST(FlightFolder, BadYamlNamesItsKey) {
  const HandMade made;
  const auto with = [&](const std::string& text) {
    write(made.folder.path() / "flight.yaml", text);
    return made.error();
  };
  EXPECT_THAT(with("datum: {lat_deg: x, lon_deg: 0, height_ellipsoid_m: 0}\n"),
              HasSubstr("lat_deg must be a number"));
  EXPECT_THAT(with("datum: {lat_deg: 1, lon_deg: 0}\n"), HasSubstr("lacks height_ellipsoid_m"));
  EXPECT_THAT(with("mount: 3\n"), HasSubstr("mount must hold"));
  EXPECT_THAT(with("a: [1\n"), HasSubstr("no valid YAML"));
  EXPECT_THAT(with("gimbal_frame: up\n"), HasSubstr("body or north"));
  EXPECT_THAT(with("gimbal_frame: body\n"), HasSubstr("no gimbal.csv"));
  EXPECT_THAT(with("delay_s: .nan\n"), HasSubstr("delay_s"));
  EXPECT_THAT(with(""), HasSubstr("flight.yaml"));
  write(made.folder.path() / "flight.yaml", made.yaml + "speling: 1\n");
  EXPECT_THAT(made.read()->notes, Contains(HasSubstr("speling")));
}

TEST(FlightFolder, WhatIsMissingIsNotGuessed) {
  const HandMade made;
  write(made.folder.path() / "flight.yaml", std::string("camera: camera.yaml\n"));
  Flight flight = made.read().value();
  EXPECT_FALSE(flight.sea_level);
  EXPECT_TRUE(flight.mount.assumed);
  EXPECT_THAT(flight.notes, Contains(HasSubstr("no datum")));
  made.poses("time_s,north_m,east_m,down_m,qw,qx,qy,qz\n1,0,0,-9,1,0,0,0\n");
  EXPECT_THAT(made.error(), HasSubstr("names no datum"));
  write(made.folder.path() / "flight.yaml", made.yaml);
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, 0};
  EXPECT_THAT(made.read(options).error().message, HasSubstr("take-off"));
  write(made.folder.path() / "gimbal.csv",
        std::string("time_s,roll_deg,pitch_deg,yaw_deg\n1,0,0,0\n"));
  EXPECT_THAT(made.error(), HasSubstr("gimbal_frame"));
}

TEST(FlightFolder, BrightonBeachSurvivesBecomingOne) {
  const auto data = watersky::test::real_data("brighton_beach");
  if (!data) GTEST_SKIP() << "the real data is not here";
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, -5};
  Flight before = read_flight(*data, options).value();
  before.frames.resize(2);
  const TemporaryFolder folder;
  ASSERT_TRUE(write_flight_folder(before, folder.path() / "x", {.images = StoredImages::Jpeg}));
  const Flight after = read_flight(folder.path() / "x").value();
  for (std::size_t i = 0; i < 2; ++i) {
    const auto a = before.camera_pose(before.frames[i], Duration{0}).value();
    const auto b = after.camera_pose(after.frames[i], Duration{0}).value();
    EXPECT_LT((a.sea_from_camera.origin().v - b.sea_from_camera.origin().v).norm(), 1e-6);
    EXPECT_LT(angle_between(a.sea_from_camera.rotation(), b.sea_from_camera.rotation()).radians(),
              1e-7);
  }
}

}  // namespace
}  // namespace watersky
