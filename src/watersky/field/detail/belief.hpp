// SPDX-License-Identifier: MIT
#pragma once
/// Loopy belief propagation on the grid, in odds: no logarithm and no exponential inside.
#include <array>
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace watersky::field::detail {

/// What cell i tells its neighbour j, as odds of ice: with R the odds of i by its evidence and by
/// all that its other neighbours told it, and q = exp(J w_ij), (q R + 1) / (R + q).
class Belief {
 public:
  Belief(const cv::Mat& log_odds, double coupling);

  /// Every cell once, in four colours of which no two cells are neighbours, so that the order
  /// within a colour does not matter. Returns the largest change of a P(ice).
  float sweep();

  /// P(ice), CV_32F; NaN where never seen.
  [[nodiscard]] cv::Mat probability() const;

  /// Mean over the seen cells of log((1 - c) + c exp(l)): c is P(ice) by all cells but this, l the
  /// cell's own log-odds. How well the others foretell what each cell showed, but for what does not
  /// depend on the coupling; 0 without cells.
  [[nodiscard]] double mean_prediction() const;

 private:
  [[nodiscard]] std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row + 1) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(column + 1);
  }
  /// Product of what the neighbours tell the cell.
  [[nodiscard]] float told(std::size_t cell) const;

  int rows_, columns_, stride_;
  std::array<std::ptrdiff_t, 8> offset_{};
  std::array<float, 8> q_{};
  std::vector<float> odds_;                     ///< of each cell alone; 0: never seen
  std::vector<std::array<float, 8>> messages_;  ///< to the cell, by the neighbour that tells
  std::vector<float> probability_;
};

}  // namespace watersky::field::detail
