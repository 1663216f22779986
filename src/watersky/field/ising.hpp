// SPDX-License-Identifier: MIT
#pragma once
/// Cells are not independent: next to ice lies ice. The Ising model over the grid, which adds that
/// to what the looks said of each cell alone.
///
/// A map x gives each seen cell ice (1) or water (0). Its posterior is exp(-E(x)) / Z with
///
///   E(x) = -Σ l_i x_i + J Σ w_ij [x_i ≠ x_j],
///
/// l_i the cell's log-odds of ice from its looks and the prior, J the coupling (log-odds), the
/// second sum over pairs of neighbours among eight: w_ij is 1 along rows and columns and 1/√2 along
/// diagonals, so that an edge costs about the same whatever its direction. Cells never seen (NaN)
/// have no pairs: they change nothing and stay unknown. With J = 0 cells are independent, as in
/// Algorithm 1.
#include <array>
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"

namespace watersky::field {

/// A neighbour of a cell. In kNeighbours the one at d and the one at 7 - d lie opposite.
struct Neighbour {
  int row = 0;
  int column = 0;
  double weight = 1.0;
};
inline constexpr double kDiagonalWeight = 0.70710678118654752;
inline constexpr std::array<Neighbour, 8> kNeighbours{{{-1, -1, kDiagonalWeight},
                                                       {-1, 0, 1.0},
                                                       {-1, 1, kDiagonalWeight},
                                                       {0, -1, 1.0},
                                                       {0, 1, 1.0},
                                                       {1, -1, kDiagonalWeight},
                                                       {1, 0, 1.0},
                                                       {1, 1, kDiagonalWeight}}};

/// The strongest coupling that is accepted. All neighbours together then weigh 55 log-odds, which
/// no evidence outweighs.
inline constexpr double kMaxCoupling = 8.0;

/// Label of a cell never seen.
inline constexpr int kUnseen = 255;

/// E(x) of a map of labels (CV_8U: 0, 1, kUnseen), of `log_odds`' size.
[[nodiscard]] double energy(const cv::Mat& log_odds, const cv::Mat& labels, double coupling);

/// What every function of this module asks of its input: CV_32F (empty is allowed), and a coupling
/// from 0 to kMaxCoupling. InvalidInput otherwise.
[[nodiscard]] Status check_field(const cv::Mat& log_odds, double coupling);

}  // namespace watersky::field
