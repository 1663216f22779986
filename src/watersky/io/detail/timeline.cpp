// SPDX-License-Identifier: MIT
#include "watersky/io/detail/timeline.hpp"

#include <algorithm>

#include "watersky/io/detail/ros_frames.hpp"
#include "watersky/io/detail/stored_image.hpp"
#include "watersky/io/files.hpp"

namespace watersky::detail {

Status for_timeline(const Flight& flight, const TimelineUse& use) {
  enum class Kind { Pose, Gimbal, Range, Frame };
  struct Event {
    Time time;
    Kind kind;
    std::size_t index;
  };
  std::vector<Event> events;
  const auto& poses = flight.trajectory.poses();
  for (std::size_t i = 0; i < poses.size(); ++i) events.push_back({poses[i].time, Kind::Pose, i});
  const auto& gimbal = flight.gimbal.rotations();
  for (std::size_t i = 0; i < gimbal.size(); ++i)
    events.push_back({gimbal[i].time, Kind::Gimbal, i});
  for (std::size_t i = 0; i < flight.ranges.size(); ++i)
    events.push_back({flight.ranges[i].time, Kind::Range, i});
  // Frames keep their order among each other, whatever their times say.
  Time latest = events.empty() ? Time{} : events.front().time;
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const ImageFrame& frame = flight.frames[i];
    const auto time = frame.captured_at ? frame.captured_at : frame.received_at;
    latest = time && (i == 0 || *time > latest) ? *time : latest;
    events.push_back({latest, Kind::Frame, i});
  }
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) {
    return std::pair(a.time, a.kind) < std::pair(b.time, b.kind);
  });
  for (const Event& e : events) switch (e.kind) {
      case Kind::Pose: WATERSKY_CHECK(use.pose(poses[e.index])); break;
      case Kind::Gimbal: WATERSKY_CHECK(use.gimbal(gimbal[e.index])); break;
      case Kind::Range: WATERSKY_CHECK(use.range(flight.ranges[e.index])); break;
      case Kind::Frame: WATERSKY_CHECK(use.frame(e.index, e.time)); break;
    }
  return {};
}

RigidMotion map_from_base(const Flight& flight, const Rigid3<World, Body>& pose) {
  // World may be turned against north.
  const Eigen::Quaterniond ned_from_world = heading(flight.datum.x_azimuth());
  const bool turned = flight.datum.x_azimuth().radians() != 0.0;
  const Eigen::Vector3d p = pose.origin().v;
  return {ned_from_enu_rotation() * ned_from_world * pose.rotation() * frd_from_flu_rotation(),
          enu_from_ned(turned ? Eigen::Vector3d(ned_from_world * p) : p)};
}

RigidMotion platform_from_camera(const Flight& flight) {
  return {frd_from_flu_rotation() * flight.mount.rotation, flu_from_frd(flight.mount.lever_arm_m)};
}

std::optional<RigidMotion> base_from_gimbal(const Flight& flight, const StampedRotation& gimbal,
                                            const std::optional<StampedPose>& own) {
  Eigen::Quaterniond body_from_gimbal = gimbal.rotation;
  if (flight.gimbal_reference == GimbalReference::NorthEastDown) {
    std::optional<StampedPose> pose = own;
    if (!pose) {
      const auto at = flight.trajectory.at(gimbal.time, std::chrono::seconds(2));
      if (!at) return std::nullopt;
      pose = *at;
    }
    const Rigid3<World, Body>& body = pose->world_from_body;
    body_from_gimbal = body.rotation().conjugate() *
                       flight.datum.world_from_ned_rotation(flight.datum.geodetic(body.origin())) *
                       gimbal.rotation;
  }
  return RigidMotion{frd_from_flu_rotation() * body_from_gimbal * frd_from_flu_rotation(),
                     Eigen::Vector3d::Zero()};
}

NamedDistortion distortion_of(const CameraModel& camera, const char* fisheye_name) {
  NamedDistortion out{"plumb_bob", camera.distortion()};
  if (camera.lens() == LensModel::Fisheye) {
    out.model = fisheye_name;
    out.d.resize(4, 0.0);
    return out;
  }
  out.d.resize(8, 0.0);
  if (std::any_of(out.d.begin() + 5, out.d.end(), [](double x) { return x != 0.0; }))
    out.model = "rational_polynomial";
  else
    out.d.resize(5);
  return out;
}

Result<EncodedImage> image_bytes(const ImageFrame& frame, const WriteRecordingOptions& options) {
  // Foxglove and ROS know JPEG and PNG.
  if (has_own_bytes(frame)) {
    WATERSKY_TRY(EncodedImage own, own_bytes(frame));
    const std::string extension = lower(own.extension);
    const bool jpeg = extension == ".jpg" || extension == ".jpeg";
    if (jpeg || extension == ".png") {
      own.extension = jpeg ? ".jpg" : ".png";
      // One that cannot be decoded is told now rather than by those who read the recording.
      if (!frame.load) return own;
      const auto readable = frame.load({.color = false, .reduction = 8});
      if (!readable) return readable.error();
      return own;
    }
  }
  if (!frame.load) return Error{ErrorCode::NotFound, "it has no image"};
  WATERSKY_TRY(const cv::Mat image, frame.load({}));
  return encode_image(image, options.jpeg && image.depth() == CV_8U, options.jpeg_quality,
                      frame.name);
}

}  // namespace watersky::detail
