// SPDX-License-Identifier: MIT
#pragma once
/// Where the evidence of a map lies, and how surely.
///
/// Looks at one place err together: the same pose error, the same offset of the whole flight,
/// thirty times a second. Softening each look would be undone when they add up. So evidence is
/// added sharp, this keeps beside it how far the looks at each block of cells may all be off, and
/// the softening is done once, on the probabilities: P(ice) at a place is the mean of the map over
/// where that place may be.
#include <Eigen/Core>
#include <array>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <unordered_map>
#include <vector>

#include "watersky/map/ice_map.hpp"

namespace watersky {

/// Covariance of the place, (column, row), cells², at a grid position.
using PositionCovariance = std::function<Eigen::Matrix2d(const Eigen::Vector2d& grid)>;

class PositionUncertainty {
 public:
  /// Blocks have this many cells along an edge: covariances change slowly.
  static constexpr int kBlockCells = 16;

  /// Adds one frame's: the mean over looks is kept. The covariance is asked for at a few places
  /// and interpolated: to 1 % of its trace where that is compared, to 2 % elsewhere.
  void add(const GridView& view, const PositionCovariance& covariance);

  [[nodiscard]] bool empty() const { return tiles_.empty(); }
  /// Of each block that touches `box`, the first at its north-west corner's block: cc, cr, rr
  /// (CV_32FC3), cells²; zero where nothing was added.
  [[nodiscard]] cv::Mat covariance(const CellBox& box) const;

  /// `probability` (CV_32F of `box`, NaN unseen) as what is known of places, not of evidence.
  /// Unseen cells stay unseen and take nothing from their neighbours.
  [[nodiscard]] cv::Mat softened(const cv::Mat& probability, const CellBox& box) const;

 private:
  static constexpr int kBlocks = kTileCells / kBlockCells;
  struct Tile {
    std::array<std::array<float, 4>, static_cast<std::size_t>(kBlocks) * kBlocks> sums{};
  };
  std::unordered_map<TileIndex, Tile, TileHash> tiles_;
};

/// Gaussian mean over a covariance (column, row; cells²) that keeps NaN cells NaN and out of it.
[[nodiscard]] cv::Mat gaussian_mean(const cv::Mat& values, const Eigen::Matrix2d& covariance);

}  // namespace watersky
