// SPDX-License-Identifier: MIT
#pragma once
/// Where the cells of one frame fall in its image, block by block.
///
/// Positions are exact at nine nodes of a block; between them they are the quadratic through
/// those, as long as it meets other exact positions to 1/64 of a pixel. A block that bends more
/// is cut into four; what still bends, or reaches to where the lens does not look, is left to
/// exact positions cell by cell.
#include <array>
#include <functional>
#include <vector>

#include "watersky/map/detail/cell_projection.hpp"
#include "watersky/map/detail/evidence_levels.hpp"

namespace watersky::detail {

/// u = u[0] + u[1] i + u[2] j + u[3] i² + u[4] i j + u[5] j², in pixels of the full image; the same
/// for v.
struct PixelPatch {
  std::array<double, 6> u{}, v{};
  [[nodiscard]] Pixel at(double i, double j) const;
};

/// Cells of one block, all of them or a quarter.
struct FootprintPart {
  int block_column = 0, block_row = 0;  ///< in blocks of MapTile::kBlockCells, from cell (0, 0)
  int column = 0, row = 0;              ///< of the first cell, in the block
  int cells = MapTile::kBlockCells;     ///< along an edge
  bool exact = false;                   ///< no patch: ask for each cell
  PixelPatch patch;                     ///< of (column - first, row - first)
  Eigen::Vector2d low{}, high{};        ///< pixels between which the patch surely lies
  bool inside = false;    ///< all cells lie in the image, half a cell around them included
  bool limited = false;   ///< the grazing limit cuts it
  Averaging averaging{};  ///< of the image, so that nothing is skipped
  int samples_x = 1, samples_y = 1;  ///< spread over each cell

  [[nodiscard]] int first_column() const { return block_column * MapTile::kBlockCells + column; }
  [[nodiscard]] int first_row() const { return block_row * MapTile::kBlockCells + row; }
};

class Footprint {
 public:
  /// How far a patch may be off where it is compared, and is anywhere (footprint_test.cpp), in
  /// pixels of the averaged image.
  static constexpr double kTolerance_px = 1.0 / 64;
  static constexpr double kMostError_px = 1.0 / 32;

  /// `supersampling`: samples along a cell's edge, of the image as it is; 0: chosen by place.
  Footprint(const GridView& view, int supersampling);

  /// Calls for every part of which a cell may be seen, block row by block row.
  void for_each(const std::function<void(const FootprintPart&)>& part) const;

  /// Whether the view shows a position of the grid, exactly, and where.
  [[nodiscard]] std::optional<Pixel> seen(double column, double row) const;
  /// Whether the grazing limit allows it.
  [[nodiscard]] bool within_limit(double column, double row) const {
    return (sea_middle_ + column * sea_column_ + row * sea_row_).squaredNorm() <= limit2_;
  }

 private:
  struct Node {
    double u = 0.0, v = 0.0;
    bool known = false;
  };
  using Nodes = std::array<std::array<Node, 3>, 3>;  ///< rows of columns

  [[nodiscard]] Node node(double column, double row) const;
  /// False when it is nowhere in the image; a part that does not fit comes out `exact`.
  [[nodiscard]] bool fit(const Nodes& nodes, FootprintPart& part) const;
  void choose_sampling(const Eigen::Matrix2d& pixels_per_cell, FootprintPart& part) const;
  void emit(const Nodes& nodes, FootprintPart& part,
            const std::function<void(const FootprintPart&)>& use) const;

  const GridView& view_;
  CellProjection projection_;
  int supersampling_;
  Eigen::Vector2d sea_middle_, sea_column_, sea_row_;
  double limit2_;
};

}  // namespace watersky::detail
