// SPDX-License-Identifier: MIT
#pragma once
/// Is ice brighter or darker than water? Found from the shapes in the images, not told.
///
/// Floes are compact: freezing and breaking make pieces that fill most of their convex hull.
/// What lies between them, leads and gaps and the melt ponds on them, is left over: networks
/// and irregular patches that fill little of theirs. The measure is solidity, a component's area
/// over its hull's area, averaged over a class by area. It speaks through the class that covers
/// less of the image: the other is a background with holes, whatever it is made of.
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace watersky {

/// Whether ice is brighter or darker than water in the images at hand. Thermal images show
/// either, by season and hour; Auto finds out from the images.
enum class IcePolarity { Auto, Brighter, Darker };

/// What was found, how sure, and why.
struct PolarityEstimate {
  IcePolarity polarity = IcePolarity::Brighter;  ///< never Auto
  double confidence = 0.5;  ///< P(polarity is right): 0.5 is a coin's toss, 1 was given
  std::string evidence;     ///< one sentence for reports
};

/// Below this confidence a report should advise to name the polarity.
inline constexpr double kSureOfPolarity = 0.9;

/// What a report should say of it: a sentence or two.
[[nodiscard]] std::string polarity_note(const PolarityEstimate& polarity);

/// How compact the two classes of a mask are.
struct ShapeEvidence {
  double bright_fraction = 0.0;
  double bright_solidity = 0.0;  ///< area-weighted mean of area / hull area, in [0, 1]
  double dark_solidity = 0.0;
  /// > 0: the bright class looks like floes; < 0: the dark class does. About ±0.3 at most.
  double score = 0.0;
};

/// Shapes of a mask: `bright` is CV_8U, not 0 where bright; `valid` CV_8U or empty. Components
/// smaller than 1/4000 of the image do not count: their shape is that of pixels.
[[nodiscard]] ShapeEvidence shape_evidence(const cv::Mat& bright, const cv::Mat& valid);

/// The verdict over a flight of `frames` frames. `scores`: ShapeEvidence::score of frames that
/// show two classes. `in_colour`: the images have colour, so they were taken in visible light,
/// in which ice is brighter than water nearly always.
[[nodiscard]] PolarityEstimate estimate_polarity(const std::vector<double>& scores,
                                                 std::size_t frames, bool in_colour);

}  // namespace watersky
