// SPDX-License-Identifier: MIT
#pragma once
/// Where a position of the grid falls in the image of a view: the exact answer, for every lens and
/// every shutter.
#include <optional>

#include "watersky/map/grid_view.hpp"

namespace watersky::detail {

class CellProjection {
 public:
  explicit CellProjection(const GridView& view);

  /// nullopt where the lens does not look. The pixel may lie outside the image.
  [[nodiscard]] std::optional<Pixel> operator()(double column, double row) const {
    if (rolls_) return rolling(column, row);
    const Eigen::Vector3d d = middle_.col(0) * column + middle_.col(1) * row + middle_.col(2);
    if (distorts_) return view_.camera.project(Vector<Camera>{d});
    if (!(d.z() > 0)) return std::nullopt;
    const double w = 1.0 / d.z();
    return Pixel{fu_ * d.x() * w + cu_, fv_ * d.y() * w + cv_};
  }

 private:
  [[nodiscard]] std::optional<Pixel> rolling(double column, double row) const;

  const GridView& view_;
  Eigen::Matrix3d middle_;
  bool rolls_, distorts_;
  double fu_, fv_, cu_, cv_;
};

}  // namespace watersky::detail
