// SPDX-License-Identifier: MIT
#pragma once
/// Metric map projections (PROJ), and how they lie against the ground at one place.
#include <Eigen/Core>
#include <memory>
#include <string>

#include "watersky/base/result.hpp"
#include "watersky/geodesy/wgs84.hpp"

namespace watersky {

/// A projection seen from one place: grid metres are not north-east metres. Over 1 km the
/// neglected curvature of a UTM zone is below 3 mm.
struct ProjectedPlace {
  Eigen::Vector2d easting_northing_m = Eigen::Vector2d::Zero();
  /// Grid (easting, northing) per metre (north, east) on the ellipsoid: rotation by the
  /// convergence times the scale, for a conformal projection.
  Eigen::Matrix2d grid_from_north_east = Eigen::Matrix2d::Identity();

  /// From true north to grid north, clockwise positive (grid north lies east of true north).
  /// UTM 33 at 78.9 N 11.9 E: -3.0°.
  [[nodiscard]] Angle convergence() const;
  /// Grid metres per metre along the meridian.
  [[nodiscard]] double scale() const;
};

/// A projected coordinate system on WGS-84 in metres, easting first. Copies share their PROJ
/// object; calls on it are serialised.
class Projection {
 public:
  /// From "EPSG:32633", a PROJ string or WKT. Refuses geographic systems, and units other than
  /// the metre.
  [[nodiscard]] static Result<Projection> from_text(const std::string& crs);
  /// The UTM zone of a place, with the exceptions for Norway and Svalbard; beyond 84 N the NSIDC
  /// polar stereographic grid (EPSG:3413), beyond 80 S EPSG:3031.
  [[nodiscard]] static Result<Projection> for_place(const Geodetic& place);

  /// "EPSG:32633", or the text it was made from.
  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] const std::string& wkt() const;

  [[nodiscard]] Result<Eigen::Vector2d> forward(Angle latitude, Angle longitude) const;
  /// Height 0 is filled in.
  [[nodiscard]] Result<Geodetic> inverse(const Eigen::Vector2d& easting_northing_m) const;
  /// With metres measured at the place's own height.
  [[nodiscard]] Result<ProjectedPlace> at(const Geodetic& place) const;

 private:
  struct Impl;
  explicit Projection(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

/// The height of the EGM96 geoid (mean sea level) above the ellipsoid, from the 15' grid of
/// Debian's proj-data. NotFound, naming the package, when the grid is not installed.
[[nodiscard]] Result<double> egm96_above_ellipsoid_m(Angle latitude, Angle longitude);

}  // namespace watersky
