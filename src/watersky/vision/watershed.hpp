// SPDX-License-Identifier: MIT
#pragma once
/// Segmentation by the watershed transform (thesis, 2.4.1): water rises from what is surely one
/// class or the other over the gradient's relief, and where two floods meet is the border.
#include <opencv2/core/mat.hpp>

#include "watersky/vision/two_class.hpp"

namespace watersky {

/// Meyer's flooding, 4-connected, as scikit-image's segmentation.watershed: each pixel gets the
/// marker whose flood reaches it first, over `relief` (CV_8U); among equals the first come, first
/// served. `markers`: CV_32S, 0 where nothing is marked; filled in place, and 0 stays only where
/// `valid` is 0 (may be empty) or no flood comes.
void flood_from_markers(const cv::Mat& relief, const cv::Mat& valid, cv::Mat& markers);

struct WatershedParameters {
  double sigma_px = 1.0;
  double marker_share = 0.4;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.sigma_px, ParameterInfo{"watershed_sigma_px", "px",
                                       "watershed: Gaussian before the gradient", 0.3, 20.0});
    visit(self.marker_share,
          ParameterInfo{"watershed_marker_share", "1",
                        "watershed: what lies closer to a class's mean level than this part of the "
                        "contrast, or beyond it, is a marker",
                        0.0, 0.49});
  }
};

/// (2.31) on the watershed of the gradient, with markers from the histogram's extremes, which is
/// scikit-image's recipe.
class WatershedSegmenter final : public TwoClassSegmenter {
 public:
  explicit WatershedSegmenter(const WatershedParameters& parameters = {},
                              const TwoClassEvidence& evidence = {},
                              IcePolarity ice = IcePolarity::Auto);

 private:
  [[nodiscard]] cv::Mat bright(const Frame& frame) const override;
  WatershedParameters parameters_;
};

}  // namespace watersky
