// SPDX-License-Identifier: MIT
#pragma once
/// A folder of photographs that know where they were taken (EXIF) and how (DJI's XMP).
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/io/read_options.hpp"

namespace watersky {

/// A flight, and its take-off where the recording knows it.
struct RecordedFlight {
  Flight flight;
  std::optional<TakeOff> takeoff;
};

/// Reads headers only. Each frame carries its own pose and gimbal attitude.
///
/// Heights: RelativeAltitude is trusted above take-off. The take-off's own height, the median of
/// AbsoluteAltitude - RelativeAltitude, is nominal; the poses stand on the geoid plus both, so
/// that the height over a sea given as takeoff:M depends on RelativeAltitude alone. With RTK
/// AbsoluteAltitude counts, above the ellipsoid. Photographs without a RelativeAltitude have
/// EXIF's altitude above sea level.
///
/// Photographs without position or attitude are left out with the reason (see
/// ReadOptions::assume_nadir). The sea level is not set here.
[[nodiscard]] Result<RecordedFlight> read_photo_flight(const std::filesystem::path& folder,
                                                       const ReadOptions& options,
                                                       const Progress& progress = {});

/// One line of DJI's Timestamp.MRK.
struct RtkMark {
  int index = 0;
  std::optional<Time> utc;
  Angle latitude, longitude;
  double height_ellipsoid_m = 0.0;
  double sigma_north_m = 0.0, sigma_east_m = 0.0, sigma_height_m = 0.0;
};
/// Lines that are no marks are skipped.
[[nodiscard]] std::vector<RtkMark> parse_rtk_marks(std::string_view text);

}  // namespace watersky
