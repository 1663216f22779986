// SPDX-License-Identifier: MIT
#include "watersky/map/grid_view.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "watersky/geo/rotation.hpp"

namespace watersky {

CellBox CellBox::united(const CellBox& other) const {
  if (empty()) return other;
  if (other.empty()) return *this;
  CellBox box;
  box.first_column = std::min(first_column, other.first_column);
  box.first_row = std::min(first_row, other.first_row);
  box.columns = std::max(end_column(), other.end_column()) - box.first_column;
  box.rows = std::max(end_row(), other.end_row()) - box.first_row;
  return box;
}

GridView GridView::with(const CameraModel& scaled) const {
  GridView view = *this;
  view.camera = scaled;
  view.pixels_per_cell *= scaled.focal_px() / camera.focal_px();
  return view;
}

Result<GridView> make_grid_view(const SeaView& view, const Eigen::Matrix3d& sea_from_grid,
                                const RollingShutter& shutter) {
  Eigen::Matrix3d plane_from_grid = sea_from_grid;
  plane_from_grid.row(2).setZero();  // the sea is z = 0
  const Rigid3<Camera, Sea> camera_from_sea = view.sea_from_camera().inverse();

  GridView grid{.camera = view.camera(),
                .camera_from_grid =
                    image_from_grid(Eigen::Matrix3d::Identity(), camera_from_sea, plane_from_grid),
                .roll = Eigen::Matrix3d::Zero(),
                .sea_from_grid = sea_from_grid,
                .below_north_east_m = view.sea_from_camera().origin().v.head<2>(),
                .max_distance_m = view.max_distance_m(),
                .footprint = {},
                .box = {},
                .pixels_per_cell = 1.0};

  if (shutter.readout_s > 0) {
    // Of R^T (X - p): a camera that turns by ω and moves by v sees X move by -R^T (ω × (X - p) +
    // v).
    const Eigen::Matrix3d turn = skew(shutter.turn_rate_rad_s);
    Eigen::Matrix3d moved = -turn * plane_from_grid;
    moved.col(2) += turn * view.sea_from_camera().origin().v - shutter.velocity_m_s;
    grid.roll = shutter.readout_s * (camera_from_sea.rotation() * moved);
  }

  const Eigen::Matrix3d grid_from_sea = sea_from_grid.inverse();
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& ne : view.footprint_north_east_m()) {
    const Eigen::Vector2d p = (grid_from_sea * ne.homogeneous()).head<2>();
    grid.footprint.push_back(p);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    nearest_m = std::min(nearest_m, (ne - grid.below_north_east_m).norm());
  }
  constexpr double kMaxIndex = 1e9;
  if (!(low.minCoeff() > -kMaxIndex && high.maxCoeff() < kMaxIndex))
    return Error{
        ErrorCode::OutOfRange,
        "the footprint lies too far from the map's anchor for its cell size; use larger cells"};
  // Cell (c, r) covers [c - ½, c + ½].
  grid.box.first_column = static_cast<int>(std::floor(low.x() + 0.5));
  grid.box.first_row = static_cast<int>(std::floor(low.y() + 0.5));
  grid.box.columns = static_cast<int>(std::floor(high.x() + 0.5)) - grid.box.first_column + 1;
  grid.box.rows = static_cast<int>(std::floor(high.y() + 0.5)) - grid.box.first_row + 1;

  // The finest sampling of the sea in this frame: across the line of sight at its nearest point.
  const auto under =
      view.pixel(Point<Sea>{{grid.below_north_east_m.x(), grid.below_north_east_m.y(), 0.0}});
  if (under && view.camera().contains(*under)) nearest_m = 0.0;
  const double slant_m = std::hypot(nearest_m, view.height_m());
  const double cell_m = std::sqrt(std::abs(sea_from_grid.topLeftCorner<2, 2>().determinant()));
  grid.pixels_per_cell = cell_m * view.camera().focal_px() / slant_m;
  return grid;
}

}  // namespace watersky
