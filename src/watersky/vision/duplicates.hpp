// SPDX-License-Identifier: MIT
#pragma once
/// Frames that were recorded twice: a video faster than its camera, a frame grabber, a link.
///
/// The thesis (4.1) takes the L2 norm of the difference and the Hellinger distance of the
/// histograms, and drops what is closer than 0.03. A histogram cannot tell two views of uniform
/// ice apart, so here a frame must also agree in its pixels. What tells them apart:
///
/// - Two captures of one scene carry noise of their own, everywhere. Where a picture is flattest,
///   its finest detail is noise, and between two captures that noise does not correlate.
/// - A frame that was encoded twice differs by the codec's residue. A codec spends little on
///   flat places (they come out smooth or unchanged) and keeps what is coarser than its blocks'
///   finest detail, so that the coarse detail of the two correlates almost fully.
/// - A moving camera shifts the picture; a codec does not.
///
/// A frame without detail (saturated, shutter closed, all noise quantised away) can be told from
/// nothing and is never called a duplicate. One thing nobody can tell: a codec that has thrown
/// away noise and shake alike makes two captures into one picture twice; they carry one picture's
/// evidence, and count as a duplicate if it shows any detail.
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

/// ‖b - a‖ over all pixels and channels. InvalidInput when size or type differ.
[[nodiscard]] Result<double> l2_norm(const cv::Mat& a, const cv::Mat& b);

/// (4.1): the Hellinger distance of the gray histograms in 256 bins, in [0, 1]; OpenCV calls it
/// HISTCMP_BHATTACHARYYA. Bins are gray levels for 8 bit, equal parts of the range that the two
/// images span for 16 bit. InvalidInput when size or type differ, Unsupported for other types.
[[nodiscard]] Result<double> hellinger_distance(const cv::Mat& a, const cv::Mat& b);

/// What of a frame is kept to compare the next ones with: the gray levels of up to 512 blocks of
/// 16 x 16 pixels, spread evenly.
class FrameSample {
 public:
  /// 8 or 16 bit, 1 or 3 (BGR) channels, else Unsupported; InvalidInput below 32 x 32 pixels.
  [[nodiscard]] static Result<FrameSample> of(const cv::Mat& image);

  static constexpr int kBlock_px = 16;

 private:
  friend struct SampleComparison;
  int cols_ = 0, rows_ = 0, depth_ = 0;
  std::vector<std::uint16_t> blocks_;  ///< block after block, row by row
};

/// How a frame differs from another, and what follows.
struct FrameDifference {
  double hellinger = 0.0;  ///< of the histograms, see hellinger_distance()
  double rms = 0.0;        ///< L2 norm over the root of the number of pixels, gray levels
  double shift_px = 0.0;   ///< how far the picture moved, to first order; 0 where not needed
  double coarse_correlation = 0.0;  ///< of detail at 4 to 16 px; 1: the same
  double noise_correlation = 0.0;   ///< of pixel to pixel detail in the flattest blocks
  bool enough_detail = false;       ///< to tell at all
  bool duplicate = false;
};

/// InvalidInput when the frames differ in size or depth.
[[nodiscard]] Result<FrameDifference> compare(const FrameSample& earlier, const FrameSample& later);

/// Frames go in in order; each is compared with the last one that was kept, so that a camera that
/// drifts slowly is not lost.
class DuplicateFilter {
 public:
  /// Whether `sample` repeats the last frame kept; it becomes that frame if not. The first frame,
  /// and one of another size, is kept: nullopt.
  std::optional<FrameDifference> judge(FrameSample sample);

 private:
  std::optional<FrameSample> kept_;
};

}  // namespace watersky
