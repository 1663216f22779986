// SPDX-License-Identifier: MIT
#pragma once
/// What one frame says of ice, pixel by pixel.
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"

namespace watersky {

/// What each level of an 8-bit image says: log-odds minus the prior's; NaN says nothing.
using EvidenceTable = std::array<float, 256>;

/// Levels above `threshold` are ice with probability p_above, the others with p_below (2.31).
[[nodiscard]] EvidenceTable threshold_evidence(int threshold, double p_above, double p_below,
                                               double prior);
/// Level l is P(ice) = l / 255, held within 1/510 and 1 - 1/510: half a level from what 8 bits
/// cannot say. Pixels of which nothing is known need a mask.
[[nodiscard]] EvidenceTable probability_evidence(double prior);

/// A frame's evidence as the map takes it, without a copy: the image must outlive it.
///
///   map.update(view, Evidence::of_levels(grey, threshold_evidence(127, 0.7, 0.4, 0.5)), time);
class Evidence {
 public:
  /// `levels`: CV_8U. `valid` (CV_8U of the same size, 0: says nothing) may be empty: all do.
  [[nodiscard]] static Evidence of_levels(const cv::Mat& levels, const EvidenceTable& table,
                                          const cv::Mat& valid = {});
  /// CV_32F: log-odds minus the prior's; NaN says nothing. The general path, and the slower one:
  /// four bytes a pixel are read where an 8-bit image has one.
  [[nodiscard]] static Evidence of_log_odds(const cv::Mat& log_odds);

  /// InvalidInput for an image of another type, a mask of another size or type, or without pixels.
  [[nodiscard]] Status check() const;

  [[nodiscard]] const cv::Mat& image() const { return image_; }
  [[nodiscard]] const cv::Mat& valid() const { return valid_; }
  /// Of 8-bit images.
  [[nodiscard]] const EvidenceTable& table() const { return table_; }
  [[nodiscard]] bool has_levels() const { return has_levels_; }

 private:
  Evidence() = default;
  cv::Mat image_, valid_;
  EvidenceTable table_{};
  bool has_levels_ = false;
};

}  // namespace watersky
