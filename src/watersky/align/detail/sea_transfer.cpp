// SPDX-License-Identifier: MIT
#include "watersky/align/detail/sea_transfer.hpp"

#include "watersky/geo/rotation.hpp"

namespace watersky::align {

namespace {

/// Of a ray's down over its length: flatter than 3° it says nothing, and its derivatives explode.
constexpr double kFlattest = 0.05;
/// In front of a camera, along its axis.
constexpr double kNearest_m = 1e-6;

/// A point seen by a camera: direction over z, and derivatives.
struct Seen {
  Eigen::Vector2d at;
  Eigen::Matrix<double, 2, 3> by_point;
  Matrix26 by_camera;
};

std::optional<Seen> see(const ModelCamera& camera, const Eigen::Vector3d& point) {
  const Eigen::Vector3d from = point - camera.position_m;
  const Eigen::Matrix3d camera_from_local = camera.rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d y = camera_from_local * from;
  if (!(y.z() > kNearest_m)) return std::nullopt;
  Seen seen;
  seen.at = y.hnormalized();
  Eigen::Matrix<double, 2, 3> divide;
  divide << 1, 0, -seen.at.x(), 0, 1, -seen.at.y();
  seen.by_point = divide / y.z() * camera_from_local;
  seen.by_camera.leftCols<3>() = -seen.by_point;
  seen.by_camera.rightCols<3>() = seen.by_point * skew(from);
  return seen;
}

}  // namespace

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& w) {
  return Eigen::Matrix3d::Identity() + 0.5 * skew(w);
}

std::optional<SeaHit> hit_sea(const ModelCamera& camera, const Eigen::Vector3d& direction) {
  SeaHit hit;
  hit.ray = camera.rotation * direction;
  if (!(hit.ray.z() > kFlattest * hit.ray.norm()) || !(camera.position_m.z() < 0))
    return std::nullopt;
  const double along = -camera.position_m.z() / hit.ray.z();
  hit.at = camera.position_m + along * hit.ray;
  hit.by_position = Eigen::Matrix3d::Identity();
  hit.by_position.col(2) -= hit.ray / hit.ray.z();
  hit.by_direction = along * hit.by_position;
  return hit;
}

Eigen::Vector3d with_focal(const Eigen::Vector2d& direction, double focal_scale) {
  return (direction / (1.0 + focal_scale)).homogeneous();
}

std::optional<Eigen::Vector2d> sea_under(const ModelCamera& camera,
                                         const Eigen::Vector3d& direction) {
  const Eigen::Vector3d ray = camera.rotation * direction;
  if (!(ray.z() > kFlattest * ray.norm()) || !(camera.position_m.z() < 0)) return std::nullopt;
  return (camera.position_m - camera.position_m.z() / ray.z() * ray).head<2>();
}

std::optional<Eigen::Vector2d> sent(const ModelCamera& host, const ModelCamera& frame,
                                    const Eigen::Vector2d& host_direction, double focal_scale,
                                    const Eigen::Vector2d& moved_m) {
  const auto place = sea_under(host, with_focal(host_direction, focal_scale));
  if (!place) return std::nullopt;
  Eigen::Vector3d point;
  point << *place + moved_m, 0.0;
  const Eigen::Vector3d y = frame.rotation.conjugate() * (point - frame.position_m);
  if (!(y.z() > kNearest_m)) return std::nullopt;
  return y.hnormalized();
}

std::optional<Transfer> transfer(const ModelCamera& host, const ModelCamera& frame,
                                 const Eigen::Vector2d& host_direction,
                                 const Eigen::Vector2d& frame_direction, double focal_scale,
                                 const Eigen::Vector2d& drift_m_s, double elapsed_s) {
  const Eigen::Vector3d direction = with_focal(host_direction, focal_scale);
  const auto hit = hit_sea(host, direction);
  if (!hit) return std::nullopt;
  Eigen::Vector3d point = hit->at;
  point.head<2>() += elapsed_s * drift_m_s;
  const auto seen = see(frame, point);
  if (!seen) return std::nullopt;
  Transfer t;
  t.residual = (1.0 + focal_scale) * seen->at - frame_direction;
  const double scale = 1.0 + focal_scale;
  const Eigen::Matrix<double, 2, 3> by_point = scale * seen->by_point;
  t.by_host.leftCols<3>() = by_point * hit->by_position;
  t.by_host.rightCols<3>() = -by_point * hit->by_direction * skew(hit->ray);
  t.by_frame = scale * seen->by_camera;
  const Eigen::Vector3d ray_by_focal =
      host.rotation * Eigen::Vector3d(-host_direction.x() / (scale * scale),
                                      -host_direction.y() / (scale * scale), 0.0);
  t.by_focal = seen->at + by_point * hit->by_direction * ray_by_focal;
  t.by_drift = elapsed_s * by_point.leftCols<2>();
  return t;
}

std::optional<SeenKnown> see_known_point(const ModelCamera& camera, const KnownPoint& known,
                                         double focal_scale, double t_s) {
  const auto seen = see(camera, known.point_m + (t_s - known.at_s) * known.velocity_m_s);
  if (!seen) return std::nullopt;
  const double scale = 1.0 + focal_scale;
  return SeenKnown{scale * seen->at - known.direction, scale * seen->by_point,
                   scale * seen->by_camera, seen->at};
}

}  // namespace watersky::align
