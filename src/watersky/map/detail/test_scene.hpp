// SPDX-License-Identifier: MIT
#pragma once
/// A flat sea with a camera over it, for the map's tests.
#include <gtest/gtest.h>

#include <opencv2/core/mat.hpp>
#include <random>

#include "watersky/geo/rotation.hpp"
#include "watersky/map/algorithm1.hpp"
#include "watersky/map/grid_view.hpp"

namespace watersky::test {

/// A grid whose cell (0, 0) has its north-west corner at (north_m, east_m): neither square nor
/// centred, so that transposes, mirrors and shifts show.
struct FlatGrid {
  double north_m = 37.0;
  double east_m = -61.0;
  double cell_m = 0.5;
  int columns = 260;
  int rows = 170;

  [[nodiscard]] Eigen::Matrix3d sea_from_grid() const {
    Eigen::Matrix3d m;
    m << 0, -cell_m, north_m - 0.5 * cell_m, cell_m, 0, east_m + 0.5 * cell_m, 0, 0, 1;
    return m;
  }
  /// Map in World, where World's north-east-down is Sea's: x east, y south, z down.
  [[nodiscard]] Rigid3<World, Map> world_from_map() const {
    Eigen::Matrix3d r;
    r << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    return {Eigen::Quaterniond(r), Point<World>{{north_m, east_m, 0.0}}};
  }
};

inline CameraModel pinhole(int width = 160, int height = 120, double focal_px = 150.0,
                           std::vector<double> distortion = {}) {
  Eigen::Matrix3d a;
  a << focal_px, 0, 0.5 * width - 3.2, 0, 1.02 * focal_px, 0.5 * height + 1.7, 0, 0, 1;
  return CameraModel::make(LensModel::Pinhole, width, height, a, std::move(distortion)).value();
}

/// The pose in Sea for a camera at a height, turned by gimbal angles (pitch -90: straight down).
inline Rigid3<Sea, Camera> pose(const Eigen::Vector3d& north_east_down_m,
                                const YawPitchRoll& angles) {
  return {camera_rotation(angles), Point<Sea>{north_east_down_m}};
}

inline Rigid3<World, Camera> in_world(const Rigid3<Sea, Camera>& p) {
  return {p.rotation(), Point<World>{p.origin().v}};
}

inline GridView grid_view(const CameraModel& camera, const Rigid3<Sea, Camera>& p,
                          const FlatGrid& grid, Angle min_grazing = Angle::degrees(10)) {
  return make_grid_view(SeaView::make(camera, p, {min_grazing}).value(), grid.sea_from_grid())
      .value();
}

}  // namespace watersky::test
