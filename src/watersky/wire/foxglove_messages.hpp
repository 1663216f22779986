// SPDX-License-Identifier: MIT
#pragma once
/// The messages that Foxglove shows without configuration, in protobuf (protobuf.hpp), which holds
/// images as they are where JSON would make them a third larger. Each is described once, field by
/// field; bytes and schemas are derived from that. Fields of later versions are skipped.
/// https://docs.foxglove.dev/docs/visualization/message-schemas/introduction
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "watersky/base/time.hpp"
#include "watersky/wire/protobuf_fields.hpp"

namespace watersky::foxglove {

using protobuf::FieldInfo;
using protobuf::TypeName;

struct Vector2 {
  double x = 0.0, y = 0.0;

  static constexpr TypeName kType{"foxglove", "Vector2"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.x, FieldInfo{1, "x"});
    field(m.y, FieldInfo{2, "y"});
  }
};

struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;

  static constexpr TypeName kType{"foxglove", "Vector3"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.x, FieldInfo{1, "x"});
    field(m.y, FieldInfo{2, "y"});
    field(m.z, FieldInfo{3, "z"});
  }
};

struct Quaternion {
  double x = 0.0, y = 0.0, z = 0.0, w = 0.0;

  static constexpr TypeName kType{"foxglove", "Quaternion"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.x, FieldInfo{1, "x"});
    field(m.y, FieldInfo{2, "y"});
    field(m.z, FieldInfo{3, "z"});
    field(m.w, FieldInfo{4, "w"});
  }
};

struct Pose {
  Vector3 position;
  Quaternion orientation;

  static constexpr TypeName kType{"foxglove", "Pose"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.position, FieldInfo{1, "position"});
    field(m.orientation, FieldInfo{2, "orientation"});
  }
};

enum class PositionCovarianceType { Unknown, Approximated, DiagonalKnown, Known };
constexpr protobuf::EnumInfo<4> enum_info(PositionCovarianceType) {
  return {"PositionCovarianceType", {"UNKNOWN", "APPROXIMATED", "DIAGONAL_KNOWN", "KNOWN"}};
}

struct LocationFix {
  Time timestamp;
  std::string frame_id;
  double latitude = 0.0, longitude = 0.0;       ///< degrees
  double altitude = 0.0;                        ///< m above the WGS-84 ellipsoid
  std::array<double, 9> position_covariance{};  ///< east, north, up, m²
  PositionCovarianceType position_covariance_type = PositionCovarianceType::Unknown;

  static constexpr TypeName kType{"foxglove", "LocationFix"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.latitude, FieldInfo{1, "latitude"});
    field(m.longitude, FieldInfo{2, "longitude"});
    field(m.altitude, FieldInfo{3, "altitude"});
    field(m.position_covariance, FieldInfo{4, "position_covariance"});
    field(m.position_covariance_type, FieldInfo{5, "position_covariance_type"});
    field(m.timestamp, FieldInfo{6, "timestamp"});
    field(m.frame_id, FieldInfo{7, "frame_id"});
  }
};

/// parent from child.
struct FrameTransform {
  Time timestamp;
  std::string parent_frame_id, child_frame_id;
  Vector3 translation;
  Quaternion rotation;

  static constexpr TypeName kType{"foxglove", "FrameTransform"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.timestamp, FieldInfo{1, "timestamp"});
    field(m.parent_frame_id, FieldInfo{2, "parent_frame_id"});
    field(m.child_frame_id, FieldInfo{3, "child_frame_id"});
    field(m.translation, FieldInfo{4, "translation"});
    field(m.rotation, FieldInfo{5, "rotation"});
  }
};

struct FrameTransforms {
  std::vector<FrameTransform> transforms;

  static constexpr TypeName kType{"foxglove", "FrameTransforms"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.transforms, FieldInfo{1, "transforms"});
  }
};

struct CompressedImage {
  Time timestamp;
  std::string frame_id;
  std::span<const std::uint8_t> data;
  std::string format;  ///< "jpeg", "png", "webp", "avif"

  static constexpr TypeName kType{"foxglove", "CompressedImage"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.timestamp, FieldInfo{1, "timestamp"});
    field(m.data, FieldInfo{2, "data"});
    field(m.format, FieldInfo{3, "format"});
    field(m.frame_id, FieldInfo{4, "frame_id"});
  }
};

struct RawImage {
  Time timestamp;
  std::string frame_id;
  std::uint32_t width = 0, height = 0;
  std::string encoding;  ///< as ROS's: "mono8", "bgr8", "mono16" …
  std::uint32_t step = 0;
  std::span<const std::uint8_t> data;

  static constexpr TypeName kType{"foxglove", "RawImage"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.timestamp, FieldInfo{1, "timestamp"});
    field(m.width, FieldInfo{2, "width"});
    field(m.height, FieldInfo{3, "height"});
    field(m.encoding, FieldInfo{4, "encoding"});
    field(m.step, FieldInfo{5, "step"});
    field(m.data, FieldInfo{6, "data"});
    field(m.frame_id, FieldInfo{7, "frame_id"});
  }
};

struct CameraCalibration {
  Time timestamp;
  std::string frame_id;
  std::uint32_t width = 0, height = 0;
  std::string distortion_model;  ///< "plumb_bob", "rational_polynomial", "kannala_brandt"
  std::vector<double> d;
  std::array<double, 9> k{}, r{};  ///< row-major
  std::array<double, 12> p{};

  static constexpr TypeName kType{"foxglove", "CameraCalibration"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.timestamp, FieldInfo{1, "timestamp"});
    field(m.width, FieldInfo{2, "width"});
    field(m.height, FieldInfo{3, "height"});
    field(m.distortion_model, FieldInfo{4, "distortion_model"});
    field(m.d, FieldInfo{5, "D"});
    field(m.k, FieldInfo{6, "K"});
    field(m.r, FieldInfo{7, "R"});
    field(m.p, FieldInfo{8, "P"});
    field(m.frame_id, FieldInfo{9, "frame_id"});
  }
};

enum class NumericType { Unknown, Uint8, Int8, Uint16, Int16, Uint32, Int32, Float32, Float64 };
constexpr protobuf::EnumInfo<9> enum_info(NumericType) {
  return {"NumericType",
          {"UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64"}};
}

struct PackedElementField {
  std::string name;  ///< "red", "green", "blue", "alpha" give a picture
  std::uint32_t offset = 0;
  NumericType type = NumericType::Unknown;

  static constexpr TypeName kType{"foxglove", "PackedElementField"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.name, FieldInfo{1, "name"});
    field(m.offset, FieldInfo{2, "offset"});
    field(m.type, FieldInfo{3, "type"});
  }
};

/// Row-major from the corner that `pose` places.
struct Grid {
  Time timestamp;
  std::string frame_id;
  Pose pose;
  std::uint32_t column_count = 0;
  Vector2 cell_size;                              ///< m
  std::uint32_t row_stride = 0, cell_stride = 0;  ///< bytes
  std::vector<PackedElementField> fields;
  std::span<const std::uint8_t> data;

  static constexpr TypeName kType{"foxglove", "Grid"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.timestamp, FieldInfo{1, "timestamp"});
    field(m.frame_id, FieldInfo{2, "frame_id"});
    field(m.pose, FieldInfo{3, "pose"});
    field(m.column_count, FieldInfo{4, "column_count"});
    field(m.cell_size, FieldInfo{5, "cell_size"});
    field(m.row_stride, FieldInfo{6, "row_stride"});
    field(m.cell_stride, FieldInfo{7, "cell_stride"});
    field(m.fields, FieldInfo{8, "fields"});
    field(m.data, FieldInfo{9, "data"});
  }
};

struct GeoJSON {
  std::string geojson;

  static constexpr TypeName kType{"foxglove", "GeoJSON"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.geojson, FieldInfo{1, "geojson"});
  }
};

}  // namespace watersky::foxglove
