// SPDX-License-Identifier: MIT
#pragma once
/// What in a gray picture says whether its brighter or its darker class is ice.
///
/// The shapes of the pieces tell (polarity.hpp), wherever it is. Their surfaces tell as well,
/// which of the two is the rougher, or the more alike from place to place; but that differs from
/// sea to sea and season to season, so it may only lean the scales a little. How much each cue says
/// is learned with the networks.
#include <array>
#include <span>

#include "watersky/vision/detail/ice_features.hpp"

namespace watersky::detail {

inline constexpr std::size_t kPolarityCues = 5;
inline constexpr std::size_t kShapeCues = 2;  ///< of those, the first

/// Each changes its sign, and nothing else, when the picture is turned into its negative; positive
/// ones speak for bright ice when they are shapes. Without two classes all are 0.
/// `level`: the gray levels, CV_32F, at a quarter of the image's size; `valid` CV_8U or empty.
using PolarityCues = std::array<float, kPolarityCues>;
[[nodiscard]] PolarityCues polarity_cues(const cv::Mat& level, const cv::Mat& valid,
                                         const LevelStatistics& levels);

/// log(P(ice is brighter) / P(ice is darker)).
struct PolarityLogOdds {
  double by_shapes = 0.0;
  double by_surfaces = 0.0;  ///< at most 1 either way
};
[[nodiscard]] PolarityLogOdds polarity_log_odds(const PolarityCues& cues,
                                                std::span<const float> weights);

/// What was found of one picture: its cues and which polarity is right.
struct PolarityExample {
  PolarityCues cues{};
  bool ice_brighter = true;
  double weight = 1.0;
};

/// Logistic regression without a constant, so that a picture and its negative agree; first on
/// shapes alone, then on what surfaces add.
[[nodiscard]] std::array<float, kPolarityCues> fit_polarity(
    std::span<const PolarityExample> examples);

}  // namespace watersky::detail
