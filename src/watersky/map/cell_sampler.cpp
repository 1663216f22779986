// SPDX-License-Identifier: MIT
#include "watersky/map/detail/cell_sampler.hpp"

#include <algorithm>
#include <cmath>

namespace watersky {

namespace {

/// The columns that a closed polygon covers between two values of y.
std::pair<double, double> span_between(const std::vector<Eigen::Vector2d>& polygon, double y0, double y1) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double from = std::max(y0, std::min(a.y(), b.y()));
    const double to = std::min(y1, std::max(a.y(), b.y()));
    if (from > to) continue;
    const double dy = b.y() - a.y();
    for (const double y : {from, to}) {
      const double t = dy == 0 ? 0.0 : (y - a.y()) / dy;
      const double x = a.x() + t * (b.x() - a.x());
      low = std::min(low, x);
      high = std::max(high, x);
    }
    if (dy == 0) {
      low = std::min(low, b.x());
      high = std::max(high, b.x());
    }
  }
  return {low, high};
}

}  // namespace

CellSampler::CellSampler(const GridView& view, int per_edge)
    : view_(view),
      per_edge_(per_edge > 0 ? per_edge
                             : std::clamp(static_cast<int>(std::ceil(view.pixels_per_cell - 1e-6)), 1, 16)) {
  // A footprint that ends at the image's edge everywhere needs no distance test a sample.
  limited_ = false;
  for (const Eigen::Vector2d& p : view.footprint) {
    const Eigen::Vector2d ne = (view.sea_from_grid * p.homogeneous()).head<2>();
    if ((ne - view.below_north_east_m).norm() > 0.99 * view.max_distance_m) limited_ = true;
  }
}

CellSampler::Row CellSampler::row(int grid_row) {
  Row row;
  const auto [low, high] = span_between(view_.footprint, grid_row - 0.5, grid_row + 0.5);
  if (!(low <= high)) return row;
  // An outline of finitely many corners cuts the bulges of a distorted edge; a cell's margin
  // covers that, and samples off the image are dropped one by one below.
  const int margin = view_.camera.distorts() ? 2 : 0;
  row.first_column = std::max(view_.box.first_column, static_cast<int>(std::floor(low + 0.5)) - margin);
  const int end = std::min(view_.box.end_column(), static_cast<int>(std::floor(high + 0.5)) + 1 + margin);
  row.columns = std::max(0, end - row.first_column);
  if (row.columns == 0) return row;

  const std::size_t n = static_cast<std::size_t>(row.columns) * static_cast<std::size_t>(samples_per_cell());
  if (u_.size() < n) {
    u_.resize(n);
    v_.resize(n);
  }
  const double step = 1.0 / per_edge_;
  for (int j = 0; j < per_edge_; ++j)
    for (int i = 0; i < per_edge_; ++i)
      project_line(row.first_column - 0.5 + (i + 0.5) * step, 1.0, grid_row - 0.5 + (j + 0.5) * step,
                   row.columns, j * per_edge_ + i, samples_per_cell());
  row.u = u_.data();
  row.v = v_.data();
  return row;
}

void CellSampler::project_line(double first_x, double step_x, double y, int count, int offset, int stride) {
  const Eigen::Vector3d start = view_.camera_from_grid * Eigen::Vector3d(first_x, y, 1.0);
  const Eigen::Vector3d step = view_.camera_from_grid.col(0) * step_x;
  const Eigen::Matrix3d& a = view_.camera.camera_matrix();
  const double max_u = view_.camera.width_px() - 0.5, max_v = view_.camera.height_px() - 0.5;
  float* u_out = u_.data() + offset;
  float* v_out = v_.data() + offset;

  if (!view_.camera.distorts()) {
    const double fu = a(0, 0), fv = a(1, 1), cu = a(0, 2), cv = a(1, 2);
    for (int i = 0; i < count; ++i) {
      const double x = start.x() + i * step.x(), yy = start.y() + i * step.y(), z = start.z() + i * step.z();
      const double w = 1.0 / z;
      const double u = fu * x * w + cu, v = fv * yy * w + cv;
      const bool seen = z > 0 && u >= -0.5 && v >= -0.5 && u <= max_u && v <= max_v;
      u_out[i * stride] = seen ? static_cast<float>(u) : kUnseen;
      v_out[i * stride] = seen ? static_cast<float>(v) : kUnseen;
    }
  } else {
    for (int i = 0; i < count; ++i) {
      const auto p = view_.camera.project(Vector<Camera>{start + i * step});
      const bool seen = p && view_.camera.contains(*p);
      u_out[i * stride] = seen ? static_cast<float>(p->u) : kUnseen;
      v_out[i * stride] = seen ? static_cast<float>(p->v) : kUnseen;
    }
  }
  if (!limited_) return;
  const Eigen::Vector2d sea_start =
      (view_.sea_from_grid * Eigen::Vector3d(first_x, y, 1.0)).head<2>() - view_.below_north_east_m;
  const Eigen::Vector2d sea_step = view_.sea_from_grid.col(0).head<2>() * step_x;
  const double limit2 = view_.max_distance_m * view_.max_distance_m;
  for (int i = 0; i < count; ++i)
    if (!((sea_start + i * sea_step).squaredNorm() <= limit2)) u_out[i * stride] = kUnseen;
}

}  // namespace watersky
