// SPDX-License-Identifier: MIT
#pragma once
/// What alignment does to the map, as pictures: one place of the sea that many frames show, laid
/// there by the poses as given and as corrected.
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "watersky/products/alignment_run.hpp"

namespace watersky::detail {

/// One place before or after, CV_8UC3 of one size.
struct PlacePictures {
  cv::Mat mosaic;  ///< nearest-to-nadir frame first, as mosaic.tif has it: its seams show errors
  cv::Mat mean;    ///< of all frames: sharp where they agree
  cv::Mat spread;  ///< of the frames' levels less what is smooth, on one scale before and after
  /// Root mean square of that spread, in levels of 255, over the cells that several frames show.
  double spread_levels = 0.0;
};

struct BeforeAfter {
  PlacePictures before, after;
  double cell_m = 0.0;
  std::size_t frames = 0;
  double most_spread_levels = 0.0;  ///< the end of the scale
};

/// nullopt when no place is shown by two frames, or their images cannot be read.
[[nodiscard]] std::optional<BeforeAfter> before_after(const AlignmentRun& run);

}  // namespace watersky::detail
