// SPDX-License-Identifier: MIT
#pragma once
/// Otsu's threshold: one for the image.
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>

#include "watersky/vision/two_class.hpp"

namespace watersky {

/// Otsu's split of gray levels: those above `level` are the bright class.
struct OtsuThreshold {
  int level = 0;
  double separability = 0.0;  ///< η: between-class over total variance, in [0, 1]; 0: one level
  double dark_mean = 0.0;
  double bright_mean = 0.0;
  double bright_fraction = 0.0;
};

/// The lowest level that maximises the between-class variance, found in exact sums.
/// `histogram[i]`: number of pixels of gray level i.
[[nodiscard]] OtsuThreshold otsu_threshold(std::span<const std::uint32_t> histogram);

/// The same for an image, CV_8UC1 or CV_16UC1 with all its levels as bins. `valid` as in
/// Segmenter. Unsupported for another type, InvalidInput when nothing is valid.
[[nodiscard]] Result<OtsuThreshold> otsu_threshold(const cv::Mat& gray, const cv::Mat& valid = {});

/// (2.31) on Otsu's threshold: the image's own, or the flight's after observe().
class OtsuSegmenter final : public TwoClassSegmenter {
 public:
  explicit OtsuSegmenter(const TwoClassEvidence& evidence = {}, IcePolarity ice = IcePolarity::Auto)
      : TwoClassSegmenter(evidence, ice) {}

 private:
  [[nodiscard]] cv::Mat bright(const Frame& frame) const override;
};

}  // namespace watersky
