// SPDX-License-Identifier: MIT
#pragma once
/// Otsu's criterion in a sliding window: a threshold of its own for each pixel, which follows
/// shading that one threshold for the image cannot.
#include <opencv2/core/mat.hpp>

#include "watersky/vision/two_class.hpp"

namespace watersky {

/// The window around a pixel.
struct LocalWindow {
  int radius_px = 0;    ///< it reaches so far to each side
  bool square = false;  ///< false: a disk, x² + y² <= radius²
};

/// Otsu's threshold of the window around each pixel whose row and column are multiples of
/// `stride_px`, as scikit-image's filters.rank.otsu: levels above it are the window's bright
/// class, and what lies outside the image or is not `valid` does not count.
///
/// `gray`: CV_8UC1. Returned: `level`, CV_8U, one pixel for each of those asked for, the lowest of
/// the levels that maximise the between-class variance (scikit-image names another one of equal
/// levels now and then: the split is the same); `contrast`, CV_32F, between the means of the
/// window's classes, 0 for a window of one level or without a valid pixel.
///
/// Histograms slide: a pixel costs 4 radius + 2 updates for each pixel that the window moves and,
/// where the threshold is asked for, one walk over the levels that occur.
struct LocalThresholds {
  cv::Mat level;
  cv::Mat contrast;
};
[[nodiscard]] LocalThresholds local_otsu_thresholds(const cv::Mat& gray, const cv::Mat& valid,
                                                    const LocalWindow& window, int stride_px = 1);

struct LocalOtsuParameters {
  int radius_px = 64;
  bool square = false;
  int stride_px = 8;
  double least_contrast = 0.5;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.radius_px, ParameterInfo{"local_radius_px", "px",
                                        "local Otsu: how far the window reaches", 1, 1000});
    visit(self.square,
          ParameterInfo{"local_square", "1", "local Otsu: a square window instead of a disk"});
    visit(self.stride_px,
          ParameterInfo{"local_stride_px", "px",
                        "local Otsu: a window for every so many pixels, straight between", 1, 100});
    visit(self.least_contrast,
          ParameterInfo{"local_least_contrast", "1",
                        "local Otsu: windows with less than this part of the image's contrast are "
                        "split at the image's threshold",
                        0.0, 10.0});
  }
};

/// (2.31) on local thresholds. 16-bit levels are read as 256 between the frame's extremes, 0.05 %
/// at either end left out. A window that shows one class only has no threshold worth the name:
/// where its classes lie closer than `least_contrast` of the frame's own, or than two sigmas of a
/// pixel within its class, the frame's threshold (the flight's, after observe()) stands in.
class LocalOtsuSegmenter final : public TwoClassSegmenter {
 public:
  explicit LocalOtsuSegmenter(const LocalOtsuParameters& parameters = {},
                              const TwoClassEvidence& evidence = {},
                              IcePolarity ice = IcePolarity::Auto);

 private:
  [[nodiscard]] cv::Mat bright(const Frame& frame) const override;
  LocalOtsuParameters parameters_;
};

}  // namespace watersky
