// SPDX-License-Identifier: MIT
#pragma once
/// What is known of places and heights from outside the pictures: anchors and measured ranges.
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"
#include "watersky/camera/camera_model.hpp"
#include "watersky/geodesy/wgs84.hpp"

namespace watersky {

enum class HeightAbove { Sea, Ellipsoid };

/// Where a known point is. By itself at the surface of the sea, wherever that is.
struct AnchorPlace {
  Angle latitude, longitude;
  double height_m = 0.0;
  HeightAbove above = HeightAbove::Sea;
};

struct AnchorFix {
  Time time;
  AnchorPlace place;
};

/// Where an anchor is in one picture.
struct AnchorSighting {
  std::string frame;  ///< ImageFrame::name
  Pixel px;           ///< of the full picture as it is stored; whole numbers are pixels' middles
  double sigma_px = 1.0;
};

/// A point whose place is known: surveyed on land or fast ice, a beacon on a floe, the ship.
struct Anchor {
  std::string name;
  std::optional<AnchorPlace> place;  ///< of one that stands still
  std::vector<AnchorFix> track;      ///< of one that moves; times strictly rising
  double sigma_m = 1.0;              ///< of north and of east
  double sigma_height_m = 1.0;
  std::vector<AnchorSighting> sightings;

  /// `place`, or between the fixes around a time, linearly. OutOfRange before the first fix, after
  /// the last, and in a gap of more than ten minutes, in which nobody knows how ice went.
  [[nodiscard]] Result<AnchorPlace> at(Time time) const;
};

/// What a range finder that looks along the body's down axis measured: the slant distance to the
/// sea. Times are the poses'.
struct RangeSample {
  Time time;
  double range_m = 0.0;
  double sigma_m = 0.0;  ///< of the instrument; 0: not known
};

}  // namespace watersky
