// SPDX-License-Identifier: MIT
#pragma once
/// A camera as the grid sees it: which cells it sees, and where each falls in its image.
#include <Eigen/Core>
#include <limits>
#include <vector>

#include "watersky/camera/sea_plane.hpp"

namespace watersky {

/// A rectangle of cells: columns along map x (east), rows along map y (south).
struct CellBox {
  int first_column = 0;
  int first_row = 0;
  int columns = 0;
  int rows = 0;

  [[nodiscard]] bool empty() const { return columns <= 0 || rows <= 0; }
  [[nodiscard]] int end_column() const { return first_column + columns; }
  [[nodiscard]] int end_row() const { return first_row + rows; }
  /// The smallest box that holds both.
  [[nodiscard]] CellBox united(const CellBox& other) const;
  bool operator==(const CellBox&) const = default;
};

/// One frame's view of the grid. Grid positions are continuous: the centre of cell (c, r) is
/// (c, r), its corners lie half a cell around it, as P_m^w of (2.34) has it.
struct GridView {
  CameraModel camera;
  /// R P + [0 0 t] of (2.35), without A: takes (c, r, 1) to a direction in the camera frame.
  Eigen::Matrix3d camera_from_grid = Eigen::Matrix3d::Identity();
  /// How camera_from_grid changes from the first row of a rolling shutter to its last; zero: not.
  Eigen::Matrix3d roll = Eigen::Matrix3d::Zero();
  /// sea_from_grid takes (c, r, 1) to (north, east, 1): its inverse and the grazing limit.
  Eigen::Matrix3d sea_from_grid = Eigen::Matrix3d::Identity();
  Eigen::Vector2d below_north_east_m = Eigen::Vector2d::Zero();  ///< under the camera, in Sea
  double max_distance_m = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Vector2d> footprint;  ///< grid positions
  CellBox box;                             ///< of all cells the footprint touches
  double pixels_per_cell = 1.0;            ///< along one edge, at the middle of the image

  /// The same view in an image of another size: `scaled` is this view's camera, scaled.
  [[nodiscard]] GridView with(const CameraModel& scaled) const;
};

/// `sea_from_grid` is affine: (c, r, 1) to (north, east, 1) in the view's Sea frame. The footprint
/// is that of the middle row's pose. OutOfRange when the footprint would leave the range of cell
/// indices (±10^9).
[[nodiscard]] Result<GridView> make_grid_view(const SeaView& view,
                                              const Eigen::Matrix3d& sea_from_grid,
                                              const RollingShutter& shutter = {});

}  // namespace watersky
