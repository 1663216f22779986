// SPDX-License-Identifier: MIT
#pragma once
/// The simulator's own WGS-84, written from the textbook formulas and sharing nothing with
/// geodesy/: a fault in either shows as a disagreement between map and truth.
#include <Eigen/Core>

#include "watersky/geodesy/wgs84.hpp"

namespace watersky::sim {

[[nodiscard]] Eigen::Vector3d earth_centred(const Geodetic& position);
/// Bowring's formula, iterated: below 1e-9 m for heights from -10 to 100 km.
[[nodiscard]] Geodetic geodetic_of(const Eigen::Vector3d& earth_centred);
/// Columns: north, east, down in earth-centred axes.
[[nodiscard]] Eigen::Matrix3d north_east_down(const Geodetic& position);

/// The sea around an anchor: a surface of constant ellipsoidal height, in the anchor's north,
/// east, down axes approximated by its paraboloid down = n²/2(M+h) + e²/2(N+h). Against the
/// ellipsoid that is 1 mm off at 2 km and 2 cm at 5 km in height, and nowhere more sideways
/// than that times the tilt of the surface (1/1000 at 6 km).
class SeaSurface {
 public:
  explicit SeaSurface(const Geodetic& anchor);

  [[nodiscard]] double down_m(double north_m, double east_m) const {
    return north_m * north_m * half_curvature_north_ + east_m * east_m * half_curvature_east_;
  }
  [[nodiscard]] double half_curvature_north() const { return half_curvature_north_; }
  [[nodiscard]] double half_curvature_east() const { return half_curvature_east_; }

  /// Earth-centred position `height_m` above the sea at (north, east) of the anchor's axes.
  [[nodiscard]] Eigen::Vector3d above(double north_m, double east_m, double height_m) const;
  [[nodiscard]] const Eigen::Matrix3d& axes() const { return axes_; }
  [[nodiscard]] const Eigen::Vector3d& origin() const { return origin_; }

 private:
  Eigen::Vector3d origin_;
  Eigen::Matrix3d axes_;
  double half_curvature_north_ = 0.0;
  double half_curvature_east_ = 0.0;
};

}  // namespace watersky::sim
