// SPDX-License-Identifier: MIT
#pragma once
/// What a photograph says about itself: EXIF (libexif) and DJI's XMP, from the segments before
/// the pixels. Nothing is decoded.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "watersky/base/angle.hpp"
#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky {

struct PhotoMetadata {
  int width_px = 0;  ///< of the pixels themselves, whatever EXIF says
  int height_px = 0;
  std::string make, model;

  std::optional<double> focal_length_mm;
  std::optional<double> focal_length_35mm_mm;  ///< 35 mm equivalent, a whole number in EXIF
  std::optional<double> focal_plane_px_per_mm;
  std::optional<double> calibrated_focal_px;  ///< DJI's CalibratedFocalLength
  /// DJI's DewarpData: fx fy cx cy k1 k2 p1 p2 k3, the centre relative to the image's middle.
  std::vector<double> dewarp;
  bool dewarped = false;  ///< DewarpFlag: the pixels are already free of distortion

  std::optional<Angle> latitude, longitude;
  std::optional<double> gps_altitude_m;  ///< nominally above sea level
  std::optional<Angle> image_direction;  ///< GPSImgDirection against true north
  std::optional<Time> gps_time;          ///< UTC

  /// DateTimeOriginal with its fraction, as if it were UTC, and what to subtract for UTC.
  std::optional<Time> taken_local;
  std::optional<Duration> utc_offset;

  std::optional<YawPitchRoll>
      gimbal;  ///< against north, east, down; at pitch -90° yaw is where the image top points
  std::optional<YawPitchRoll> flight;         ///< the body's attitude
  std::optional<double> relative_altitude_m;  ///< above take-off
  std::optional<double> absolute_altitude_m;
  /// The altitude is RTK's, above the ellipsoid; otherwise nominally above sea level.
  bool altitude_is_ellipsoidal = false;
  std::optional<double> rtk_sigma_north_m, rtk_sigma_east_m, rtk_sigma_height_m;

  /// The best UTC that the photograph itself records: GPS time, or the camera's clock with its
  /// offset; nullopt when only a local time is known.
  [[nodiscard]] std::optional<Time> utc() const;
  /// "DJI FC300S", without saying the make twice.
  [[nodiscard]] std::string camera_name() const;
};

/// From the first bytes of a JPEG file. OutOfRange when they end before the image's size was
/// found (read more), InvalidInput when they are no JPEG. Damaged metadata is as good as absent.
[[nodiscard]] Result<PhotoMetadata> parse_photo_metadata(std::span<const std::uint8_t> bytes);

/// From a file, reading no more of it than its header. Formats other than JPEG give the size
/// alone.
[[nodiscard]] Result<PhotoMetadata> read_photo_metadata(const std::filesystem::path& file);

/// "2016:06:23 16:31:59", fraction digits "48": a time as if it were UTC; nullopt for what is no
/// date.
[[nodiscard]] std::optional<Time> parse_exif_time(std::string_view text,
                                                  std::string_view fraction = {});
/// "+02:00", "-0930", "Z".
[[nodiscard]] std::optional<Duration> parse_utc_offset(std::string_view text);

}  // namespace watersky
