// SPDX-License-Identifier: MIT
#pragma once
/// A frame with its noise averaged away: what a histogram must be taken from when contrast is
/// only a few times the noise.
#include <opencv2/core/mat.hpp>
#include <optional>

namespace watersky::detail {

struct CoarseView {
  cv::Mat level;  ///< CV_32F, gray levels of the frame
  cv::Mat valid;  ///< CV_8U; empty: all valid
  double median = 0.0;
  double low = 0.0, high = 0.0;  ///< all but 0.05 % lies above, below
  double threshold = 0.0;        ///< Otsu's, of the coarse levels
  double dark = 0.0;             ///< mean level at or below the threshold
  double bright = 0.0;           ///< mean level above it
  double bright_fraction = 0.0;
  /// The classes lie further apart than the halves of one would, hold together as areas, and
  /// have edges between them: neither noise nor shading cut in half.
  bool two_classes = false;
};

/// When pixels of which none is like its neighbours, dead and hot ones, are taken out: Before the
/// frame is reduced keeps shapes as they are; After costs half the time (bench/segment) and is
/// good enough for levels.
enum class Cleaned { Before, After };

/// `gray`: CV_8UC1 or CV_16UC1. Without any valid pixel `level` is empty.
[[nodiscard]] CoarseView coarse_view(const cv::Mat& gray, const cv::Mat& valid,
                                     Cleaned cleaned = Cleaned::Before);

/// Mean levels of two classes.
struct TwoLevels {
  double dark = 0.0, bright = 0.0;
};

/// What CoarseView::two_classes says of a frame that somebody else averaged already, over `reduced`
/// x `reduced` of its pixels, and of Otsu's threshold: without histogram or blur. nullopt: it does
/// not show two classes. `level`: CV_32FC1, `valid` CV_8U or empty, both continuous.
[[nodiscard]] std::optional<TwoLevels> two_classes_of(const cv::Mat& level, const cv::Mat& valid,
                                                      double threshold, int reduced);

/// Otsu's split of 256 equal bins.
struct Split {
  int last_dark_bin = 0;
  double dark_bin = 0.0, bright_bin = 0.0;  ///< class means, in bins
  double bright_fraction = 0.0;
  double separation = 0.0;  ///< between the means, in within-class sigmas
  bool two_modes = false;   ///< separated, with a clear valley between
};
[[nodiscard]] Split split_bins(const double (&counts)[256]);

}  // namespace watersky::detail
