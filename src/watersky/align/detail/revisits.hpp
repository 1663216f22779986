// SPDX-License-Identifier: MIT
#pragma once
/// Places seen again when the flight returns.
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "watersky/align/detail/tracker.hpp"

namespace watersky::align {

/// A frame that may be looked at again.
struct Revisitable {
  int frame = 0;
  double t_s = 0.0;
  Eigen::Vector2d middle_m;  ///< where its picture's middle lies on the sea
  double reach_m = 0.0;      ///< half of the smaller side of what it sees
};

struct RevisitPair {
  int a = 0, b = 0;  ///< a earlier
};

/// Pairs that overlap by their places, apart in time by at least `apart_s`: for each frame the
/// nearest few, not all of one pass; evenly thinned to `most`.
[[nodiscard]] std::vector<RevisitPair> revisit_pairs(const std::vector<Revisitable>& frames,
                                                     double apart_s, std::size_t most);

/// Full-size pixels of one place in both frames.
struct PixelPair {
  Eigen::Vector2d a, b;
};

/// Finds places of `a` in `b`, where the poses put them by `b_from_a` (full-size pixels), give or
/// take `reach_px`; by registration, or, where too little is shared for that, place by place, if
/// they agree among themselves. Pictures are 8 or 16 bit, gray, reduced by `reduction`.
[[nodiscard]] std::vector<PixelPair> find_again(const cv::Mat& a, const cv::Mat& b, int reduction,
                                                const Eigen::Matrix3d& b_from_a, double reach_px,
                                                const Registrar& registrar, int most);

}  // namespace watersky::align
