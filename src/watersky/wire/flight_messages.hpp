// SPDX-License-Identifier: MIT
#pragma once
/// What a flight holds that Foxglove has no message for, so that a recording of ours loses nothing.
/// Described as those of foxglove_messages.hpp. Lengths in metres, angles in radians; World is
/// north, east, down at the datum (docs/notation.md).
#include "watersky/wire/foxglove_messages.hpp"

namespace watersky::recording {

using foxglove::Quaternion;
using foxglove::Vector3;
using protobuf::FieldInfo;
using protobuf::TypeName;

/// world_from_body.
struct Pose {
  Time timestamp;
  Vector3 position;
  Quaternion rotation;
  std::vector<double> sigma;       ///< north, east, down, roll, pitch, yaw; empty: not known
  std::vector<double> covariance;  ///< 6 x 6, position then rotation vector; empty: not known

  static constexpr TypeName kType{"watersky", "Pose"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.timestamp, FieldInfo{1, "timestamp"});
    field(m.position, FieldInfo{2, "position"});
    field(m.rotation, FieldInfo{3, "rotation"});
    field(m.sigma, FieldInfo{4, "sigma"});
    field(m.covariance, FieldInfo{5, "covariance"});
  }
};

/// Stands right before its image, whose message has the same sequence number.
struct Frame {
  std::string name;
  std::optional<Time> captured_at, received_at;
  bool has_counter = false;
  std::uint64_t counter = 0;
  std::optional<Pose> own_pose;
  std::optional<Quaternion> own_gimbal;

  static constexpr TypeName kType{"watersky", "Frame"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.name, FieldInfo{1, "name"});
    field(m.captured_at, FieldInfo{2, "captured_at"});
    field(m.received_at, FieldInfo{3, "received_at"});
    field(m.has_counter, FieldInfo{4, "has_counter"});
    field(m.counter, FieldInfo{5, "counter"});
    field(m.own_pose, FieldInfo{6, "own_pose"});
    field(m.own_gimbal, FieldInfo{7, "own_gimbal"});
  }
};

/// The gimbal's recorded attitude.
struct Gimbal {
  Time timestamp;
  Quaternion rotation;

  static constexpr TypeName kType{"watersky", "Gimbal"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.timestamp, FieldInfo{1, "timestamp"});
    field(m.rotation, FieldInfo{2, "rotation"});
  }
};

/// Of a range finder that looks along the body's down axis.
struct Range {
  Time timestamp;
  double range = 0.0;
  double sigma = 0.0;  ///< 0: not known

  static constexpr TypeName kType{"watersky", "Range"};
  template <class Self, class Field>
  static void describe(Self& m, Field&& field) {
    field(m.timestamp, FieldInfo{1, "timestamp"});
    field(m.range, FieldInfo{2, "range"});
    field(m.sigma, FieldInfo{3, "sigma"});
  }
};

}  // namespace watersky::recording
