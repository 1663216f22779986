// SPDX-License-Identifier: MIT
#include "watersky/map/detail/cell_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/map/detail/polygon_span.hpp"

namespace watersky {

CellSampler::CellSampler(const GridView& view, int per_edge)
    : view_(view),
      projection_(view),
      per_edge_(per_edge > 0
                    ? per_edge
                    : std::clamp(static_cast<int>(std::lround(view.pixels_per_cell)), 1, 16)) {
  rolls_ = !view.roll.isZero(0.0);
  // A footprint that ends at the image's edge everywhere needs no distance test a sample.
  limited_ = false;
  for (const Eigen::Vector2d& p : view.footprint) {
    const Eigen::Vector2d ne = (view.sea_from_grid * p.homogeneous()).head<2>();
    if ((ne - view.below_north_east_m).norm() > 0.99 * view.max_distance_m) limited_ = true;
  }
}

CellSampler::Row CellSampler::row(int grid_row) {
  Row row;
  const auto [low, high] = detail::span_between(view_.footprint, grid_row - 0.5, grid_row + 0.5);
  if (!(low <= high)) return row;
  // An outline of finitely many corners cuts the bulges of a distorted edge; a cell's margin
  // covers that, and samples off the image are dropped one by one below.
  const int margin = rolls_ ? 4 : view_.camera.distorts() ? 2 : 0;
  row.first_column =
      std::max(view_.box.first_column, static_cast<int>(std::floor(low + 0.5)) - margin);
  const int end =
      std::min(view_.box.end_column(), static_cast<int>(std::floor(high + 0.5)) + 1 + margin);
  row.columns = std::max(0, end - row.first_column);
  if (row.columns == 0) return row;

  const std::size_t n =
      static_cast<std::size_t>(row.columns) * static_cast<std::size_t>(samples_per_cell());
  if (u_.size() < n) {
    u_.resize(n);
    v_.resize(n);
  }
  const double step = 1.0 / per_edge_;
  for (int j = 0; j < per_edge_; ++j)
    for (int i = 0; i < per_edge_; ++i) {
      const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(j * per_edge_ + i) * row.columns;
      project_line(row.first_column - 0.5 + (i + 0.5) * step, grid_row - 0.5 + (j + 0.5) * step,
                   row.columns, u_.data() + plane, v_.data() + plane);
    }
  row.u = u_.data();
  row.v = v_.data();
  return row;
}

void CellSampler::project_line(double first_x, double y, int count, float* u_out,
                               float* v_out) const {
  const Eigen::Vector3d start = view_.camera_from_grid * Eigen::Vector3d(first_x, y, 1.0);
  const Eigen::Vector3d step = view_.camera_from_grid.col(0);
  const Eigen::Matrix3d& a = view_.camera.camera_matrix();

  if (!rolls_ && !view_.camera.distorts()) {
    // Positions are exact in double and rounded to float: 2^-13 pixel at 4000 pixels.
    const double x0 = start.x(), y0 = start.y(), z0 = start.z();
    const double dx = step.x(), dy = step.y(), dz = step.z();
    const double fu = a(0, 0), fv = a(1, 1), cu = a(0, 2), cv = a(1, 2);
    const auto max_u = static_cast<float>(view_.camera.width_px() - 0.5);
    const auto max_v = static_cast<float>(view_.camera.height_px() - 0.5);
    for (int i = 0; i < count; ++i) {
      const double z = z0 + i * dz, w = 1.0 / z;
      const auto u = static_cast<float>(fu * (x0 + i * dx) * w + cu);
      const auto v = static_cast<float>(fv * (y0 + i * dy) * w + cv);
      // No short circuits: the compiler then turns the loop into vector code.
      const bool seen = (z > 0) & (u >= -0.5F) & (v >= -0.5F) & (u <= max_u) & (v <= max_v);
      u_out[i] = seen ? u : kUnseen;
      v_out[i] = v;
    }
  } else {
    for (int i = 0; i < count; ++i) {
      const auto p = projection_(first_x + i, y);
      const bool seen = p && view_.camera.contains(*p);
      u_out[i] = seen ? static_cast<float>(p->u) : kUnseen;
      v_out[i] = seen ? static_cast<float>(p->v) : 0.0F;
    }
  }
  if (!limited_) return;
  const Eigen::Vector2d sea_start =
      (view_.sea_from_grid * Eigen::Vector3d(first_x, y, 1.0)).head<2>() - view_.below_north_east_m;
  const Eigen::Vector2d sea_step = view_.sea_from_grid.col(0).head<2>();
  const double limit2 = view_.max_distance_m * view_.max_distance_m;
  for (int i = 0; i < count; ++i)
    if (!((sea_start + i * sea_step).squaredNorm() <= limit2)) u_out[i] = kUnseen;
}

}  // namespace watersky
