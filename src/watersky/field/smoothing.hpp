// SPDX-License-Identifier: MIT
#pragma once
/// The smoothed map beside the raw one: the Ising model of ising.hpp with a coupling that is given
/// or chosen, its marginals and its most likely map.
///
///   Result<field::Smoothed> smoothed = field::smooth(log_odds);    // CV_32F, NaN: never seen
///   smoothed->probability;                                         // CV_32F, P(ice)
///   smoothed->most_likely;                                         // CV_8U, 0, 1; 255: never seen
#include <opencv2/core/mat.hpp>
#include <optional>

#include "watersky/base/parameters.hpp"
#include "watersky/field/ising.hpp"

namespace watersky::field {

struct SmoothingParameters {
  double coupling = -1.0;
  int smoothing_iterations = 100;
  double smoothing_tolerance = 1e-3;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.coupling,
          ParameterInfo{"coupling", "1",
                        "log-odds by which a neighbouring cell of the other kind makes a cell less "
                        "likely; 0 leaves the map as it is, -1 chooses it from the map",
                        -1.0, kMaxCoupling});
    visit(self.smoothing_iterations,
          ParameterInfo{"smoothing_iterations", "1",
                        "most iterations of belief propagation in smoothing", 1, 100000});
    visit(self.smoothing_tolerance,
          ParameterInfo{"smoothing_tolerance", "1",
                        "smoothing stops when no P(ice) changes by more", 1e-7, 0.5});
  }
};

struct Smoothed {
  cv::Mat probability;  ///< CV_32F, P(ice); NaN where never seen
  cv::Mat most_likely;  ///< CV_8U, 1 ice, 0 water; kUnseen where never seen
  SmoothingParameters parameters;
  double coupling = 0.0;  ///< that was used
  /// By which cells best foretell each other (coupling.hpp); nullopt when the coupling was given.
  std::optional<double> best_foretelling;
  int iterations = 0;
  double last_change = 0.0;  ///< the largest of a P(ice), in the last iteration
  double coupling_s = 0.0;   ///< wall time of choosing the coupling
  double marginals_s = 0.0;  ///< of belief propagation
  double cut_s = 0.0;        ///< of the most likely map
  [[nodiscard]] double wall_s() const { return coupling_s + marginals_s + cut_s; }
};

/// `log_odds`: CV_32F, NaN where never seen. InvalidInput for another type, Usage for parameters
/// out of their range.
[[nodiscard]] Result<Smoothed> smooth(const cv::Mat& log_odds,
                                      const SmoothingParameters& parameters = {});

}  // namespace watersky::field
