// SPDX-License-Identifier: MIT
#pragma once
/// Floe sizes as they are reported: by number and by area, without the pieces that the border cut.
#include <cstddef>
#include <vector>

#include "watersky/ice/objects.hpp"

namespace watersky::ice {

/// Pieces from `from_m` up to, not including, `to_m` across.
struct SizeBin {
  double from_m = 0.0;
  double to_m = 0.0;
  std::size_t count = 0;
  double area_m2 = 0.0;
};

/// Size is the diameter of the circle of equal area. Means are NaN when `count` is 0.
struct FloeStatistics {
  std::size_t count = 0;        ///< seen whole: what all the figures below are of
  std::size_t cut_by_edge = 0;  ///< left out of them
  double area_m2 = 0.0;
  double mean_diameter_m = 0.0;                ///< each piece counts the same
  double area_weighted_mean_diameter_m = 0.0;  ///< each square metre counts the same
  double mean_length_m = 0.0;                  ///< the same with the largest caliper length
  double area_weighted_mean_length_m = 0.0;
  double largest_length_m = 0.0;
  std::vector<SizeBin> bins;  ///< of the diameter; each a factor √2 wide, none missing between
};

/// Of all objects, iceberg candidates among them: they float like floes.
[[nodiscard]] FloeStatistics floe_statistics(const std::vector<IceObject>& objects);

}  // namespace watersky::ice
