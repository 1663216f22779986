// SPDX-License-Identifier: MIT
#include "watersky/io/message_flight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "support/random_flight.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/io/detail/ros_frames.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/inspect.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/io/recording_write.hpp"
#include "watersky/wire/mcap_writer.hpp"
#include "watersky/wire/ros.hpp"
#include "watersky/wire/rosbag.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;
using test::random_flight;
using test::TemporaryFolder;
using ::testing::Contains;
using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

bool same_pixels(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

void expect_same_pose(const StampedPose& a, const StampedPose& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.world_from_body.origin().v, b.world_from_body.origin().v);
  EXPECT_LT(angle_between(a.world_from_body.rotation(), b.world_from_body.rotation()).radians(),
            1e-7);
  ASSERT_EQ(a.sigma.has_value(), b.sigma.has_value());
  if (a.sigma) {
    EXPECT_EQ(a.sigma->position_north_east_down_m, b.sigma->position_north_east_down_m);
    EXPECT_EQ(a.sigma->roll_pitch_yaw_rad, b.sigma->roll_pitch_yaw_rad);
  }
}

TEST(McapFlight, WhatIsWrittenIsReadBack) {
  for (int seed = 1; seed <= 24; ++seed) {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "flight.mcap";
    Flight f = random_flight(seed);
    f.ranges = {{f.frames[0].captured_at.value(), 50.25, 0.125}};
    f.delay_s = seed % 2 ? std::optional(0.25) : std::nullopt;
    f.left_out = {{"lost.png", "it was lost"}};
    Anchor anchor;
    anchor.name = "cairn";
    anchor.place = AnchorPlace{Angle::degrees(78), Angle::degrees(12), 1.0, HeightAbove::Sea};
    anchor.sightings = {{f.frames[1].name, {3.5, 4.5}, 1.0}};
    f.anchors = {anchor};
    const auto left_out = write_mcap_flight(f, file);
    ASSERT_TRUE(left_out) << left_out.error().message;
    EXPECT_TRUE(left_out->empty());
    const auto back = read_flight(file);
    ASSERT_TRUE(back) << back.error().message;

    EXPECT_TRUE(back->notes.empty()) << back->notes.front();
    EXPECT_EQ(back->datum.origin().height_ellipsoid_m, f.datum.origin().height_ellipsoid_m);
    EXPECT_NEAR(back->datum.x_azimuth().radians(), f.datum.x_azimuth().radians(), 1e-12);
    EXPECT_EQ(back->camera.camera_matrix(), f.camera.camera_matrix());
    EXPECT_EQ(back->camera.distortion(), f.camera.distortion());
    EXPECT_EQ(back->calibration.description, f.calibration.description);
    EXPECT_LT(angle_between(back->mount.rotation, f.mount.rotation).radians(), 1e-7);
    EXPECT_EQ(back->mount.lever_arm_m, f.mount.lever_arm_m);
    EXPECT_EQ(back->readout_s, f.readout_s);
    EXPECT_EQ(back->delay_s, f.delay_s);
    EXPECT_EQ(back->gimbal_reference, f.gimbal_reference);
    ASSERT_TRUE(back->sea_level);
    EXPECT_NEAR(*back->sea_level->height_ellipsoid_m(f.datum.origin()),
                *f.sea_level->height_ellipsoid_m(f.datum.origin()), 1e-9);
    ASSERT_EQ(back->trajectory.poses().size(), f.trajectory.poses().size());
    for (std::size_t i = 0; i < f.trajectory.poses().size(); ++i)
      expect_same_pose(back->trajectory.poses()[i], f.trajectory.poses()[i]);
    ASSERT_EQ(back->gimbal.rotations().size(), f.gimbal.rotations().size());
    ASSERT_EQ(back->frames.size(), f.frames.size());
    for (std::size_t i = 0; i < f.frames.size(); ++i) {
      const ImageFrame &a = back->frames[i], &b = f.frames[i];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.captured_at, b.captured_at);
      EXPECT_EQ(a.received_at, b.received_at);
      EXPECT_EQ(a.counter, b.counter);
      ASSERT_EQ(a.own_pose.has_value(), b.own_pose.has_value());
      if (a.own_pose) expect_same_pose(*a.own_pose, *b.own_pose);
      ASSERT_EQ(a.own_gimbal.has_value(), b.own_gimbal.has_value());
      const auto image = a.load({});
      ASSERT_TRUE(image) << image.error().message;
      EXPECT_TRUE(same_pixels(*image, *b.load({}))) << seed;
      EXPECT_EQ(a.encoded()->extension, ".png");
    }
    ASSERT_EQ(back->ranges.size(), 1u);
    EXPECT_EQ(back->ranges[0].range_m, 50.25);
    EXPECT_EQ(back->ranges[0].sigma_m, 0.125);
    ASSERT_EQ(back->anchors.size(), 1u);
    EXPECT_EQ(back->anchors[0].sightings.at(0).frame, f.frames[1].name);
    ASSERT_EQ(back->left_out.size(), 1u);
    EXPECT_EQ(back->left_out[0].reason, "it was lost");
  }
}

TEST(McapFlight, CutAnywhereGivesTheFramesBeforeTheCut) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "flight.mcap";
  const Flight f = random_flight(4);
  WriteRecordingOptions options;
  options.chunk_bytes = 4096;
  ASSERT_TRUE(write_mcap_flight(f, file, options));
  const auto size = fs::file_size(file);
  std::size_t before = f.frames.size();
  for (const double share : {0.999, 0.8, 0.5, 0.3}) {
    fs::resize_file(file, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
    const auto back = read_flight(file);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_LE(back->frames.size(), before);
    before = back->frames.size();
    EXPECT_THAT(back->notes, Contains(HasSubstr("byte ")));
    for (const ImageFrame& frame : back->frames) EXPECT_TRUE(frame.load({}));
  }
  EXPECT_GT(before, 0u);
  EXPECT_LT(before, f.frames.size());
}

TEST(McapFlight, AppearsWholeOrNotAtAllAndNeverOver) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "flight.mcap";
  Flight f = random_flight(2);
  f.frames[1].load = [](const ImageRequest&) -> Result<cv::Mat> {
    return Error{ErrorCode::InvalidInput, "damaged"};
  };
  const auto left_out = write_mcap_flight(f, file);
  ASSERT_TRUE(left_out);
  ASSERT_EQ(left_out->size(), 1u);
  EXPECT_EQ(write_mcap_flight(f, file).error().code, ErrorCode::Exists);
  EXPECT_EQ(write_mcap_flight(f, folder.path() / "no" / "x.mcap").error().code, ErrorCode::Io);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
  const auto back = read_flight(file);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->frames.size(), f.frames.size() - 1);
  EXPECT_EQ(back->left_out.at(0).file, f.frames[1].name);
}

/// Where the camera is and looks, in the flight's own terms, at each frame.
void expect_same_views(const Flight& a, const Flight& b, double metres, double radians) {
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    const auto pa = a.camera_pose(a.frames[i], std::chrono::seconds(10)),
               pb = b.camera_pose(b.frames[i], std::chrono::seconds(10));
    ASSERT_EQ(pa.ok(), pb.ok()) << (pa ? pb.error().message : pa.error().message);
    if (!pa) continue;
    EXPECT_LT((ecef_from(pa->camera).v - ecef_from(pb->camera).v).norm(), metres) << i;
    EXPECT_LT(
        angle_between(pa->sea_from_camera.rotation(), pb->sea_from_camera.rotation()).radians(),
        radians)
        << i;
  }
}

TEST(BagFlight, SeesTheSameFromTheSamePlaces) {
  for (int seed = 1; seed <= 24; ++seed) {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "flight.bag";
    const Flight f = random_flight(seed);
    const auto left_out = write_bag_flight(f, file);
    ASSERT_TRUE(left_out) << left_out.error().message;
    auto back = read_flight(file);
    ASSERT_TRUE(back) << seed << ": " << back.error().message;
    back->sea_level = f.sea_level;
    EXPECT_EQ(back->camera.camera_matrix(), f.camera.camera_matrix());
    EXPECT_EQ(back->camera.distortion(), f.camera.distortion());
    // A gimbal's attitude and the body's are interpolated one after the other here, in one there.
    if (f.gimbal_reference && f.trajectory.poses().size() > 0) continue;
    expect_same_views(*back, f, 1e-5, 1e-7);
    for (std::size_t i = 0; i < f.frames.size(); ++i)
      EXPECT_TRUE(same_pixels(*back->frames[i].load({}), *f.frames[i].load({})));
  }
}

// --- Recordings of others --------------------------------------------------------------------

/// A recording with messages of ROS, as a bag or as an MCAP file of ROS 2.
class RosRecording {
 public:
  explicit RosRecording(bool mcap) {
    const auto sink = [this](std::span<const std::uint8_t> b) {
      file_.insert(file_.end(), b.begin(), b.end());
      return Status();
    };
    if (mcap)
      mcap_ = std::make_unique<mcap::Writer>(
          *mcap::Writer::open(sink, {.profile = "ros2",
                                     .library = "",
                                     .compression = Compression::Zstd,
                                     .chunk_bytes = 4096}));
    else
      bag_ = std::make_unique<rosbag::Writer>(
          *rosbag::Writer::open(sink, {.compression = Compression::Bz2, .chunk_bytes = 4096}));
  }

  template <class M>
  void put(const std::string& topic, Time time, const M& message) {
    if (mcap_) {
      if (!channels_.contains(topic)) {
        const auto d = ros::definition<M>(ros::Encoding::Cdr);
        const auto schema =
            *mcap_->add_schema({0, d.type, "ros2msg", Bytes(d.text.begin(), d.text.end())});
        channels_[topic] = *mcap_->add_channel({0, schema, topic, "cdr", {}});
      }
      const auto bytes = ros::encode(ros::Encoding::Cdr, message);
      ASSERT_TRUE(
          mcap_->write({static_cast<std::uint16_t>(channels_[topic]), 0, time, time, bytes}));
    } else {
      if (!channels_.contains(topic)) {
        const auto d = ros::definition<M>(ros::Encoding::Ros1);
        channels_[topic] = *bag_->add_connection({0, topic, d.type, d.md5sum, d.text, "", false});
      }
      const auto bytes = ros::encode(ros::Encoding::Ros1, message);
      ASSERT_TRUE(bag_->write({channels_[topic], time, bytes}));
    }
  }

  fs::path write(const fs::path& folder) {
    if (mcap_) {
      EXPECT_TRUE(mcap_->close());
    } else {
      const auto beginning = bag_->close();
      std::copy(beginning->begin(), beginning->end(), file_.begin());
    }
    const fs::path path = folder / (mcap_ ? "r.mcap" : "r.bag");
    EXPECT_TRUE(write_file(path, {reinterpret_cast<const char*>(file_.data()), file_.size()}));
    return path;
  }

 private:
  Bytes file_;
  std::unique_ptr<mcap::Writer> mcap_;
  std::unique_ptr<rosbag::Writer> bag_;
  std::map<std::string, std::uint32_t> channels_;
};

Time at(double s) { return Time(std::chrono::seconds(1'700'000'000)) + seconds(s); }

/// In map, east, north, up: 100 m up, flying east at 10 m/s, the nose east. The identity of
/// forward, left, up against east, north, up is just that.
struct Story {
  const Datum datum{Geodetic{Angle::degrees(78.9), Angle::degrees(11.9), 30.0}};
  Bytes pixels = Bytes(8 * 6, 100);

  static ros::TFMessage tf(double s, const char* parent, const char* child, ros::Vector3 p,
                           ros::Quaternion q = {}) {
    return {{{{0, at(s), parent}, child, {p, q}}}};
  }
  /// Looks down, image top forward: x right (−y of the body), y backward, z down.
  static constexpr ros::Quaternion kLooksDown{0.70710678118654752, -0.70710678118654752, 0, 0};

  void images(RosRecording& r, bool raw = true) const {
    for (int i = 0; i < 8; ++i) {
      const ros::Header header{static_cast<std::uint32_t>(i), at(0.5 + i), "camera_optical"};
      ros::CameraInfo info{};
      info.header = header;
      info.width = 8;
      info.height = 6;
      info.distortion_model = "plumb_bob";
      info.d = {0.1, 0, 0, 0, 0};
      info.k = {10, 0, 3.5, 0, 10, 2.5, 0, 0, 1};
      r.put("/camera/camera_info", at(0.5 + i), info);
      if (raw)
        r.put("/camera/image_raw", at(0.5 + i), ros::Image{header, 6, 8, "mono8", 0, 8, pixels});
    }
  }
  [[nodiscard]] Geodetic place(double s) const {
    return datum.geodetic(Point<World>{{0.0, 10.0 * s, -100.0}});
  }
  void fixes(RosRecording& r) const {
    for (int i = 0; i < 10; ++i) {
      const Geodetic g = place(i);
      ros::NavSatFix fix{};
      fix.header = {0, at(i), "gps"};
      fix.latitude = g.latitude.degrees();
      fix.longitude = g.longitude.degrees();
      fix.altitude = g.height_ellipsoid_m;
      r.put("/fix", at(i), fix);
    }
  }
  void expect_views(const Result<Flight>& flight) const {
    ASSERT_TRUE(flight) << flight.error().message;
    Flight f = *flight;
    f.sea_level = SeaLevel{[](const Geodetic&) -> Result<double> { return 30.0; }, "", 0.0};
    ASSERT_EQ(f.frames.size(), 8u);
    for (int i = 0; i < 8; ++i) {
      const auto pose =
          f.camera_pose(f.frames[static_cast<std::size_t>(i)], std::chrono::seconds(2));
      ASSERT_TRUE(pose) << pose.error().message;
      EXPECT_LT((ecef_from(pose->camera).v - ecef_from(place(0.5 + i)).v).norm(), 1e-3);
      // The image's top is east.
      const Eigen::Vector3d up = pose->sea_from_camera.rotation() * Eigen::Vector3d(0, -1, 0);
      EXPECT_NEAR(up.y(), 1.0, 1e-6);
      const Eigen::Vector3d axis = pose->sea_from_camera.rotation() * Eigen::Vector3d(0, 0, 1);
      EXPECT_NEAR(axis.z(), 1.0, 1e-6);
    }
  }
};

TEST(MessageFlight, TheChainOfTransformsPlacesTheCamera) {
  for (const bool mcap : {false, true}) {
    const TemporaryFolder folder;
    const Story story;
    RosRecording r(mcap);
    r.put("/tf_static", at(0), Story::tf(0, "base_link", "mast", {0, 0, 1}));
    r.put("/tf_static", at(0),
          Story::tf(0, "mast", "camera_optical", {0, 0, -1}, Story::kLooksDown));
    for (int i = 0; i < 100; ++i) {
      // The map's correction comes seldom, the odometry often; together they are the story.
      if (i % 10 == 0)
        r.put("/tf", at(0.1 * i), Story::tf(0.1 * i, "/map", "/odom", {0.5 * i, 0, 0}));
      r.put("/tf", at(0.1 * i), Story::tf(0.1 * i, "odom", "base_link", {0.5 * i, 0, 100}));
    }
    story.images(r);
    story.fixes(r);
    const fs::path file = r.write(folder.path());
    const auto flight = read_flight(file);
    story.expect_views(flight);
    EXPECT_EQ(flight->frames[0].name, std::string(mcap ? "r.mcap" : "r.bag") + "#0");
    EXPECT_EQ(flight->camera.distortion().at(0), 0.1);
    EXPECT_EQ(flight->calibration.description, "/camera/camera_info");
    EXPECT_FALSE(flight->mount.assumed);
    const auto image = flight->frames[0].load({});
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->at<std::uint8_t>(2, 3), 100);
    EXPECT_EQ(recording_kind(file).value(), RecordingKind::Messages);
    const auto found = inspect(file);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->kind, mcap ? "mcap" : "rosbag");
    EXPECT_EQ(found->counts.at("/tf"), 110u);
    EXPECT_NEAR(found->rates_hz.at("/fix"), 1.0, 1e-9);
    EXPECT_NEAR(found->extent->south_deg, 78.9, 0.01);

    ReadOptions odom;
    odom.map_frame = "nowhere";
    EXPECT_THAT(read_flight(file, odom).error().message, HasSubstr("base_link"));
    odom.map_frame.reset();
    odom.camera_frame = "no_such";
    EXPECT_THAT(read_flight(file, odom).error().message, HasSubstr("camera_optical"));
  }
}

TEST(MessageFlight, OdometryStandsInForTransformsAndTheMountIsThenGiven) {
  for (const bool mcap : {false, true}) {
    const TemporaryFolder folder;
    const Story story;
    RosRecording r(mcap);
    for (int i = 0; i < 10; ++i)
      r.put("/odom", at(i),
            ros::Odometry{{0, at(i), "odom"}, "base_link", {{{{10.0 * i, 0, 100}}, {}}, {}}, {}});
    story.images(r);
    const fs::path file = r.write(folder.path());
    EXPECT_THAT(read_flight(file).error().message, HasSubstr("--datum"));
    ReadOptions options;
    options.datum = story.datum.origin();
    const auto assumed = read_flight(file, options);
    ASSERT_TRUE(assumed) << assumed.error().message;
    EXPECT_TRUE(assumed->mount.assumed);
    options.mount = YawPitchRoll{{}, Angle::degrees(-90), {}};
    const auto flight = read_flight(file, options);
    story.expect_views(flight);
    EXPECT_FALSE(flight->mount.assumed);
  }
}

TEST(MessageFlight, FixesAndAnInertialUnitAreEnough) {
  const TemporaryFolder folder;
  const Story story;
  RosRecording r(false);
  for (int i = 0; i < 90; ++i) {
    ros::Imu imu{};
    imu.header = {0, at(0.1 * i), "imu"};
    r.put("/imu", at(0.1 * i), imu);
  }
  story.images(r);
  story.fixes(r);
  ros::Range range{};
  range.header = {0, at(1), "base_link"};
  range.max_range = 200;
  range.range = 100;
  r.put("/range", at(1), range);
  const auto flight = read_flight(r.write(folder.path()));
  ASSERT_TRUE(flight) << flight.error().message;
  EXPECT_THAT(flight->notes, Contains(HasSubstr("Imu")));
  // Against north where it is; over these 90 m the meridians turn by 0.005°.
  const auto pose = flight->trajectory.at(at(4.5), std::chrono::seconds(1));
  ASSERT_TRUE(pose);
  const Geodetic g = flight->datum.geodetic(pose->world_from_body.origin());
  EXPECT_LT((ecef_from(g).v - ecef_from(story.place(4.5)).v).norm(), 1e-2);
  const YawPitchRoll a = yaw_pitch_roll(pose->world_from_body.rotation());
  EXPECT_NEAR(a.yaw.degrees(), 90.0, 0.01);
  EXPECT_NEAR(a.roll.degrees(), 0.0, 0.01);
  ASSERT_EQ(flight->ranges.size(), 1u);
  EXPECT_EQ(flight->ranges[0].range_m, 100.0);
}

TEST(MessageFlight, SaysWhatIsMissingAndWhatThereIs) {
  const TemporaryFolder folder;
  const Story story;
  {
    RosRecording r(false);
    story.images(r);
    EXPECT_THAT(read_flight(r.write(folder.path())).error().message, HasSubstr("/tf"));
  }
  {
    RosRecording r(false);
    story.fixes(r);
    EXPECT_THAT(read_flight(r.write(folder.path())).error().message, HasSubstr("no images"));
  }
  RosRecording r(false);
  story.images(r);
  const ros::Header header{0, at(0.5), "other"};
  r.put("/other/image_raw", at(0.5), ros::Image{header, 6, 8, "mono8", 0, 8, story.pixels});
  const fs::path file = r.write(folder.path());
  const auto several = read_flight(file);
  EXPECT_THAT(several.error().message, HasSubstr("/other/image_raw"));
  EXPECT_THAT(several.error().message, HasSubstr("--image-topic"));
  ReadOptions options;
  options.image_topic = "/none";
  EXPECT_THAT(read_flight(file, options).error().message, HasSubstr("/camera/image_raw"));
  ASSERT_TRUE(write_file(folder.path() / "no.mcap", "not at all"));
  EXPECT_THAT(read_flight(folder.path() / "no.mcap").error().message, HasSubstr("byte 0"));
}

TEST(MessageFlight, RawPixelsOfEveryEncodingBecomeGrayOrBgr) {
  const Bytes rgb = {255, 0, 0, 0, 255, 0};  // red, green
  struct Case {
    const char* encoding;
    Bytes data;
    std::uint32_t step;
    cv::Mat expected;
  };
  const cv::Mat red_green =
      (cv::Mat_<cv::Vec3b>(1, 2) << cv::Vec3b(0, 0, 255), cv::Vec3b(0, 255, 0));
  const Case cases[] = {
      {"rgb8", rgb, 6, red_green},
      {"bgr8", {0, 0, 255, 0, 255, 0}, 6, red_green},
      {"rgba8", {255, 0, 0, 9, 0, 255, 0, 9}, 8, red_green},
      {"mono8", {7, 9, 0}, 3, (cv::Mat_<std::uint8_t>(1, 2) << 7, 9)},
      {"mono16", {1, 2, 3, 4}, 4, (cv::Mat_<std::uint16_t>(1, 2) << 513, 1027)},
  };
  for (const Case& c : cases) {
    const TemporaryFolder folder;
    RosRecording r(true);
    for (int i = 0; i < 3; ++i) {
      const ros::Header header{0, at(i), ""};
      r.put("/odom", at(i),
            ros::Odometry{{0, at(i), "odom"}, "b", {{{{1.0 * i, 0, 9}}, {}}, {}}, {}});
      r.put("/image", at(i), ros::Image{header, 1, 2, c.encoding, 0, c.step, c.data});
    }
    ReadOptions options;
    options.datum = Geodetic{};
    options.focal_px = 10;
    const auto flight = read_flight(r.write(folder.path()), options);
    ASSERT_TRUE(flight) << flight.error().message;
    const auto image = flight->frames.at(0).load({});
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_TRUE(same_pixels(*image, c.expected)) << c.encoding;
  }
}

}  // namespace
}  // namespace watersky
