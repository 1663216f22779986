// SPDX-License-Identifier: MIT
#include "watersky/sim/detail/earth.hpp"

#include <cmath>

namespace watersky::sim {
namespace {

constexpr double kSemiMajor_m = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);

double prime_vertical_radius_m(double sin_lat) {
  return kSemiMajor_m / std::sqrt(1.0 - kEccentricity2 * sin_lat * sin_lat);
}

}  // namespace

Eigen::Vector3d earth_centred(const Geodetic& p) {
  const double n = prime_vertical_radius_m(sin(p.latitude));
  const double h = p.height_ellipsoid_m;
  return {(n + h) * cos(p.latitude) * cos(p.longitude),
          (n + h) * cos(p.latitude) * sin(p.longitude),
          (n * (1.0 - kEccentricity2) + h) * sin(p.latitude)};
}

Geodetic geodetic_of(const Eigen::Vector3d& p) {
  const double b = kSemiMajor_m * (1.0 - kFlattening);
  const double second_eccentricity2 = kEccentricity2 / (1.0 - kEccentricity2);
  const double r = std::hypot(p.x(), p.y());
  double reduced = std::atan2(p.z() * kSemiMajor_m, r * b);
  double lat = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double s = std::sin(reduced), c = std::cos(reduced);
    lat = std::atan2(p.z() + second_eccentricity2 * b * s * s * s,
                     r - kEccentricity2 * kSemiMajor_m * c * c * c);
    reduced = std::atan2((1.0 - kFlattening) * std::sin(lat), std::cos(lat));
  }
  const double sin_lat = std::sin(lat), cos_lat = std::cos(lat);
  // This form of the height is well conditioned at the poles and at the equator.
  const double height = r * cos_lat + p.z() * sin_lat -
                        kSemiMajor_m * kSemiMajor_m / prime_vertical_radius_m(sin_lat);
  return {Angle::radians(lat), Angle::radians(std::atan2(p.y(), p.x())), height};
}

Eigen::Matrix3d north_east_down(const Geodetic& p) {
  const Eigen::Vector3d up(cos(p.latitude) * cos(p.longitude), cos(p.latitude) * sin(p.longitude),
                           sin(p.latitude));
  const Eigen::Vector3d east(-sin(p.longitude), cos(p.longitude), 0.0);
  Eigen::Matrix3d axes;
  axes << up.cross(east), east, -up;
  return axes;
}

SeaSurface::SeaSurface(const Geodetic& anchor)
    : origin_(earth_centred(anchor)), axes_(north_east_down(anchor)) {
  const double n = prime_vertical_radius_m(sin(anchor.latitude));
  const double m = n * n * n * (1.0 - kEccentricity2) / (kSemiMajor_m * kSemiMajor_m);
  half_curvature_north_ = 0.5 / (m + anchor.height_ellipsoid_m);
  half_curvature_east_ = 0.5 / (n + anchor.height_ellipsoid_m);
}

Eigen::Vector3d SeaSurface::above(double north_m, double east_m, double height_m) const {
  const Eigen::Vector3d foot(north_m, east_m, down_m(north_m, east_m));
  const Eigen::Vector3d up(2.0 * half_curvature_north_ * north_m,
                           2.0 * half_curvature_east_ * east_m, -1.0);
  return origin_ + axes_ * (foot + height_m * up.normalized());
}

}  // namespace watersky::sim
