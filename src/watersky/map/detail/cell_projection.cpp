// SPDX-License-Identifier: MIT
#include "watersky/map/detail/cell_projection.hpp"

#include <algorithm>

namespace watersky::detail {

CellProjection::CellProjection(const GridView& view)
    : view_(view),
      middle_(view.camera_from_grid),
      rolls_(!view.roll.isZero(0.0)),
      distorts_(view.camera.distorts()),
      fu_(view.camera.camera_matrix()(0, 0)),
      fv_(view.camera.camera_matrix()(1, 1)),
      cu_(view.camera.camera_matrix()(0, 2)),
      cv_(view.camera.camera_matrix()(1, 2)) {}

/// Which row sees a place depends on where the place is seen: from the middle row's pose on, each
/// round comes nearer by the share of a row that the picture moves while one is read.
std::optional<Pixel> CellProjection::rolling(double column, double row) const {
  constexpr int kRounds = 3;
  const Eigen::Vector3d at(column, row, 1.0);
  const Eigen::Vector3d middle = middle_ * at, roll = view_.roll * at;
  const double rows = view_.camera.height_px();
  auto p = view_.camera.project(Vector<Camera>{middle});
  for (int round = 0; round < kRounds && p; ++round) {
    // Beyond the image a little, so that nothing bends at its edge.
    const double share = std::clamp((p->v + 0.5) / rows - 0.5, -1.0, 1.0);
    p = view_.camera.project(Vector<Camera>{middle + share * roll});
  }
  return p;
}

}  // namespace watersky::detail
