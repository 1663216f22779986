// SPDX-License-Identifier: MIT
#pragma once
/// Finds a flat target in an image: chessboards by OpenCV's sector-based detector, circles and
/// holes by our own. Blobs of either polarity are taken against their surroundings, so an uneven
/// background does no harm; whatever lies on a regular lattice is the target. Their centres are
/// centroids of how much of each pixel is circle, between a plane through the background and one
/// through the circle.
#include <opencv2/core/mat.hpp>

#include "watersky/target_calibration/target.hpp"

namespace watersky {

struct TargetRequest {
  std::optional<TargetKind> kind;  ///< nullopt: a chessboard if there is one, otherwise circles
  std::optional<TargetSize> size;  ///< nullopt: as it is seen
};

/// The target in `image` (8 or 16 bit or float, 1 or 3 channels). NotFound when there is none, when
/// less than half of it is seen, or when what is seen is another one; the message says which.
///
/// A chessboard must be seen whole. Of circles a part will do: half of those asked for, with three
/// rows and columns. Centroids are those of the discs' pictures, which are not quite the pictures
/// of the discs' centres; the calibration takes that into account (target_calibration.hpp).
[[nodiscard]] Result<DetectedTarget> detect_target(const cv::Mat& image,
                                                   const TargetRequest& request);

}  // namespace watersky
