// SPDX-License-Identifier: MIT
#pragma once
/// Videos as a flight's frames, through the programs ffprobe and ffmpeg (Debian's package ffmpeg),
/// which need to be there only when a video is read. Pixels come as they were stored: a rotation
/// in the container is not applied.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "watersky/flight/flight.hpp"

namespace watersky {

/// One frame as the container lists it.
struct VideoFrame {
  std::int64_t pts = 0;  ///< presentation time in ticks
  bool key = false;      ///< decoding can begin here
};

struct VideoInfo {
  std::filesystem::path path;
  int stream = 0;  ///< its index in the container
  int width_px = 0;
  int height_px = 0;
  double rotation_deg = 0.0;  ///< counter-clockwise, for showing; not applied
  std::string codec;
  bool gray = false;                                      ///< one channel
  bool sixteen_bit = false;                               ///< gray of more than 8 bits
  std::int64_t tick_numerator = 1, tick_denominator = 1;  ///< a tick is their ratio in seconds
  std::vector<VideoFrame> frames;   ///< as shown: by strictly rising pts; at least one
  std::size_t frames_promised = 0;  ///< by the header; 0: it does not say
  /// The container's creation_time as it stands there. Most cameras write when recording began,
  /// to the second; some write when it ended, and some their local time.
  std::optional<Time> creation_time;

  /// When a frame is shown after the first.
  [[nodiscard]] Duration after_first(std::size_t frame) const;
  [[nodiscard]] double duration_s() const {
    return static_cast<double>(after_first(frames.size() - 1).count()) * 1e-9;
  }
  /// Frames a second, the mean; 0 for a single frame.
  [[nodiscard]] double rate_hz() const;
};

/// Whether the name ends as one that we read: .mp4 .mov .mkv .avi .ts, in either case.
[[nodiscard]] bool is_video_file(const std::filesystem::path& file);

/// The videos in `folder` by name, without those in folders below it.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_videos(
    const std::filesystem::path& folder);

/// Reads the container without decoding (save where it lists no times of its own). NotFound when
/// there is no such file or ffprobe is not installed, InvalidInput when it is no video.
[[nodiscard]] Result<VideoInfo> probe_video(const std::filesystem::path& file);

/// The first frame of every `interval_s` since the first, or every frame when that is 0: their
/// numbers.
[[nodiscard]] std::vector<std::size_t> choose_video_frames(const VideoInfo& info,
                                                           double interval_s);

/// Those frames, named "video.mp4#120", the frame's number as counter, captured at `start` (of
/// the first frame) and the time since. They share a decoder: asked for in their order they
/// stream from one ffmpeg process; in any other order it seeks. The loaders may be called from
/// several threads.
///
/// A frame that is damaged, missing, or built on one that is (until the next key frame) is
/// InvalidInput: a codec would make its pixels up. Damage that a codec without checksums decodes
/// without complaint cannot be told.
[[nodiscard]] std::vector<ImageFrame> video_frames(const VideoInfo& info, double interval_s,
                                                   Time start);

}  // namespace watersky
