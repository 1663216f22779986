// SPDX-License-Identifier: MIT
#pragma once
/// One scale of the KLT registrar: a rough homography in, a fine one out, and whether the
/// pictures agree under it.
#include <optional>
#include <span>

#include "watersky/registration/detail/view.hpp"

namespace watersky::detail {

struct TrackingOptions {
  double threshold_px = 1.5;  ///< MAGSAC++'s, in pixels of B's view
  /// Where a sensor's fixed pattern would seem to go: from view to view of an unmoved camera.
  std::optional<Eigen::Matrix3d> still;
};

struct Tracked {
  std::size_t tried = 0;           ///< corners that the start puts into B
  std::vector<PointPair> matches;  ///< those whose windows agree, in pixels of the views
  std::optional<HomographyFit> fit;
};

/// From a start some ten pixels off: B is drawn as A would see it, so that windows are alike
/// whatever the turn, and the corners are followed down a pyramid.
[[nodiscard]] Tracked track_far(const View& a, const View& b, std::span<const cv::Point2f> corners,
                                const Eigen::Matrix3d& start, const TrackingOptions& options);

/// From a start a pixel or two off, both ways, in the pixels as they are: windows are compared
/// less their means and gains, so the pictures (CV_32FC1) need no preparing.
[[nodiscard]] Tracked track_near(const cv::Mat& a, const cv::Mat& b,
                                 std::span<const cv::Point2f> corners, const Eigen::Matrix3d& start,
                                 const TrackingOptions& options);

/// How alike two views are under a homography.
struct Agreement {
  double correlation = 0.0;     ///< of the normalised views where A shows texture, -1 to 1
  double chance = 1.0;          ///< sigma of that between pictures of different places
  double overlap = 0.0;         ///< share of A's pixels
  double patches_agreeing = 0;  ///< share of patches of the overlap that correlate by themselves
  int patches = 0;              ///< looked at
};
[[nodiscard]] Agreement agreement(const View& a, const View& b, const Eigen::Matrix3d& b_from_a);

}  // namespace watersky::detail
