// SPDX-License-Identifier: MIT
#pragma once
/// A map against the truth of a simulation: the figures that tests, experiments and benchmarks
/// are judged by.
#include <vector>

#include "watersky/evaluation/segmentation_score.hpp"
#include "watersky/ice/accuracy.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky {

/// Whether P(ice) means what it says, of cells mostly ice or mostly water: of all that were seen,
/// and of those within 3 m of a true edge.
struct Calibration {
  Reliability all, near_edges;
};
/// `probability`: CV_32F, NaN where never seen. `ice_share`: CV_32F of the same cells.
[[nodiscard]] Calibration calibration(const cv::Mat& probability, const cv::Mat& ice_share,
                                      double cell_m);

struct Evaluation {
  ice::RasterAccuracy raster;
  /// Isolated true objects of at least the asked length that lie wholly in what was seen.
  std::size_t true_objects = 0;
  std::size_t matched_objects = 0;
  /// Findings of at least that length, wholly seen, that no true object of any length matches.
  std::size_t false_objects = 0;
  std::vector<double> centroid_errors_m;  ///< of the matched, ascending

  /// `located`: softened by where the poses may be wrong, as the product is; `evidence`: as the
  /// evidence lies.
  Calibration located, evidence;

  /// The error that a share of the matched does not exceed; 0 when nothing matched.
  [[nodiscard]] double centroid_error_m(double share) const;
};

/// Compares on the map's own cells. `min_length_m`: largest caliper of the objects that count.
[[nodiscard]] Result<Evaluation> evaluate(const MapRun& run, const sim::Truth& truth,
                                          double min_length_m = 3.0);

}  // namespace watersky
