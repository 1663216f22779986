// SPDX-License-Identifier: MIT
#pragma once
/// Where to begin: rough homographies between the coarse views of two frames.
#include <optional>
#include <vector>

#include "watersky/registration/detail/view.hpp"

namespace watersky::detail {

struct Start {
  Eigen::Matrix3d b_from_a;  ///< between coarse views
  double peak = 0.0;         ///< of the correlation, in its own spreads
};

/// The best turns and shifts by phase correlation of the tiny views, best first, no two alike.
[[nodiscard]] std::vector<Start> correlation_starts(const KltFrame& a, const KltFrame& b);

/// From SIFT matched by ratio and MAGSAC++: any turn, and overlaps of a quarter.
[[nodiscard]] std::optional<Start> feature_start(const KltFrame& a, const KltFrame& b);

/// MAGSAC++ with a fixed seed. Indices of the inliers; nothing where it finds no homography.
struct Consensus {
  Eigen::Matrix3d b_from_a;
  std::vector<PointPair> inliers;
};
[[nodiscard]] std::optional<Consensus> consensus(std::span<const PointPair> pairs,
                                                 double threshold_px, int iterations);

}  // namespace watersky::detail
