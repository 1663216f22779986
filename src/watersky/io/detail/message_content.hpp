// SPDX-License-Identifier: MIT
#pragma once
/// What a recording's messages say that a flight needs, whatever they are written in.
#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/camera/camera_model.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/io/detail/frame_tree.hpp"
#include "watersky/io/detail/message_file.hpp"
#include "watersky/io/image_file.hpp"

namespace watersky::detail {

struct RecordedImage {
  mcap::Location where;
  std::optional<Time> stamp;  ///< of its header; nullopt where that is zero
  Time log_time;
  std::uint32_t sequence = 0;  ///< of a ROS 1 header; 0: not known
  std::string frame_id;
};

struct RecordedFix {
  Time time;
  Geodetic place;
};

struct RecordedAttitude {
  Time time;
  Eigen::Quaterniond enu_from_flu;
};

struct MessageContent {
  std::map<std::uint32_t, std::vector<RecordedImage>> images;  ///< by channel
  std::map<std::string, CameraModel> cameras;                  ///< by topic, the last told
  FrameTree tree;                                              ///< with odometry and poses in it
  std::vector<RecordedFix> fixes;
  std::vector<RecordedAttitude> attitudes;
  std::vector<RangeSample> ranges;
  std::vector<std::string> notes;
};

/// One pass over the file.
[[nodiscard]] Result<MessageContent> read_content(const MessageFile& file,
                                                  const Progress& progress);

/// Whether a channel's messages are images that we decode.
[[nodiscard]] bool is_image_channel(const MessageChannel& channel);

/// The pixels of an image's message.
[[nodiscard]] Result<cv::Mat> decode_image_message(const MessageChannel& channel,
                                                   std::span<const std::uint8_t> data,
                                                   const ImageRequest& request,
                                                   const std::string& name);

/// A compressed image's bytes as a file would hold them; nullopt for a raw image.
[[nodiscard]] Result<std::optional<EncodedImage>> encoded_of(const MessageChannel& channel,
                                                             std::span<const std::uint8_t> data,
                                                             const std::string& name);

}  // namespace watersky::detail
