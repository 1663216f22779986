// SPDX-License-Identifier: MIT
#include "watersky/align/detail/local_frame.hpp"

#include <cmath>

namespace watersky::align {

Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const double scale = angle < 1e-9 ? 0.5 : std::sin(0.5 * angle) / angle;
  return Eigen::Quaterniond(std::cos(0.5 * angle), scale * w.x(), scale * w.y(), scale * w.z())
      .normalized();
}

Eigen::Vector3d log_rotation(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  const double sine = rotation.vec().norm();
  if (sine < 1e-12) return 2.0 * sign * rotation.vec();
  return 2.0 * std::atan2(sine, sign * rotation.w()) / sine * sign * rotation.vec();
}

LocalFrame::LocalFrame(const Datum& datum, SeaLevel sea_level, const Geodetic& middle)
    : datum_(datum), sea_level_(std::move(sea_level)) {
  Geodetic origin = middle;
  origin.height_ellipsoid_m = 0.0;
  // The height of the origin plays no part but for scale, 1e-7 a metre: that of the sea.
  if (const auto height = sea_height(middle)) origin.height_ellipsoid_m = *height;
  ecef_from_origin_ = ecef_from_sea(origin);
}

Result<double> LocalFrame::sea_height(const Geodetic& place) const {
  WATERSKY_TRY(const double height_m, sea_level_.height_ellipsoid_m(place));
  if (!std::isfinite(height_m))
    return Error{ErrorCode::NotFound, "the height of the sea is not a number"};
  return height_m;
}

Eigen::Quaterniond LocalFrame::local_from_ned(const Geodetic& place) const {
  const Eigen::Quaterniond tilted = ecef_from_origin_.rotation().conjugate() *
                                    ecef_from_ned_rotation(place.latitude, place.longitude);
  const Eigen::Vector3d down = tilted * Eigen::Vector3d::UnitZ();
  return Eigen::Quaterniond::FromTwoVectors(down, Eigen::Vector3d::UnitZ()) * tilted;
}

Result<Eigen::Vector3d> LocalFrame::local(const Geodetic& place) const {
  WATERSKY_TRY(const double sea_m, sea_height(place));
  const Geodetic below{place.latitude, place.longitude, sea_m};
  const Eigen::Vector3d p = (ecef_from_origin_.inverse() * ecef_from(below)).v;
  return Eigen::Vector3d(p.x(), p.y(), sea_m - place.height_ellipsoid_m);
}

Result<Geodetic> LocalFrame::geodetic(const Eigen::Vector3d& position_m) const {
  // The point of the sea with this x and y; heights change with place slowly, so this settles.
  double z = 0.5 * position_m.head<2>().squaredNorm() / 6.37e6;
  Geodetic place;
  for (int i = 0; i < 5; ++i) {
    const Point<Sea> p{{position_m.x(), position_m.y(), z}};
    const Point<Ecef> ecef = ecef_from_origin_ * p;
    if (!ecef.v.allFinite())
      return Error{ErrorCode::OutOfRange, "a place on the sea is not a number"};
    place = geodetic_from(ecef);
    WATERSKY_TRY(const double sea_m, sea_height(place));
    z += place.height_ellipsoid_m - sea_m;
    place.height_ellipsoid_m = sea_m;
  }
  place.height_ellipsoid_m -= position_m.z();
  return place;
}

Result<LocalPose> LocalFrame::local(const Rigid3<World, Body>& pose) const {
  const Geodetic place = datum_.geodetic(pose.origin());
  WATERSKY_TRY(const Eigen::Vector3d position_m, local(place));
  const Eigen::Quaterniond ned_from_world = datum_.world_from_ned_rotation(place).conjugate();
  return LocalPose{local_from_ned(place) * ned_from_world * pose.rotation(), position_m};
}

Result<Eigen::Quaterniond> LocalFrame::world_from_local_rotation(
    const Eigen::Vector3d& position_m) const {
  WATERSKY_TRY(const Geodetic place, geodetic(position_m));
  return datum_.world_from_ned_rotation(place) * local_from_ned(place).conjugate();
}

Result<Rigid3<World, Body>> LocalFrame::world(const LocalPose& pose) const {
  WATERSKY_TRY(const Geodetic place, geodetic(pose.position_m));
  const Eigen::Quaterniond world_from_local =
      datum_.world_from_ned_rotation(place) * local_from_ned(place).conjugate();
  return Rigid3<World, Body>(world_from_local * pose.rotation, datum_.world(place));
}

}  // namespace watersky::align
