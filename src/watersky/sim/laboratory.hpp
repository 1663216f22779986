// SPDX-License-Identifier: MIT
#pragma once
/// The thesis's laboratory (4.1.1): eight patches of white paper on a dark floor.
#include <array>

#include "watersky/sim/sea.hpp"

namespace watersky::sim {

/// A row of Table 4.1. The motion capture's frame has z up and y to the left of x: in World, down
/// and to the right, the place is (x, -y).
struct PaperPatch {
  int number;
  double x_m, y_m;
  double inscribed_radius_m;
};

/// Table 4.1. A mirror image of the layout, turned and moved as one likes, leaves at least one
/// patch 0.15 m from the nearest of these (searched in the test), so a mirrored room cannot pass
/// for this one.
inline constexpr std::array<PaperPatch, 8> kPaperPatches{{{1, -1.068, 2.615, 0.03},
                                                          {2, -0.800, 1.824, 0.03},
                                                          {3, -1.316, 1.593, 0.04},
                                                          {4, 0.101, 1.316, 0.04},
                                                          {5, -0.332, 1.026, 0.045},
                                                          {6, -0.022, 2.069, 0.08},
                                                          {7, -0.557, 2.399, 0.065},
                                                          {8, -1.129, 0.626, 0.05}}};

/// The middle of the patches in World's axes, (x, -y).
inline constexpr std::array<double, 2> kPaperMiddle_m{-0.6075, -1.6205};

/// The floor as a sea around the motion capture's origin, its x axis at `x_azimuth_deg` clockwise
/// from north. Patch i of the table is object i: a polygon of three to six corners, drawn by seed,
/// whose inscribed circle has the table's radius and whose centroid lies at the table's place.
[[nodiscard]] Result<Sea> laboratory_sea(int seed, double x_azimuth_deg);

}  // namespace watersky::sim
