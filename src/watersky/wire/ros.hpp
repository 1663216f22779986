// SPDX-License-Identifier: MIT
#pragma once
/// ROS's messages as bytes and back: ROS 1's serialisation, and the CDR of ROS 2. For every message
/// of ros_messages.hpp.
///
///   WATERSKY_TRY(const auto fix, ros::decode<ros::NavSatFix>(ros::Encoding::Ros1, bytes));
#include "watersky/base/result.hpp"
#include "watersky/wire/ros_messages.hpp"

namespace watersky::ros {

enum class Encoding {
  Ros1,  ///< little-endian, without alignment
  Cdr    ///< with its four bytes of encapsulation; written as CDR_LE, read in either byte order
         ///< and as plain CDR 2
};

/// InvalidInput, naming type and byte, when the bytes end early; bytes left over are ignored, as
/// later versions of a type append fields. Unsupported for an encapsulation that is not named
/// above. Nothing larger than the bytes is allocated. Spans in it point into `bytes`.
template <class M>
[[nodiscard]] Result<M> decode(Encoding encoding, std::span<const std::uint8_t> bytes);

/// Times that the encoding cannot carry (ROS 1: before 1970; both: beyond 2106 or 2038) become the
/// nearest that it can.
template <class M>
[[nodiscard]] std::vector<std::uint8_t> encode(Encoding encoding, const M& message);

struct Definition {
  std::string type;    ///< "sensor_msgs/Image"; ROS 2: "sensor_msgs/msg/Image"
  std::string text;    ///< with the definitions of all types in it, as bags and MCAP have it
  std::string md5sum;  ///< ROS 1 only
};

template <class M>
[[nodiscard]] Definition definition(Encoding encoding);

}  // namespace watersky::ros
