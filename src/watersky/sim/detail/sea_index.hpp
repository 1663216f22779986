// SPDX-License-Identifier: MIT
#pragma once
/// Answers "which object is at this point" exactly and in constant time.
///
/// The scene is cut into square cells. A cell that no edge touches is all water or all one
/// object. In the others the answer is the object at the cell's centre, changed once for each of
/// that object's edges that the way from the centre to the point crosses; only the edges that
/// touch the cell can be crossed, commonly two or three.
#include <cmath>
#include <cstdint>
#include <vector>

#include "watersky/sim/outline.hpp"

namespace watersky::sim {

class SeaIndex {
 public:
  static constexpr int kWater = -1;

  /// `pieces` are simple and do not overlap; piece i belongs to object `owners[i]` >= 0. They lie
  /// in the rectangle from `south_west` with this extent; outside it is water.
  SeaIndex(const std::vector<Outline>& pieces, const std::vector<int>& owners,
           const Eigen::Vector2d& south_west, const Eigen::Vector2d& extent_m, double cell_m);

  [[nodiscard]] int object_at(double north, double east) const {
    const double row = (north - south_) * cells_per_m_, column = (east - west_) * cells_per_m_;
    if (!(row >= 0.0 && column >= 0.0 && row < rows_ && column < columns_)) return kWater;
    const int r = static_cast<int>(row), c = static_cast<int>(column);
    const std::int32_t cell =
        cells_[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(c)];
    return cell < 0 ? -2 - cell : in_mixed(mixed_[static_cast<std::size_t>(cell)], north, east);
  }

  /// Whether all of a rectangle around a point surely is one object or water: it lies in one cell
  /// without edges. `object` is only set when it does.
  [[nodiscard]] bool same_around(double north, double east, double reach_north, double reach_east,
                                 int& object) const {
    const double row = (north - south_) * cells_per_m_, column = (east - west_) * cells_per_m_;
    if (!(row >= 0.0 && column >= 0.0 && row < rows_ && column < columns_)) return false;
    const int r = static_cast<int>(row), c = static_cast<int>(column);
    const double room_row = 0.5 - std::abs(row - r - 0.5),
                 room_column = 0.5 - std::abs(column - c - 0.5);
    if (room_row < reach_north * cells_per_m_ || room_column < reach_east * cells_per_m_)
      return false;
    const std::int32_t cell =
        cells_[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(c)];
    object = -2 - cell;
    return cell < 0;
  }

 private:
  struct Edge {
    double north0, east0, north1, east1;
    int object;
  };
  struct Mixed {
    double north, east;  ///< the centre
    int object;          ///< at the centre
    std::uint32_t first_edge, edge_count;
  };

  /// Edges are kept sorted by object, so that each object's crossings are counted by themselves.
  [[nodiscard]] int in_mixed(const Mixed& cell, double north, double east) const {
    const double dn = north - cell.north, de = east - cell.east;
    int found = cell.object;
    bool found_is_left = false;
    const Edge* edge = edges_.data() + cell.first_edge;
    const Edge* const end = edge + cell.edge_count;
    while (edge != end) {
      const int object = edge->object;
      bool odd = false;
      for (; edge != end && edge->object == object; ++edge) {
        // The same expression for a corner shared by two edges: both see it on the same side.
        const bool side0 = dn * (edge->east0 - cell.east) - de * (edge->north0 - cell.north) >= 0;
        const bool side1 = dn * (edge->east1 - cell.east) - de * (edge->north1 - cell.north) >= 0;
        if (side0 == side1) continue;
        const double along_n = edge->north1 - edge->north0, along_e = edge->east1 - edge->east0;
        const bool centre =
            along_n * (cell.east - edge->east0) - along_e * (cell.north - edge->north0) >= 0;
        const bool point = along_n * (east - edge->east0) - along_e * (north - edge->north0) >= 0;
        odd ^= centre != point;
      }
      if (!odd) continue;
      if (object == cell.object) {
        found_is_left = true;
      } else {
        return object;
      }
    }
    return found_is_left ? kWater : found;
  }

  double south_, west_, cells_per_m_;
  int rows_, columns_;
  std::vector<std::int32_t> cells_;  ///< >= 0: index into mixed_; otherwise -2 - object
  std::vector<Mixed> mixed_;
  std::vector<Edge> edges_;
};

}  // namespace watersky::sim
