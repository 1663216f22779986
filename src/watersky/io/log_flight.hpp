// SPDX-License-Identifier: MIT
#pragma once
/// Photographs that know at most their time, and an autopilot's log that knows the rest.
#include "watersky/io/photo_flight.hpp"

namespace watersky {

/// Image times, in this order: the log's camera feedback (CAMERA_FEEDBACK, CAM) when it holds one
/// for each photograph; the name by ReadOptions::name_pattern, or a UTC time that is recognised in
/// every name; EXIF's GPS time or clock with its offset (or ReadOptions::camera_utc_offset_h). A
/// photograph without any is left out. With ReadOptions::delay_s these are times of arrival.
///
/// A gimbal's attitude in the log stands between body and camera. Otherwise the mount is
/// ReadOptions::mount, or assumed straight down, and a note says so. The sea level is not set.
[[nodiscard]] Result<RecordedFlight> read_log_flight(const std::filesystem::path& folder,
                                                     const std::filesystem::path& log,
                                                     const ReadOptions& options,
                                                     const Progress& progress = {});

}  // namespace watersky
