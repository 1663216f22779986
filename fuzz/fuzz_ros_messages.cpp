// SPDX-License-Identifier: MIT
/// Messages in ROS 1's serialisation, CDR and protobuf: the first byte chooses which; what is
/// decoded and encoded decodes to the same.
#include <cstdint>
#include <cstdlib>

#include "watersky/wire/protobuf.hpp"
#include "watersky/wire/ros.hpp"

namespace {

using namespace watersky;
using Bytes = std::span<const std::uint8_t>;

template <class M>
void try_ros(ros::Encoding encoding, Bytes bytes) {
  const auto message = ros::decode<M>(encoding, bytes);
  if (!message) return;
  const auto once = ros::encode(encoding, *message);
  const auto back = ros::decode<M>(encoding, once);
  if (!back || ros::encode(encoding, *back) != once) std::abort();
}

template <class M>
void try_protobuf(Bytes bytes) {
  const auto message = protobuf::decode<M>(bytes);
  if (!message) return;
  const auto once = protobuf::encode(*message);
  const auto back = protobuf::decode<M>(once);
  if (!back || protobuf::encode(*back) != once) std::abort();
}

template <class... M>
void choose_ros(unsigned which, ros::Encoding encoding, Bytes bytes) {
  unsigned i = 0;
  ((i++ == which ? try_ros<M>(encoding, bytes) : void()), ...);
}
template <class... M>
void choose_protobuf(unsigned which, Bytes bytes) {
  unsigned i = 0;
  ((i++ == which ? try_protobuf<M>(bytes) : void()), ...);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Bytes bytes(data + 1, size - 1);
  const unsigned which = data[0] % 12, kind = data[0] / 12 % 3;
  if (kind < 2)
    choose_ros<ros::Header, ros::Image, ros::CompressedImage, ros::CameraInfo, ros::NavSatFix,
               ros::Imu, ros::Range, ros::PoseStamped, ros::TransformStamped, ros::TFMessage,
               ros::Odometry, ros::OccupancyGrid>(
        which, kind == 0 ? ros::Encoding::Ros1 : ros::Encoding::Cdr, bytes);
  else
    choose_protobuf<foxglove::LocationFix, foxglove::FrameTransform, foxglove::FrameTransforms,
                    foxglove::CompressedImage, foxglove::RawImage, foxglove::CameraCalibration,
                    foxglove::Grid, foxglove::GeoJSON, recording::Pose, recording::Frame,
                    recording::Gimbal, recording::Range>(which, bytes);
  return 0;
}
