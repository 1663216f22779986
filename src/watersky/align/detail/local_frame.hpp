// SPDX-License-Identifier: MIT
#pragma once
/// The sea made flat: the frame in which the estimator works.
///
/// A camera is given by the point of the sea below it, its height above that point, and its
/// attitude against the plane of the sea there. `Local` lays those planes side by side: x, y are
/// the point's place in the tangent plane of an origin amid the flight, z is minus the height, and
/// axes are carried along without turning about the vertical. The sea is then z = 0 everywhere.
/// Places are those of an orthographic projection: true to 1e-7 within 3 km, to 3e-5 at 50 km, and
/// alike for all frames of one place, which is what matters.
#include <Eigen/Geometry>
#include <functional>

#include "watersky/flight/flight.hpp"

namespace watersky::align {

/// A platform or camera over the flat sea: local_from_it.
struct LocalPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

class LocalFrame {
 public:
  /// `sea_level` as Flight's; `middle` any place amid the flight.
  LocalFrame(const Datum& datum, SeaLevel sea_level, const Geodetic& middle);

  [[nodiscard]] Result<LocalPose> local(const Rigid3<World, Body>& pose) const;
  [[nodiscard]] Result<Rigid3<World, Body>> world(const LocalPose& pose) const;
  /// Directions in Local to World at the place of a local pose.
  [[nodiscard]] Result<Eigen::Quaterniond> world_from_local_rotation(
      const Eigen::Vector3d& position_m) const;
  /// Directions in north, east, down at a place to Local.
  [[nodiscard]] Eigen::Quaterniond local_from_ned(const Geodetic& place) const;
  /// Where a place lies over the flat sea.
  [[nodiscard]] Result<Eigen::Vector3d> local(const Geodetic& place) const;
  /// The place of a point over the flat sea.
  [[nodiscard]] Result<Geodetic> geodetic(const Eigen::Vector3d& position_m) const;

 private:
  [[nodiscard]] Result<double> sea_height(const Geodetic& place) const;
  Datum datum_;
  SeaLevel sea_level_;
  Rigid3<Ecef, Sea> ecef_from_origin_{Eigen::Quaterniond::Identity(), {}};
};

/// The rotation of an axis-angle vector.
[[nodiscard]] Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& axis_angle);
/// Its inverse, of the shorter way.
[[nodiscard]] Eigen::Vector3d log_rotation(const Eigen::Quaterniond& rotation);

}  // namespace watersky::align
