// SPDX-License-Identifier: MIT
#include "watersky/products/frame_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace watersky {

Angle off_nadir(const UsedFrame& frame) {
  return Angle::radians(std::acos(std::clamp(frame.optical_axis.z(), -1.0, 1.0)));
}

std::vector<TrackPoint> aircraft_track(const Products& products) {
  std::vector<TrackPoint> track;
  for (const UsedFrame& frame : products.used) {
    const auto place = products.projection.forward(frame.camera.latitude, frame.camera.longitude);
    if (place) track.push_back({to_seconds(frame.time), *place});
  }
  std::stable_sort(track.begin(), track.end(),
                   [](const TrackPoint& a, const TrackPoint& b) { return a.time_s < b.time_s; });
  return track;
}

FrameFigures frame_figures(const Products& products) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  FrameFigures f{kNone, kNone, kNone, kNone, kNone, kNone};
  std::vector<double> gsd_m;
  for (const UsedFrame& frame : products.used) {
    const double time_s = to_seconds(frame.time);
    // fmin and fmax take the other number when one is NaN.
    f.first_s = std::fmin(f.first_s, time_s);
    f.last_s = std::fmax(f.last_s, time_s);
    f.min_height_m = std::fmin(f.min_height_m, frame.height_above_sea_m);
    f.max_height_m = std::fmax(f.max_height_m, frame.height_above_sea_m);
    f.max_off_nadir_deg = std::fmax(f.max_off_nadir_deg, off_nadir(frame).degrees());
    gsd_m.push_back(frame.gsd_m);
  }
  if (!gsd_m.empty()) {
    const auto middle = gsd_m.begin() + static_cast<std::ptrdiff_t>(gsd_m.size() / 2);
    std::nth_element(gsd_m.begin(), middle, gsd_m.end());
    f.median_gsd_m = *middle;
  }
  return f;
}

}  // namespace watersky
