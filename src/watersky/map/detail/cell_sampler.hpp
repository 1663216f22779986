// SPDX-License-Identifier: MIT
#pragma once
/// Where the cells of one frame fall in its image, row by row.
#include <span>
#include <vector>

#include "watersky/map/detail/cell_projection.hpp"
#include "watersky/map/grid_view.hpp"

namespace watersky {

/// Positions in the image of n x n samples spread over each cell. A row's buffer is reused by
/// the next.
class CellSampler {
 public:
  /// `per_edge`: samples along a cell's edge; 1 is the cell's centre; 0 chooses one a pixel, to the
  /// nearest whole number (each sample is bilinear, so it reaches a pixel far by itself).
  CellSampler(const GridView& view, int per_edge);

  [[nodiscard]] int samples_per_cell() const { return per_edge_ * per_edge_; }

  /// One row of cells: samples_per_cell() planes of `columns` entries each, so that loops run
  /// along the row.
  struct Row {
    int first_column = 0;
    int columns = 0;
    const float* u = nullptr;
    const float* v = nullptr;
    [[nodiscard]] const float* u_plane(int sample) const {
      return u + static_cast<std::ptrdiff_t>(sample) * columns;
    }
    [[nodiscard]] const float* v_plane(int sample) const {
      return v + static_cast<std::ptrdiff_t>(sample) * columns;
    }
  };
  /// In u where a sample is not in the image, is behind the camera, or beyond the grazing limit.
  static constexpr float kUnseen = -1e9F;

  /// The cells of one row of the grid that the footprint touches; none when columns is 0.
  [[nodiscard]] Row row(int grid_row);

 private:
  void project_line(double first_x, double y, int count, float* u, float* v) const;

  const GridView& view_;
  detail::CellProjection projection_;
  int per_edge_;
  bool limited_, rolls_;
  std::vector<float> u_, v_;
};

}  // namespace watersky
