// SPDX-License-Identifier: MIT
#pragma once
/// From features to scores: the way that training and segmentation share.
#include "watersky/vision/detail/ice_features.hpp"
#include "watersky/vision/ice_model.hpp"

namespace watersky::detail {

/// Scores of a network: one plane each of melt pond, ice and open water, the logarithm of their
/// probabilities but for a constant.
inline constexpr std::size_t kPond = 0, kIce = 1, kWater = 2, kClasses = 3;

/// P(ice) from scores, with melt ponds counted as ice or not; log-odds within [-8, 8].
[[nodiscard]] cv::Mat probability(const Planes& scores, bool ponds_are_ice = false);

/// log(p / (1 - p)).
[[nodiscard]] cv::Mat log_odds(const cv::Mat& p);

/// The coarse network's P(ice), at a quarter of the image's size.
[[nodiscard]] cv::Mat rough_p_ice(const IceNetworks& networks, const IceScene& scene,
                                  const LevelStatistics& levels, bool ponds_are_ice = false);

/// Scores at half the image's size.
[[nodiscard]] Planes ice_scores(const IceNetworks& networks, const IceScene& scene,
                                const LevelStatistics& levels);

}  // namespace watersky::detail
