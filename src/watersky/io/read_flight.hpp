// SPDX-License-Identifier: MIT
#pragma once
/// Any recording that we know, as a Flight.
#include <filesystem>

#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/io/read_options.hpp"

namespace watersky {

enum class RecordingKind {
  FlightFolder,        ///< holds flight.yaml
  PhotographsWithLog,  ///< photographs, and one autopilot log beside them or given
  Photographs,
  VideoWithLog,  ///< a video, or the one in a folder without photographs, and its log
  Messages,      ///< an MCAP file or a ROS 1 bag
};

/// What a path holds; NotFound or Unsupported, saying what can be read, when it is none of these.
[[nodiscard]] Result<RecordingKind> recording_kind(const std::filesystem::path& path,
                                                   const ReadOptions& options = {});

/// Reads headers and logs, not pixels. A flight whose sea level is neither in the recording nor
/// in the options is returned without one (see explain_sea_level()).
[[nodiscard]] Result<Flight> read_flight(const std::filesystem::path& path,
                                         const ReadOptions& options = {},
                                         const Progress& progress = {});

}  // namespace watersky
