// SPDX-License-Identifier: MIT
#pragma once
/// The messages of ROS that a flight is made of. Each is described once, field by field; both
/// serialisations (ros.hpp), the definitions that bags and MCAP files carry, and their MD5 sums are
/// derived from that.
///
/// A field has two names where ROS 1 and ROS 2 write it differently; one that is missing in one of
/// them has nullptr there and is not serialised. Spans point into the bytes decoded, or at what is
/// to be encoded. Units and frames are ROS's (REP 103): metres, radians, x forward or east, z up.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "watersky/base/time.hpp"

namespace watersky::ros {

struct FieldInfo {
  const char* ros1 = nullptr;
  const char* ros2 = nullptr;
  constexpr FieldInfo(const char* both)  // NOLINT(google-explicit-constructor)
      : ros1(both), ros2(both) {}
  constexpr FieldInfo(const char* in_ros1, const char* in_ros2) : ros1(in_ros1), ros2(in_ros2) {}
};

/// A constant of the definition: it counts in ROS 1's MD5 sum.
struct Constant {
  const char* type;
  const char* name;
  const char* value;
  const char* before;  ///< the field that it stands before
};

struct TypeName {
  const char* package;
  const char* name;
};

struct Header {
  std::uint32_t seq = 0;
  Time stamp;
  std::string frame_id;

  static constexpr TypeName kType{"std_msgs", "Header"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.seq, FieldInfo{"seq", nullptr});
    field(m.stamp, "stamp");
    field(m.frame_id, "frame_id");
  }
};

struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;

  static constexpr TypeName kType{"geometry_msgs", "Vector3"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.x, "x");
    field(m.y, "y");
    field(m.z, "z");
  }
};

struct Point : Vector3 {
  static constexpr TypeName kType{"geometry_msgs", "Point"};
};

struct Quaternion {
  double x = 0.0, y = 0.0, z = 0.0, w = 1.0;

  static constexpr TypeName kType{"geometry_msgs", "Quaternion"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.x, "x");
    field(m.y, "y");
    field(m.z, "z");
    field(m.w, "w");
  }
};

struct Pose {
  Point position;
  Quaternion orientation;

  static constexpr TypeName kType{"geometry_msgs", "Pose"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.position, "position");
    field(m.orientation, "orientation");
  }
};

struct PoseStamped {
  Header header;
  Pose pose;

  static constexpr TypeName kType{"geometry_msgs", "PoseStamped"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.pose, "pose");
  }
};

/// Covariances are row-major, x y z then rotations about x, y, z.
struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance{};

  static constexpr TypeName kType{"geometry_msgs", "PoseWithCovariance"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.pose, "pose");
    field(m.covariance, "covariance");
  }
};

struct Twist {
  Vector3 linear, angular;

  static constexpr TypeName kType{"geometry_msgs", "Twist"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.linear, "linear");
    field(m.angular, "angular");
  }
};

struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance{};

  static constexpr TypeName kType{"geometry_msgs", "TwistWithCovariance"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.twist, "twist");
    field(m.covariance, "covariance");
  }
};

struct Transform {
  Vector3 translation;
  Quaternion rotation;

  static constexpr TypeName kType{"geometry_msgs", "Transform"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.translation, "translation");
    field(m.rotation, "rotation");
  }
};

/// header.frame_id from child_frame_id.
struct TransformStamped {
  Header header;
  std::string child_frame_id;
  Transform transform;

  static constexpr TypeName kType{"geometry_msgs", "TransformStamped"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.child_frame_id, "child_frame_id");
    field(m.transform, "transform");
  }
};

struct TFMessage {
  std::vector<TransformStamped> transforms;

  static constexpr TypeName kType{"tf2_msgs", "TFMessage"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.transforms, "transforms");
  }
};

struct Odometry {
  Header header;
  std::string child_frame_id;
  PoseWithCovariance pose;
  TwistWithCovariance twist;

  static constexpr TypeName kType{"nav_msgs", "Odometry"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.child_frame_id, "child_frame_id");
    field(m.pose, "pose");
    field(m.twist, "twist");
  }
};

struct MapMetaData {
  Time map_load_time;
  float resolution = 0.0F;  ///< m a cell
  std::uint32_t width = 0, height = 0;
  Pose origin;  ///< of the lower left corner of cell (0,0)

  static constexpr TypeName kType{"nav_msgs", "MapMetaData"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.map_load_time, "map_load_time");
    field(m.resolution, "resolution");
    field(m.width, "width");
    field(m.height, "height");
    field(m.origin, "origin");
  }
};

struct OccupancyGrid {
  Header header;
  MapMetaData info;
  std::span<const std::int8_t> data;  ///< row by row from the lower left: percent, -1 not known

  static constexpr TypeName kType{"nav_msgs", "OccupancyGrid"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.info, "info");
    field(m.data, "data");
  }
};

struct Image {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string encoding;  ///< "mono8", "bgr8", "mono16" …
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;  ///< bytes a row
  std::span<const std::uint8_t> data;

  static constexpr TypeName kType{"sensor_msgs", "Image"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.height, "height");
    field(m.width, "width");
    field(m.encoding, "encoding");
    field(m.is_bigendian, "is_bigendian");
    field(m.step, "step");
    field(m.data, "data");
  }
};

struct CompressedImage {
  Header header;
  std::string format;  ///< "jpeg", "png", or as image_transport says it: "bgr8; jpeg compressed …"
  std::span<const std::uint8_t> data;

  static constexpr TypeName kType{"sensor_msgs", "CompressedImage"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.format, "format");
    field(m.data, "data");
  }
};

struct RegionOfInterest {
  std::uint32_t x_offset = 0, y_offset = 0, height = 0, width = 0;
  bool do_rectify = false;

  static constexpr TypeName kType{"sensor_msgs", "RegionOfInterest"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.x_offset, "x_offset");
    field(m.y_offset, "y_offset");
    field(m.height, "height");
    field(m.width, "width");
    field(m.do_rectify, "do_rectify");
  }
};

struct CameraInfo {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;  ///< "plumb_bob", "rational_polynomial", "equidistant"
  std::vector<double> d;
  std::array<double, 9> k{};  ///< row-major
  std::array<double, 9> r{};
  std::array<double, 12> p{};
  std::uint32_t binning_x = 0, binning_y = 0;
  RegionOfInterest roi;

  static constexpr TypeName kType{"sensor_msgs", "CameraInfo"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.height, "height");
    field(m.width, "width");
    field(m.distortion_model, "distortion_model");
    field(m.d, FieldInfo{"D", "d"});
    field(m.k, FieldInfo{"K", "k"});
    field(m.r, FieldInfo{"R", "r"});
    field(m.p, FieldInfo{"P", "p"});
    field(m.binning_x, "binning_x");
    field(m.binning_y, "binning_y");
    field(m.roi, "roi");
  }
};

struct NavSatStatus {
  std::int8_t status = 0;  ///< below 0: no fix
  std::uint16_t service = 0;

  static constexpr TypeName kType{"sensor_msgs", "NavSatStatus"};
  static constexpr std::array<Constant, 8> kConstants{
      {{"int8", "STATUS_NO_FIX", "-1", "status"},
       {"int8", "STATUS_FIX", "0", "status"},
       {"int8", "STATUS_SBAS_FIX", "1", "status"},
       {"int8", "STATUS_GBAS_FIX", "2", "status"},
       {"uint16", "SERVICE_GPS", "1", "service"},
       {"uint16", "SERVICE_GLONASS", "2", "service"},
       {"uint16", "SERVICE_COMPASS", "4", "service"},
       {"uint16", "SERVICE_GALILEO", "8", "service"}}};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.status, "status");
    field(m.service, "service");
  }
};

struct NavSatFix {
  Header header;
  NavSatStatus status;
  double latitude = 0.0, longitude = 0.0;       ///< degrees
  double altitude = 0.0;                        ///< m above the WGS-84 ellipsoid
  std::array<double, 9> position_covariance{};  ///< east, north, up, m², row-major
  std::uint8_t position_covariance_type = 0;    ///< 0: not known

  static constexpr TypeName kType{"sensor_msgs", "NavSatFix"};
  static constexpr std::array<Constant, 4> kConstants{
      {{"uint8", "COVARIANCE_TYPE_UNKNOWN", "0", "position_covariance_type"},
       {"uint8", "COVARIANCE_TYPE_APPROXIMATED", "1", "position_covariance_type"},
       {"uint8", "COVARIANCE_TYPE_DIAGONAL_KNOWN", "2", "position_covariance_type"},
       {"uint8", "COVARIANCE_TYPE_KNOWN", "3", "position_covariance_type"}}};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.status, "status");
    field(m.latitude, "latitude");
    field(m.longitude, "longitude");
    field(m.altitude, "altitude");
    field(m.position_covariance, "position_covariance");
    field(m.position_covariance_type, "position_covariance_type");
  }
};

struct Imu {
  Header header;
  Quaternion orientation;
  std::array<double, 9> orientation_covariance{};  ///< the first is -1: there is no orientation
  Vector3 angular_velocity;
  std::array<double, 9> angular_velocity_covariance{};
  Vector3 linear_acceleration;
  std::array<double, 9> linear_acceleration_covariance{};

  static constexpr TypeName kType{"sensor_msgs", "Imu"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.orientation, "orientation");
    field(m.orientation_covariance, "orientation_covariance");
    field(m.angular_velocity, "angular_velocity");
    field(m.angular_velocity_covariance, "angular_velocity_covariance");
    field(m.linear_acceleration, "linear_acceleration");
    field(m.linear_acceleration_covariance, "linear_acceleration_covariance");
  }
};

struct Range {
  Header header;
  std::uint8_t radiation_type = 0;  ///< 0 ultrasound, 1 infrared
  float field_of_view = 0.0F;       ///< rad
  float min_range = 0.0F, max_range = 0.0F, range = 0.0F;
  /// m²; 0: not known. ROS 2 since Iron; older recordings end before it.
  float variance = 0.0F;

  static constexpr TypeName kType{"sensor_msgs", "Range"};
  static constexpr std::array<Constant, 2> kConstants{
      {{"uint8", "ULTRASOUND", "0", "radiation_type"},
       {"uint8", "INFRARED", "1", "radiation_type"}}};
  /// In ROS 2 the last field may be missing.
  static constexpr bool kLastMayBeMissing = true;
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.header, "header");
    field(m.radiation_type, "radiation_type");
    field(m.field_of_view, "field_of_view");
    field(m.min_range, "min_range");
    field(m.max_range, "max_range");
    field(m.range, "range");
    field(m.variance, FieldInfo{nullptr, "variance"});
  }
};

}  // namespace watersky::ros
