// SPDX-License-Identifier: MIT
#include "watersky/ice/detail/caliper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace watersky::ice::detail {

namespace {
double twice_area(cv::Point a, cv::Point b, cv::Point c) {
  return std::abs(static_cast<double>(b.x - a.x) * (c.y - a.y) -
                  static_cast<double>(b.y - a.y) * (c.x - a.x));
}
double distance(cv::Point a, cv::Point b) { return std::hypot(a.x - b.x, a.y - b.y); }
}  // namespace

Caliper caliper(const std::vector<cv::Point>& points) {
  std::vector<cv::Point> hull;
  cv::convexHull(points, hull);
  Caliper result;
  const std::size_t n = hull.size();
  if (n < 3) return result;
  result.width = std::numeric_limits<double>::infinity();
  std::size_t j = 1;
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point a = hull[i];
    const cv::Point b = hull[(i + 1) % n];
    result.length = std::max(result.length, std::max(distance(a, hull[j]), distance(b, hull[j])));
    // Equal heights are walked over as well: with parallel edges the far corner lies behind.
    for (std::size_t steps = 0; steps < n; ++steps) {
      const std::size_t next = (j + 1) % n;
      if (twice_area(a, b, hull[next]) < twice_area(a, b, hull[j])) break;
      j = next;
      result.length = std::max(result.length, std::max(distance(a, hull[j]), distance(b, hull[j])));
    }
    result.width = std::min(result.width, twice_area(a, b, hull[j]) / distance(a, b));
    if (i > 0) result.hull_area += 0.5 * twice_area(hull[0], a, b);
  }
  return result;
}

}  // namespace watersky::ice::detail
