// SPDX-License-Identifier: MIT
#pragma once
/// Figures that several products tell of the used frames.
#include <Eigen/Core>
#include <vector>

#include "watersky/base/angle.hpp"
#include "watersky/products/products.hpp"

namespace watersky {

/// From straight down to the optical axis.
[[nodiscard]] Angle off_nadir(const UsedFrame& frame);

struct TrackPoint {
  double time_s = 0.0;
  Eigen::Vector2d easting_northing_m = Eigen::Vector2d::Zero();
};
/// Where the camera was at the used frames, in the order of time.
[[nodiscard]] std::vector<TrackPoint> aircraft_track(const Products& products);

/// Over the used frames; all NaN when there are none.
struct FrameFigures {
  double first_s, last_s;
  double min_height_m, max_height_m;
  double median_gsd_m;
  double max_off_nadir_deg;
};
[[nodiscard]] FrameFigures frame_figures(const Products& products);

}  // namespace watersky
