// SPDX-License-Identifier: MIT
#pragma once
/// WGS-84 and the local frames that stand on it (section 3.3.3 of the thesis, both ways).
#include "watersky/base/angle.hpp"
#include "watersky/geo/rigid3.hpp"

namespace watersky {

/// A position on WGS-84. The height is above the ellipsoid, never above a geoid.
struct Geodetic {
  Angle latitude;
  Angle longitude;
  double height_ellipsoid_m = 0.0;
};

/// Exact to a few nanometres near the Earth (GeographicLib).
[[nodiscard]] Point<Ecef> ecef_from(const Geodetic& position);
[[nodiscard]] Geodetic geodetic_from(const Point<Ecef>& position);

/// Directions in north, east, down at a place, seen in ECEF.
[[nodiscard]] Eigen::Quaterniond ecef_from_ned_rotation(Angle latitude, Angle longitude);

/// The Sea frame at a place: north, east, down with its origin at `on_sea`.
[[nodiscard]] Rigid3<Ecef, Sea> ecef_from_sea(const Geodetic& on_sea);

/// Where World stands on the Earth: north, east, down at an origin, or turned about down so that
/// the first axis points along `x_azimuth` (clockwise from north; a room is seldom north-up).
class Datum {
 public:
  Datum() : Datum(Geodetic{}) {}
  explicit Datum(const Geodetic& origin, Angle x_azimuth = {});

  [[nodiscard]] const Geodetic& origin() const { return origin_; }
  [[nodiscard]] Angle x_azimuth() const { return x_azimuth_; }
  [[nodiscard]] const Rigid3<Ecef, World>& ecef_from_world() const { return ecef_from_world_; }

  [[nodiscard]] Geodetic geodetic(const Point<World>& p_world) const;
  [[nodiscard]] Point<World> world(const Geodetic& position) const;
  /// Directions in north, east, down at `position` seen in World. Away from the datum these are
  /// not World's axes: the meridians converge (1.8° over 40 km at 79 N) and the Earth is round.
  [[nodiscard]] Eigen::Quaterniond world_from_ned_rotation(const Geodetic& position) const;

 private:
  Geodetic origin_;
  Angle x_azimuth_;
  Rigid3<Ecef, World> ecef_from_world_;
};

}  // namespace watersky
