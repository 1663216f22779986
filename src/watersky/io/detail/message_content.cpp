// SPDX-License-Identifier: MIT
#include "watersky/io/detail/message_content.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/io/files.hpp"
#include "watersky/wire/protobuf.hpp"
#include "watersky/wire/ros.hpp"

namespace watersky::detail {

namespace {

template <class M>
Result<M> decoded(const RecordedMessage& m) {
  return ros::decode<M>(
      m.channel.encoding == MessageEncoding::Ros1 ? ros::Encoding::Ros1 : ros::Encoding::Cdr,
      m.data);
}

std::optional<Time> stamp_of(Time stamp) {
  return stamp == Time{} ? std::nullopt : std::optional(stamp);
}

Eigen::Vector3d vector(const auto& v) { return {v.x, v.y, v.z}; }
Eigen::Quaterniond rotation(const auto& q) { return {q.w, q.x, q.y, q.z}; }

/// K, or P for images that are rectified already.
Result<CameraModel> camera_of(int width, int height, const std::string& model,
                              std::vector<double> d, const std::array<double, 9>& k,
                              const std::array<double, 12>& p, bool rectified) {
  Eigen::Matrix3d matrix;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      matrix(row, column) = rectified ? p[static_cast<std::size_t>(4 * row + column)]
                                      : k[static_cast<std::size_t>(3 * row + column)];
  if (rectified) d.clear();
  const bool fisheye = model == "equidistant" || model == "kannala_brandt" || model == "fisheye";
  while (d.size() > (fisheye ? 4u : 8u) && d.back() == 0.0) d.pop_back();
  if (!fisheye && !d.empty() && model != "plumb_bob" && model != "rational_polynomial" &&
      std::any_of(d.begin(), d.end(), [](double x) { return x != 0.0; }))
    return Error{ErrorCode::Unsupported,
                 "the distortion model \"" + model +
                     "\" is none that we know (plumb_bob, rational_polynomial, equidistant, "
                     "kannala_brandt); give --camera FILE"};
  return CameraModel::make(fisheye ? LensModel::Fisheye : LensModel::Pinhole, width, height, matrix,
                           std::move(d));
}

bool is_rectified(const std::string& topic) { return topic.find("rect") != std::string::npos; }

class ContentReader {
 public:
  explicit ContentReader(const std::vector<MessageChannel>& channels) {
    for (const MessageChannel& c : channels)
      if (is_rectified(c.topic) && is_image_channel(c)) rectified_ = true;
  }

  void use(const RecordedMessage& m) {
    const std::string& type = m.channel.type;
    Status used;
    if (m.channel.encoding == MessageEncoding::Protobuf)
      used = use_protobuf(type, m);
    else
      used = use_ros(type, m);
    if (used) return;
    // The first of a topic tells; the others are counted.
    if (bad_[m.channel.topic]++ == 0)
      out_.notes.push_back(m.channel.topic + ": " + used.error().message);
  }

  MessageContent take() {
    for (const auto& [topic, n] : bad_)
      if (n > 1)
        out_.notes.push_back(std::to_string(n) + " messages of " + topic + " cannot be used");
    add_poses();
    out_.tree.finish();
    if (out_.tree.backward_steps() > 0)
      out_.notes.push_back("the times of transforms run backwards " +
                           std::to_string(out_.tree.backward_steps()) +
                           " times: of equal times the last counts");
    sort(out_.fixes);
    sort(out_.attitudes);
    sort(out_.ranges);
    return std::move(out_);
  }

 private:
  template <class T>
  static void sort(std::vector<T>& samples) {
    std::stable_sort(samples.begin(), samples.end(),
                     [](const T& a, const T& b) { return a.time < b.time; });
    samples.erase(std::unique(samples.begin(), samples.end(),
                              [](const T& a, const T& b) { return a.time == b.time; }),
                  samples.end());
  }

  void image(const RecordedMessage& m, Time stamp, std::uint32_t sequence, std::string frame) {
    out_.images[m.channel.id].push_back(
        {m.where, stamp_of(stamp), m.log_time, sequence, plain_frame(std::move(frame))});
  }

  void fix(Time stamp, Time log_time, double lat_deg, double lon_deg, double height_m) {
    if (!(std::abs(lat_deg) <= 90 && std::abs(lon_deg) <= 360 && std::isfinite(height_m))) return;
    out_.fixes.push_back({stamp_of(stamp).value_or(log_time),
                          {Angle::degrees(lat_deg), Angle::degrees(lon_deg), height_m}});
  }

  Status camera(const RecordedMessage& m, Result<CameraModel> camera) {
    if (!camera) return camera.error();
    out_.cameras.insert_or_assign(m.channel.topic, std::move(*camera));
    return {};
  }

  Status use_ros(const std::string& type, const RecordedMessage& m) {
    if (type == "sensor_msgs/Image") {
      WATERSKY_TRY(const auto x, decoded<ros::Image>(m));
      image(m, x.header.stamp, x.header.seq, x.header.frame_id);
    } else if (type == "sensor_msgs/CompressedImage") {
      WATERSKY_TRY(const auto x, decoded<ros::CompressedImage>(m));
      image(m, x.header.stamp, x.header.seq, x.header.frame_id);
    } else if (type == "sensor_msgs/CameraInfo") {
      WATERSKY_TRY(const auto x, decoded<ros::CameraInfo>(m));
      if (x.roi.x_offset != 0 || x.roi.y_offset != 0)
        return Error{ErrorCode::Unsupported,
                     "a CameraInfo of a part of the sensor is not understood; give --camera FILE"};
      return camera(m, camera_of(static_cast<int>(x.width), static_cast<int>(x.height),
                                 x.distortion_model, x.d, x.k, x.p, rectified_));
    } else if (type == "sensor_msgs/NavSatFix") {
      WATERSKY_TRY(const auto x, decoded<ros::NavSatFix>(m));
      if (x.status.status >= 0)
        fix(x.header.stamp, m.log_time, x.latitude, x.longitude, x.altitude);
    } else if (type == "sensor_msgs/Imu") {
      WATERSKY_TRY(const auto x, decoded<ros::Imu>(m));
      const Eigen::Quaterniond q = rotation(x.orientation);
      if (x.orientation_covariance[0] != -1.0 && std::abs(q.norm() - 1.0) < 1e-2)
        out_.attitudes.push_back({stamp_of(x.header.stamp).value_or(m.log_time), q.normalized()});
    } else if (type == "sensor_msgs/Range") {
      WATERSKY_TRY(const auto x, decoded<ros::Range>(m));
      const double range = x.range;
      if (std::isfinite(range) && range >= x.min_range &&
          (range <= x.max_range || x.max_range == 0))
        out_.ranges.push_back({stamp_of(x.header.stamp).value_or(m.log_time), range,
                               std::sqrt(std::max(0.0F, x.variance))});
    } else if (type == "tf2_msgs/TFMessage" || type == "tf/tfMessage") {
      WATERSKY_TRY(const auto x, decoded<ros::TFMessage>(m));
      const bool is_static = m.channel.topic.ends_with("tf_static");
      for (const ros::TransformStamped& t : x.transforms)
        WATERSKY_CHECK(out_.tree.add(
            t.header.frame_id, t.child_frame_id, t.header.stamp,
            {rotation(t.transform.rotation), vector(t.transform.translation)}, is_static));
    } else if (type == "nav_msgs/Odometry") {
      WATERSKY_TRY(const auto x, decoded<ros::Odometry>(m));
      pose(m, x.header, x.child_frame_id, x.pose.pose);
    } else if (type == "geometry_msgs/PoseStamped") {
      WATERSKY_TRY(const auto x, decoded<ros::PoseStamped>(m));
      pose(m, x.header, "", x.pose);
    }
    return {};
  }

  Status use_protobuf(const std::string& type, const RecordedMessage& m) {
    if (type == "foxglove.CompressedImage") {
      WATERSKY_TRY(const auto x, protobuf::decode<foxglove::CompressedImage>(m.data));
      image(m, x.timestamp, 0, x.frame_id);
    } else if (type == "foxglove.RawImage") {
      WATERSKY_TRY(const auto x, protobuf::decode<foxglove::RawImage>(m.data));
      image(m, x.timestamp, 0, x.frame_id);
    } else if (type == "foxglove.CameraCalibration") {
      WATERSKY_TRY(const auto x, protobuf::decode<foxglove::CameraCalibration>(m.data));
      return camera(m, camera_of(static_cast<int>(x.width), static_cast<int>(x.height),
                                 x.distortion_model, x.d, x.k, x.p, rectified_));
    } else if (type == "foxglove.LocationFix") {
      WATERSKY_TRY(const auto x, protobuf::decode<foxglove::LocationFix>(m.data));
      fix(x.timestamp, m.log_time, x.latitude, x.longitude, x.altitude);
    } else if (type == "foxglove.FrameTransform") {
      WATERSKY_TRY(const auto x, protobuf::decode<foxglove::FrameTransform>(m.data));
      return transform(x);
    } else if (type == "foxglove.FrameTransforms") {
      WATERSKY_TRY(const auto x, protobuf::decode<foxglove::FrameTransforms>(m.data));
      for (const auto& t : x.transforms) WATERSKY_CHECK(transform(t));
    }
    return {};
  }

  Status transform(const foxglove::FrameTransform& t) {
    return out_.tree.add(t.parent_frame_id, t.child_frame_id, t.timestamp,
                         {rotation(t.rotation), vector(t.translation)}, false);
  }

  /// Odometry and poses wait: where /tf tells the same it counts.
  void pose(const RecordedMessage& m, const ros::Header& header, const std::string& child,
            const ros::Pose& p) {
    poses_[m.channel.topic].push_back({header.frame_id,
                                       child,
                                       stamp_of(header.stamp).value_or(m.log_time),
                                       {rotation(p.orientation), vector(p.position)}});
  }

  void add_poses() {
    for (const auto& [topic, poses] : poses_) {
      const std::string child =
          poses.front().child.empty() ? "base_link" : plain_frame(poses.front().child);
      const bool told = out_.tree.has(child) && !out_.tree.only_moving().empty();
      if (told || !added_.insert(child).second) {
        out_.notes.push_back(topic + " was not used: " + child + " is placed already");
        continue;
      }
      for (const Posed& p : poses)
        if (const Status added = out_.tree.add(p.parent, child, p.time, p.motion, false); !added) {
          if (bad_[topic]++ == 0) out_.notes.push_back(topic + ": " + added.error().message);
        }
    }
  }

  struct Posed {
    std::string parent, child;
    Time time;
    RigidMotion motion;
  };

  bool rectified_ = false;
  MessageContent out_;
  std::map<std::string, std::vector<Posed>> poses_;  ///< by topic
  std::set<std::string> added_;
  std::map<std::string, std::size_t> bad_;
};

constexpr const char* kTypes[] = {"sensor_msgs/Image",
                                  "sensor_msgs/CompressedImage",
                                  "sensor_msgs/CameraInfo",
                                  "sensor_msgs/NavSatFix",
                                  "sensor_msgs/Imu",
                                  "sensor_msgs/Range",
                                  "tf2_msgs/TFMessage",
                                  "tf/tfMessage",
                                  "nav_msgs/Odometry",
                                  "geometry_msgs/PoseStamped",
                                  "foxglove.CompressedImage",
                                  "foxglove.RawImage",
                                  "foxglove.CameraCalibration",
                                  "foxglove.LocationFix",
                                  "foxglove.FrameTransform",
                                  "foxglove.FrameTransforms"};

}  // namespace

Result<MessageContent> read_content(const MessageFile& file, const Progress& progress) {
  std::set<std::uint32_t> channels;
  for (const MessageChannel& c : file.channels())
    if (c.encoding != MessageEncoding::Other &&
        std::find(std::begin(kTypes), std::end(kTypes), c.type) != std::end(kTypes))
      channels.insert(c.id);
  ContentReader reader(file.channels());
  std::size_t n = 0;
  WATERSKY_TRY(const auto damage, file.for_each(
                                      [&](const RecordedMessage& m) {
                                        if (n++ % 256 == 0)
                                          report(progress, "reading messages", n, 0);
                                        reader.use(m);
                                      },
                                      channels));
  report(progress, "reading messages", n, n);
  MessageContent out = reader.take();
  std::vector<std::string> notes = file.notes();
  add_new_notes(notes, damage);
  out.notes.insert(out.notes.begin(), notes.begin(), notes.end());
  return out;
}

}  // namespace watersky::detail
