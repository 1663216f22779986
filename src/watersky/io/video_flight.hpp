// SPDX-License-Identifier: MIT
#pragma once
/// A video, and an autopilot's log that knows where it was filmed.
#include "watersky/io/photo_flight.hpp"

namespace watersky {

/// The log that belongs to a video: --log, the one of the same stem beside it, or the only one
/// there. NotFound, or InvalidInput when there are several.
[[nodiscard]] Result<std::filesystem::path> log_of_video(const std::filesystem::path& video,
                                                         const ReadOptions& options);

/// One frame every ReadOptions::video_frame_interval_s. The UTC of the first frame, in this
/// order: ReadOptions::video_start; the name by ReadOptions::name_pattern, or a UTC time that is
/// recognised in it; the container's creation_time, whose weakness a note tells. NotFound when
/// there is none: time is never guessed. The lens is ReadOptions::camera_file or focal_px, or a
/// camera.yaml beside the video. Everything else as read_log_flight().
[[nodiscard]] Result<RecordedFlight> read_video_flight(const std::filesystem::path& video,
                                                       const std::filesystem::path& log,
                                                       const ReadOptions& options,
                                                       const Progress& progress = {});

}  // namespace watersky
