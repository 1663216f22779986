// SPDX-License-Identifier: MIT
#pragma once
/// Length and width of a set of points.
#include <opencv2/core/types.hpp>
#include <vector>

namespace watersky::ice::detail {

struct Caliper {
  double length = 0.0;     ///< the largest distance between two points
  double width = 0.0;      ///< the smallest distance between two parallel lines that hold all
  double hull_area = 0.0;  ///< of the convex hull
};

/// By rotating calipers on the convex hull: exact. Points must not all lie on one line.
[[nodiscard]] Caliper caliper(const std::vector<cv::Point>& points);

}  // namespace watersky::ice::detail
