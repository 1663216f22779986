// SPDX-License-Identifier: MIT
#include <Eigen/LU>

#include "watersky/mapping/mapping.hpp"

namespace watersky {

Eigen::Vector2d MapReference::easting_northing_m(double column, double row) const {
  return {anchor_easting_m + (column + 0.5) * cell_m, anchor_northing_m - (row + 0.5) * cell_m};
}

Eigen::Vector2d MapReference::grid(const Eigen::Vector2d& en) const {
  return {(en.x() - anchor_easting_m) / cell_m - 0.5, (anchor_northing_m - en.y()) / cell_m - 0.5};
}

std::array<double, 6> MapReference::geotransform(const CellBox& box) const {
  return {anchor_easting_m + box.first_column * cell_m, cell_m, 0.0,
          anchor_northing_m - box.first_row * cell_m,   0.0,    -cell_m};
}

Result<Eigen::Matrix3d> MapReference::sea_from_grid(const Geodetic& on_sea) const {
  WATERSKY_TRY(const ProjectedPlace place, projection.at(on_sea));
  // grid metres = place + J (north, east), and (easting, northing) is affine in (c, r).
  const Eigen::Matrix2d north_east_from_grid = place.grid_from_north_east.inverse();
  const Eigen::Vector2d origin = easting_northing_m(0, 0) - place.easting_northing_m;
  Eigen::Matrix2d en_from_cell;
  en_from_cell << cell_m, 0, 0, -cell_m;
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topLeftCorner<2, 2>() = north_east_from_grid * en_from_cell;
  m.topRightCorner<2, 1>() = north_east_from_grid * origin;
  return m;
}

}  // namespace watersky
