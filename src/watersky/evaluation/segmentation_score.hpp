// SPDX-License-Identifier: MIT
#pragma once
/// P(ice) of an image against a mask that somebody drew: what is right, how much, and whether
/// the probabilities mean what they say.
#include <array>
#include <cstddef>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

/// How often it was ice where P(ice) was said to be about so much.
class Reliability {
 public:
  static constexpr std::size_t kBins = 15;
  /// Of equal width from 0 to 1.
  struct Bin {
    std::size_t pixels = 0;
    std::size_t ice = 0;
    double p_sum = 0.0;
    [[nodiscard]] double mean_p() const { return p_sum / static_cast<double>(pixels); }
    [[nodiscard]] double ice_share() const {
      return static_cast<double>(ice) / static_cast<double>(pixels);
    }
  };

  void add(double p_ice, bool is_ice);
  void add(const Reliability& other);
  [[nodiscard]] const std::array<Bin, kBins>& bins() const { return bins_; }
  [[nodiscard]] std::size_t pixels() const;
  /// Expected calibration error: mean over the pixels of |mean P(ice) - share of ice| in their
  /// bin; NaN without pixels.
  [[nodiscard]] double calibration_error() const;

 private:
  std::array<Bin, kBins> bins_{};
};

/// Over the pixels that are judged. Where the segmenter does not know (NaN) it is asked all the
/// same: P(ice) counts as one half in the Brier score and in reliability, and the class as wrong
/// in accuracy and as water in IoU. Silence cannot raise a score.
struct SegmentationScore {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::size_t pixels = 0;
  double unknown_share = 0.0;
  double accuracy = kNone;
  double iou = kNone;                 ///< of ice; 1 where neither truth nor result has any
  double concentration = kNone;       ///< share of P(ice) > 1/2 among the known; NaN: none is
  double true_concentration = kNone;  ///< of all pixels judged
  double brier = kNone;               ///< mean of (P(ice) - truth)²
  /// P1 and P2 of (2.31) as they are: the share of ice among pixels classed ice, and among those
  /// classed water. NaN where none is classed so.
  double p_ice_if_ice = kNone;
  double p_ice_if_water = kNone;
  Reliability reliability;

  /// |concentration - true_concentration|; with nothing known that of a guess of one half.
  [[nodiscard]] double concentration_error() const;
  [[nodiscard]] double calibration_error() const { return reliability.calibration_error(); }
};

/// `p_ice`: CV_32F, NaN where not known. `ice`: CV_8U of the same size, not 0 where the truth is
/// ice. `judged`: CV_8U, 0 where nothing is judged; empty: all is. InvalidInput for other types or
/// sizes, or when nothing is judged.
[[nodiscard]] Result<SegmentationScore> score_segmentation(const cv::Mat& p_ice, const cv::Mat& ice,
                                                           const cv::Mat& judged = {});

/// Over several images, each of equal weight, but for what pools their pixels.
struct MeanSegmentationScore {
  std::size_t images = 0;
  double accuracy = 0.0, iou = 0.0, concentration_error = 0.0, brier = 0.0;
  double calibration_error = 0.0;         ///< mean over the images
  double pooled_calibration_error = 0.0;  ///< of all their pixels together
  double worst_accuracy = 0.0, worst_iou = 0.0;
  double unknown_share = 0.0;
  double p_ice_if_ice = 0.0, p_ice_if_water = 0.0;  ///< of all their pixels together; may be NaN
  Reliability reliability;
};
[[nodiscard]] MeanSegmentationScore mean_score(const std::vector<SegmentationScore>& scores);

}  // namespace watersky
