// SPDX-License-Identifier: MIT
#pragma once
/// What photographs and a video with an autopilot's log have in common.
#include "watersky/io/autopilot_log.hpp"
#include "watersky/io/camera_table.hpp"
#include "watersky/io/photo_flight.hpp"

namespace watersky::detail {

/// Unsupported unless it is a .tlog.
[[nodiscard]] Result<AutopilotLog> read_log(const std::filesystem::path& log_file,
                                            const Progress& progress);

/// Frames, timed in captured_at, with the log's poses, gimbal and take-off. With
/// ReadOptions::delay_s their times become arrivals. The flight has the name of `recording`.
[[nodiscard]] Result<RecordedFlight> flight_by_log(const std::filesystem::path& recording,
                                                   const std::filesystem::path& log_file,
                                                   AutopilotLog log, Intrinsics intrinsics,
                                                   std::vector<ImageFrame> frames,
                                                   const ReadOptions& options,
                                                   std::vector<std::string> notes);

}  // namespace watersky::detail
