// SPDX-License-Identifier: MIT
#pragma once
/// What the classifier looks at: levels, contrasts and texture at several scales, in units of the
/// image's own contrast, so that gain and offset of the camera do not matter.
///
/// Two scales. `coarse`, a quarter of the image's size, looks widely (up to 124 px of the image
/// around) and decides roughly; `fine`, half its size, looks closely and hears from the coarse
/// scale how ice and water look around here.
#include <array>
#include <opencv2/core/mat.hpp>

#include "watersky/vision/detail/dense_network.hpp"

namespace watersky::detail {

/// Changes whenever a feature does: a model works with the features that it was trained on.
inline constexpr int kIceFeaturesVersion = 1;
/// Numbers of inputs of the coarse network, and of the fine one: fine_features() and
/// context_features().
[[nodiscard]] constexpr int coarse_inputs(bool in_colour) { return in_colour ? 29 : 26; }
[[nodiscard]] constexpr int fine_inputs(bool in_colour) { return (in_colour ? 10 : 7) + 22; }

/// How an image's gray levels are spread. Levels are of the quarter-size picture, where noise is
/// averaged down.
struct LevelStatistics {
  static constexpr int kBins = 256;
  float mode = 0.0F;              ///< the commonest level: one class's
  float inverse_spread = 0.0F;    ///< 4 / (98th - 2nd percentile)
  float threshold = 0.0F;         ///< Otsu's
  float inverse_contrast = 0.0F;  ///< 1 / difference of Otsu's two means
  float first = 0.0F;             ///< level at the edge of the first bin
  float bins_per_level = 0.0F;
  std::array<float, kBins> density{};  ///< log of the relative frequency, 0 at the mode
  std::array<float, kBins> rank{};     ///< part of the pixels at or below

  /// From a histogram of kBins equal bins from `first`; `pixels`: how many it counts, at least 1.
  static LevelStatistics of(const std::array<float, kBins>& histogram, float first,
                            float bins_per_level);

  /// +1 or -1. The networks know ice as the brighter class; where it is the darker one they are
  /// shown the negative.
  float sign = 1.0F;
  [[nodiscard]] LevelStatistics with_ice(bool brighter) const;
};

/// An image prepared for the classifier. All planes CV_32F; `half` and `quarter` in gray levels.
struct IceScene {
  cv::Size size;  ///< of the image, before padding to multiples of four
  cv::Mat half;   ///< what it is told apart by: the gray level; in colour the whiteness
  cv::Mat quarter;
  cv::Mat quarter_valid;  ///< CV_8U; empty: all
  /// In colour only: luminance and whiteness of full scale, and saturation, in [0, 1].
  Planes half_colour, quarter_colour;
};

/// `image`: CV_8U, CV_16U or CV_32F with 1 or 3 (BGR) channels, not empty; `valid` as in
/// Segmenter. Where it is not valid the scene is filled in from around.
///
/// Whiteness is the lowest of the three channels: ice and snow reflect all of visible light, sea
/// water absorbs at least one end of it, whether it is blue, teal or brown.
[[nodiscard]] IceScene ice_scene(const cv::Mat& image, const cv::Mat& valid, bool in_colour);

/// The scene's own levels. False where it has none: nothing valid, or one level everywhere.
[[nodiscard]] bool level_statistics(const IceScene& scene, LevelStatistics& statistics);

/// Inputs of the coarse network.
[[nodiscard]] Planes coarse_features(const IceScene& scene, const LevelStatistics& levels);

/// Inputs of the fine network at its own scale.
[[nodiscard]] Planes fine_features(const IceScene& scene, const LevelStatistics& levels);

/// Its inputs at the coarse scale: what the coarse network thinks (`p_ice`, `logit`) and how ice
/// and water look around each pixel by that.
[[nodiscard]] Planes context_features(const IceScene& scene, const LevelStatistics& levels,
                                      const cv::Mat& p_ice, const cv::Mat& logit);

}  // namespace watersky::detail
