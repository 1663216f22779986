// SPDX-License-Identifier: MIT
#pragma once
/// What the parts of the study of real photographs share.
#include <Eigen/Core>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/flight/flight.hpp"

namespace watersky::study {

/// A checkerboard over the camera's picture. The adjustment gets its white tiles, the judge what
/// is well within its black ones.
struct Checkerboard {
  int columns = 8, rows = 6;
  cv::Size image;

  /// CV_8U, 255 where white.
  [[nodiscard]] cv::Mat white() const;
  /// The black tiles, each less `margin_px` all around: windows of the adjustment reach so far.
  [[nodiscard]] std::vector<cv::Rect> black(int margin_px) const;
};

/// Keypoints of SIFT in the black tiles, in full-size pixels.
struct Keypoints {
  std::vector<cv::Point2d> px;
  cv::Mat descriptors;  ///< CV_32F, a row each
};
/// At most `most_a_tile` of each tile, the strongest, of the picture at a `reduction`th.
[[nodiscard]] Result<Keypoints> find_keypoints(const ImageFrame& frame,
                                               const std::vector<cv::Rect>& tiles, int reduction,
                                               int most_a_tile);

struct PixelTie {
  cv::Point2d a, b;
};
/// What two pictures show of the same, by descriptors (each the other's best, and far better than
/// the next) and by one plane seen through the lens (MAGSAC++): no pose has a say. Empty where they
/// have nothing in common.
[[nodiscard]] std::vector<PixelTie> match(const Keypoints& a, const Keypoints& b,
                                          const CameraModel& camera);

/// Takes pixels of a mended frame to those of the image as it is stored.
struct StoredPixels {
  Eigen::Matrix<double, 2, 3> stored_from_mended;
  [[nodiscard]] Pixel operator()(const cv::Point2d& mended) const;
};
/// Of each frame. `mend` is what was done to the flight, as a function of it.
[[nodiscard]] Result<std::vector<StoredPixels>> stored_pixels(
    const Flight& recorded, const std::function<Result<Flight>(Flight)>& mend);

}  // namespace watersky::study
