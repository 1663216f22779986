// SPDX-License-Identifier: MIT
#pragma once
/// What a file or recording holds, told without decoding an image.
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"

namespace watersky {

/// A box; a flight across 180° of longitude spans the globe in it.
struct GeographicExtent {
  double south_deg = 90, west_deg = 180, north_deg = -90, east_deg = -180;
  void add(double latitude_deg, double longitude_deg);
};

struct Inspection {
  /// "flight_folder", "photographs", "photographs_with_log", "video_with_log", "tlog", "dataflash",
  /// "lsf", "mcap", "rosbag", "photograph", "video", "map", "calibration" or "csv".
  std::string kind;
  std::string name;
  /// How many of each: messages by name, "frames", "poses", "left_out", rows.
  std::map<std::string, std::size_t> counts;
  /// Of those with times, how many a second; without those that come once.
  std::map<std::string, double> rates_hz;
  std::optional<Time> first, last;

  std::optional<GeographicExtent> extent;  ///< of the positions

  std::map<std::string, std::string> facts;  ///< "camera": "DJI FC300S", "size": "4000x2250"
  std::vector<std::string> notes;
};

/// NotFound, or InvalidInput or Unsupported when it is nothing that we can read.
[[nodiscard]] Result<Inspection> inspect(const std::filesystem::path& path);

/// One object; times as ISO 8601 and as seconds since 1970.
[[nodiscard]] nlohmann::json to_json(const Inspection& inspection);

}  // namespace watersky
