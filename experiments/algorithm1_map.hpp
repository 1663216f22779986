// SPDX-License-Identifier: MIT
#pragma once
/// The thesis's way to a map: Otsu's masks, one a frame, and Algorithm 1 on a canvas in World.
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::study {

/// Cells along World's first two axes, on the plane of the sea at `sea_down_m`.
struct Canvas {
  Eigen::Vector2d corner_m = Eigen::Vector2d::Zero();  ///< of cell (0, 0), in World
  double sea_down_m = 0.0;
  double cell_m = 0.5;
  int width_cells = 0, height_cells = 0;

  /// (column, row) of a place in World; cell centres at whole numbers.
  [[nodiscard]] Eigen::Vector2d cell(const Eigen::Vector2d& world_m) const {
    return ((world_m - corner_m) / cell_m).array() - 0.5;
  }
};

/// Over all that a recording's frames truly see above the grazing limit, and some metres more.
[[nodiscard]] Result<Canvas> canvas_over(const sim::Simulation& recording, double cell_m);

/// The share of ice in each cell.
[[nodiscard]] cv::Mat true_share(const sim::Truth& truth, const Canvas& canvas);

/// The mask that Algorithm 1 is given of each frame (CV_8U), by Otsu's split, ice being brighter,
/// after a look at a sample of the frames.
[[nodiscard]] Result<std::vector<cv::Mat>> segmented(const std::vector<const ImageFrame*>& frames);

/// P(ice): CV_32F, NaN where never seen. Of the prepared flight the frames that `masks` are of, but
/// for those without a pose.
[[nodiscard]] Result<cv::Mat> algorithm1_map(const Flight& prepared,
                                             const std::vector<const ImageFrame*>& frames,
                                             const std::vector<cv::Mat>& masks,
                                             const Canvas& canvas);

}  // namespace watersky::study
