// SPDX-License-Identifier: MIT
#include <opencv2/imgproc.hpp>

#include "watersky/io/detail/message_content.hpp"
#include "watersky/wire/protobuf.hpp"
#include "watersky/wire/ros.hpp"

namespace watersky::detail {

namespace {

struct RawLayout {
  const char* encoding;
  int type;         ///< of a cv::Mat
  int to_bgr = -1;  ///< a cv::ColorConversionCodes; -1: it is gray or BGR already
};
// OpenCV names a Bayer pattern by its second row's second pixel on, ROS by its first.
constexpr RawLayout kLayouts[] = {
    {"mono8", CV_8UC1},
    {"8UC1", CV_8UC1},
    {"mono16", CV_16UC1},
    {"16UC1", CV_16UC1},
    {"bgr8", CV_8UC3},
    {"8UC3", CV_8UC3},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR},
};

struct Raw {
  std::uint32_t width = 0, height = 0, step = 0;
  std::string encoding;
  bool big_endian = false;
  std::span<const std::uint8_t> data;
};

Result<cv::Mat> decode_raw(const Raw& raw, const ImageRequest& request, const std::string& name) {
  const auto* layout = std::find_if(std::begin(kLayouts), std::end(kLayouts),
                                    [&](const RawLayout& l) { return raw.encoding == l.encoding; });
  if (layout == std::end(kLayouts))
    return Error{ErrorCode::Unsupported, name + ": its pixels are \"" + raw.encoding +
                                             "\"; mono8, mono16, bgr8, rgb8, bgra8, rgba8 and "
                                             "bayer_…8 are read"};
  const std::uint64_t pixel = CV_ELEM_SIZE(layout->type);
  // step · height cannot overflow: both are 32 bits.
  if (raw.width == 0 || raw.height == 0 || raw.width > 1u << 20 || raw.height > 1u << 20 ||
      raw.step < raw.width * pixel ||
      std::uint64_t{raw.step} * (raw.height - 1) + raw.width * pixel > raw.data.size())
    return Error{ErrorCode::InvalidInput, name + ": claims " + std::to_string(raw.width) + "x" +
                                              std::to_string(raw.height) + " pixels in " +
                                              std::to_string(raw.data.size()) + " bytes"};
  if (raw.big_endian && CV_MAT_DEPTH(layout->type) == CV_16U)
    return Error{ErrorCode::Unsupported, name + ": big-endian pixels are not read"};
  // OpenCV takes no const pixels; these are only copied or converted from.
  const cv::Mat view(static_cast<int>(raw.height), static_cast<int>(raw.width), layout->type,
                     const_cast<std::uint8_t*>(raw.data.data()), raw.step);
  cv::Mat out;
  try {
    if (layout->to_bgr >= 0)
      cv::cvtColor(view, out, layout->to_bgr);
    else
      out = view.clone();
    if (!request.color && out.channels() == 3) cv::cvtColor(out, out, cv::COLOR_BGR2GRAY);
  } catch (const cv::Exception&) {
    return Error{ErrorCode::InvalidInput, name + ": its pixels cannot be converted"};
  }
  return out;
}

template <class M>
Result<M> ros_message(const MessageChannel& channel, std::span<const std::uint8_t> data) {
  return ros::decode<M>(
      channel.encoding == MessageEncoding::Ros1 ? ros::Encoding::Ros1 : ros::Encoding::Cdr, data);
}

/// A compressed image's bytes and format; nullopt for a raw one.
struct Compressed {
  std::span<const std::uint8_t> data;
  std::string format;
};
Result<std::optional<Compressed>> compressed_of(const MessageChannel& channel,
                                                std::span<const std::uint8_t> data) {
  if (channel.type == "sensor_msgs/CompressedImage") {
    WATERSKY_TRY(auto m, ros_message<ros::CompressedImage>(channel, data));
    return std::optional(Compressed{m.data, std::move(m.format)});
  }
  if (channel.type == "foxglove.CompressedImage") {
    WATERSKY_TRY(auto m, protobuf::decode<foxglove::CompressedImage>(data));
    return std::optional(Compressed{m.data, std::move(m.format)});
  }
  return std::optional<Compressed>();
}

bool begins_with(std::span<const std::uint8_t> data, std::string_view magic) {
  return data.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), data.begin(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

}  // namespace

bool is_image_channel(const MessageChannel& channel) {
  if (channel.encoding == MessageEncoding::Other) return false;
  // Depth and Theora are published beside an image, under its name.
  if (channel.topic.ends_with("/compressedDepth") || channel.topic.ends_with("/theora"))
    return false;
  return channel.type == "sensor_msgs/Image" || channel.type == "sensor_msgs/CompressedImage" ||
         channel.type == "foxglove.CompressedImage" || channel.type == "foxglove.RawImage";
}

Result<cv::Mat> decode_image_message(const MessageChannel& channel,
                                     std::span<const std::uint8_t> data,
                                     const ImageRequest& request, const std::string& name) {
  WATERSKY_TRY(const auto compressed, compressed_of(channel, data));
  if (compressed) return load_image(compressed->data, request, name);
  if (channel.type == "foxglove.RawImage") {
    WATERSKY_TRY(const auto m, protobuf::decode<foxglove::RawImage>(data));
    return decode_raw({m.width, m.height, m.step, m.encoding, false, m.data}, request, name);
  }
  WATERSKY_TRY(const auto m, ros_message<ros::Image>(channel, data));
  return decode_raw({m.width, m.height, m.step, m.encoding, m.is_bigendian != 0, m.data}, request,
                    name);
}

Result<std::optional<EncodedImage>> encoded_of(const MessageChannel& channel,
                                               std::span<const std::uint8_t> data,
                                               const std::string& name) {
  WATERSKY_TRY(const auto compressed, compressed_of(channel, data));
  if (!compressed) return std::optional<EncodedImage>();
  EncodedImage out;
  out.bytes.assign(compressed->data.begin(), compressed->data.end());
  if (begins_with(compressed->data, "\xFF\xD8\xFF"))
    out.extension = ".jpg";
  else if (begins_with(compressed->data, "\x89PNG"))
    out.extension = ".png";
  else
    return Error{ErrorCode::Unsupported,
                 name + ": is compressed as \"" + compressed->format + "\"; JPEG and PNG are read"};
  return std::optional(std::move(out));
}

}  // namespace watersky::detail
