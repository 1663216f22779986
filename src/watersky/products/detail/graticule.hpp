// SPDX-License-Identifier: MIT
#pragma once
/// Parallels and meridians across a map sheet.
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "watersky/products/products.hpp"

namespace watersky::detail {

enum class GraticuleSide { Left, Bottom };

struct GraticuleLabel {
  GraticuleSide side = GraticuleSide::Left;
  double position = 0.0;  ///< along the side, in the sheet's units
  std::string text;       ///< degrees and decimal minutes
};

struct Graticule {
  std::vector<std::vector<Eigen::Vector2d>> lines;  ///< in the sheet's units; may leave the sheet
  std::vector<GraticuleLabel> labels;               ///< where lines cross the left and lower side
};

/// Lines at a round number of degrees or minutes, three to six each way. `to_sheet` takes easting
/// and northing to the sheet. Empty where longitudes make no grid: a pole on or near the sheet.
[[nodiscard]] Graticule make_graticule(
    const Products& products, double width, double height,
    const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& to_sheet);

}  // namespace watersky::detail
