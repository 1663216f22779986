// SPDX-License-Identifier: MIT
#include "watersky/flight/known_points.hpp"

#include <algorithm>
#include <cmath>

namespace watersky {

Result<AnchorPlace> Anchor::at(Time time) const {
  if (place) return *place;
  constexpr Duration kMostGap = std::chrono::minutes(10);
  const auto after = std::lower_bound(track.begin(), track.end(), time,
                                      [](const AnchorFix& f, Time t) { return f.time < t; });
  if (after != track.end() && after->time == time) return after->place;
  if (after == track.begin() || after == track.end())
    return Error{ErrorCode::OutOfRange, name + ": its positions do not reach to that time"};
  const AnchorFix &a = *(after - 1), &b = *after;
  if (b.time - a.time > kMostGap)
    return Error{ErrorCode::OutOfRange,
                 name + ": its positions are more than ten minutes apart at that time"};
  const double f = to_seconds(time - a.time) / to_seconds(b.time - a.time);
  AnchorPlace out = a.place;
  out.latitude = Angle::degrees(a.place.latitude.degrees() +
                                f * (b.place.latitude.degrees() - a.place.latitude.degrees()));
  // The shorter way: it may cross the date line.
  out.longitude = Angle::degrees(
      a.place.longitude.degrees() +
      f * std::remainder(b.place.longitude.degrees() - a.place.longitude.degrees(), 360.0));
  out.height_m += f * (b.place.height_m - a.place.height_m);
  return out;
}

}  // namespace watersky
