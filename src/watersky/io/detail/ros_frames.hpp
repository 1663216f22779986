// SPDX-License-Identifier: MIT
#pragma once
/// ROS's conventions (REP 103) and ours: maps are east, north, up there and north, east, down here;
/// bodies forward, left, up there and forward, right, down here. Cameras are the same.
#include <Eigen/Geometry>
#include <cmath>

#include "watersky/geo/rigid3.hpp"

namespace watersky::detail {

/// An exchange of x and y with z reversed: its own inverse.
inline Eigen::Quaterniond ned_from_enu_rotation() {
  return {0.0, std::sqrt(0.5), std::sqrt(0.5), 0.0};
}
/// A half turn about x: its own inverse.
inline Eigen::Quaterniond frd_from_flu_rotation() { return {0.0, 1.0, 0.0, 0.0}; }

/// Positions are exchanged without rounding.
inline Eigen::Vector3d ned_from_enu(const Eigen::Vector3d& p) { return {p.y(), p.x(), -p.z()}; }
inline Eigen::Vector3d enu_from_ned(const Eigen::Vector3d& p) { return ned_from_enu(p); }
inline Eigen::Vector3d frd_from_flu(const Eigen::Vector3d& p) { return {p.x(), -p.y(), -p.z()}; }
inline Eigen::Vector3d flu_from_frd(const Eigen::Vector3d& p) { return frd_from_flu(p); }

}  // namespace watersky::detail
