// SPDX-License-Identifier: MIT
#pragma once
/// Edges with morphology (thesis, 2.4 and 2.4.1): find the edges, close their gaps, fill what
/// they enclose.
#include "watersky/vision/two_class.hpp"

namespace watersky {

struct EdgeParameters {
  double sigma_px = 0.8;
  double edge_contrast = 0.05;
  int close_px = 3;
  int least_region_px = 30;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.sigma_px,
          ParameterInfo{"edge_sigma_px", "px", "edges: Gaussian before the gradient", 0.3, 20.0});
    visit(self.edge_contrast,
          ParameterInfo{"edge_contrast", "1",
                        "edges: slope of an edge, a pixel, in parts of the contrast between ice "
                        "and water; weaker ones down to 0.4 of it count where they go on from one",
                        0.005, 2.0});
    visit(self.close_px,
          ParameterInfo{"edge_close_px", "px",
                        "edges: closing of the edges, edge of its kernel, made odd; 0 for none", 0,
                        99});
    visit(self.least_region_px,
          ParameterInfo{"edge_least_region_px", "px",
                        "edges: what encloses fewer pixels is part of the edge", 0, 100000});
  }
};

/// (2.31) on the regions between Canny's edges. scikit-image's recipe fills closed outlines;
/// ice goes on beyond the frame, so here every region between edges is filled, with the class on
/// whose side of the frame's threshold its mean level lies, and the pixels of the edges
/// themselves fall to the classes by level.
class EdgeSegmenter final : public TwoClassSegmenter {
 public:
  explicit EdgeSegmenter(const EdgeParameters& parameters = {},
                         const TwoClassEvidence& evidence = {},
                         IcePolarity ice = IcePolarity::Auto);

 private:
  [[nodiscard]] cv::Mat bright(const Frame& frame) const override;
  EdgeParameters parameters_;
};

}  // namespace watersky
