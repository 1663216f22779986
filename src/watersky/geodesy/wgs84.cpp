// SPDX-License-Identifier: MIT
#include "watersky/geodesy/wgs84.hpp"

#include <GeographicLib/Geocentric.hpp>

#include "watersky/geo/rotation.hpp"

namespace watersky {

Point<Ecef> ecef_from(const Geodetic& position) {
  Point<Ecef> p;
  GeographicLib::Geocentric::WGS84().Forward(
      position.latitude.degrees(), position.longitude.degrees(), position.height_ellipsoid_m,
      p.v.x(), p.v.y(), p.v.z());
  return p;
}

Geodetic geodetic_from(const Point<Ecef>& p) {
  double lat_deg = 0, lon_deg = 0, height_m = 0;
  GeographicLib::Geocentric::WGS84().Reverse(p.v.x(), p.v.y(), p.v.z(), lat_deg, lon_deg, height_m);
  return {Angle::degrees(lat_deg), Angle::degrees(lon_deg), height_m};
}

Eigen::Quaterniond ecef_from_ned_rotation(Angle latitude, Angle longitude) {
  const double sin_lat = sin(latitude), cos_lat = cos(latitude);
  const double sin_lon = sin(longitude), cos_lon = cos(longitude);
  Eigen::Matrix3d r;                                      // columns: north, east, down in ECEF
  r << -sin_lat * cos_lon, -sin_lon, -cos_lat * cos_lon,  //
      -sin_lat * sin_lon, cos_lon, -cos_lat * sin_lon,    //
      cos_lat, 0.0, -sin_lat;
  return Eigen::Quaterniond(r);
}

Rigid3<Ecef, Sea> ecef_from_sea(const Geodetic& on_sea) {
  return {ecef_from_ned_rotation(on_sea.latitude, on_sea.longitude), ecef_from(on_sea)};
}

Datum::Datum(const Geodetic& origin, Angle x_azimuth)
    : origin_(origin),
      x_azimuth_(x_azimuth),
      ecef_from_world_(
          ecef_from_ned_rotation(origin.latitude, origin.longitude) * heading(x_azimuth),
          ecef_from(origin)) {}

Geodetic Datum::geodetic(const Point<World>& p_world) const {
  return geodetic_from(ecef_from_world_ * p_world);
}

Point<World> Datum::world(const Geodetic& position) const {
  return ecef_from_world_.inverse() * ecef_from(position);
}

Eigen::Quaterniond Datum::world_from_ned_rotation(const Geodetic& position) const {
  return ecef_from_world_.rotation().conjugate() *
         ecef_from_ned_rotation(position.latitude, position.longitude);
}

}  // namespace watersky
