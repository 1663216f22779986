// SPDX-License-Identifier: MIT
#pragma once
/// Areas of the earth's surface.
#include <Eigen/Core>
#include <vector>

namespace watersky {

/// Rings of longitude, latitude [deg] on WGS-84, the first point not repeated. A place within an
/// odd number of rings is inside: an outline and its holes, in any order and sense. Edges are
/// straight in the map's projection; a ring across the 180th meridian is not understood.
struct GeoPolygon {
  std::vector<std::vector<Eigen::Vector2d>> rings_lon_lat_deg;
};

}  // namespace watersky
