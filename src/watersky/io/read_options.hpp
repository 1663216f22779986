// SPDX-License-Identifier: MIT
#pragma once
/// What a person may say about a recording that it does not say itself.
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "watersky/base/time.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/geodesy/wgs84.hpp"
#include "watersky/io/sea_level.hpp"

namespace watersky {

struct ReadOptions {
  std::optional<std::filesystem::path> camera_file;  ///< an OpenCV calibration
  std::optional<double> focal_px;
  std::optional<YawPitchRoll> mount;  ///< of the camera in the body (or on the gimbal)
  /// Of the camera in the body (or on the gimbal): forward, right, down.
  std::optional<Eigen::Vector3d> lever_arm_m;
  std::optional<std::filesystem::path> log;  ///< an autopilot's log for photographs
  std::optional<SeaLevelOption> sea_level;
  /// Known points and where they are seen, instead of those beside the recording.
  std::optional<std::filesystem::path> anchors_file;
  std::optional<std::filesystem::path> range_file;  ///< a range finder's, likewise
  std::optional<double> delay_s;                    ///< received minus captured
  /// Photographs without attitude are taken as looking straight down, with a stated sigma.
  bool assume_nadir = false;
  /// Where the UTC of an image stands in its name: Y M D h m s and c for fractions of a second,
  /// as many as there are digits; other characters stand for themselves.
  std::optional<std::string> name_pattern;
  /// What the camera's clock shows more than UTC, where the photographs do not say.
  std::optional<double> camera_utc_offset_h;
  /// The UTC of a video's first frame.
  std::optional<Time> video_start;
  /// One frame of a video is used for each such interval, 0: every frame. Looks at the same ice
  /// with the same error, 30 times a second, tell little more than two.
  double video_frame_interval_s = 0.5;
  // Of MCAP files and bags:
  std::optional<std::string> image_topic;   ///< where several have images
  std::optional<std::string> camera_frame;  ///< otherwise the images' frame_id
  std::optional<std::string> map_frame;     ///< otherwise the top of the camera's chain
  /// Where the map frame's origin is, otherwise as NavSatFix says.
  std::optional<Geodetic> datum;
};

/// "ROLL,PITCH,YAW" in degrees; Usage otherwise.
[[nodiscard]] Result<YawPitchRoll> parse_mount_option(std::string_view text);
/// "FORWARD,RIGHT,DOWN" in metres; Usage otherwise.
[[nodiscard]] Result<Eigen::Vector3d> parse_lever_arm_option(std::string_view text);

/// "LAT,LON,HEIGHT": degrees and metres above the ellipsoid; Usage otherwise.
[[nodiscard]] Result<Geodetic> parse_datum_option(std::string_view text);

/// ISO 8601 with Z or an offset from UTC (2018-08-05T01:00:44.80Z, 2018-08-05T03:00:44+02:00), or
/// seconds since 1970; Usage otherwise.
[[nodiscard]] Result<Time> parse_video_start_option(std::string_view text);

}  // namespace watersky
