// SPDX-License-Identifier: MIT
#include "watersky/map/detail/polygon_span.hpp"

#include <algorithm>
#include <limits>

namespace watersky::detail {

std::pair<double, double> span_between(const std::vector<Eigen::Vector2d>& polygon, double y0,
                                       double y1) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double from = std::max(y0, std::min(a.y(), b.y()));
    const double to = std::min(y1, std::max(a.y(), b.y()));
    if (from > to) continue;
    const double dy = b.y() - a.y();
    for (const double y : {from, to}) {
      const double t = dy == 0 ? 0.0 : (y - a.y()) / dy;
      const double x = a.x() + t * (b.x() - a.x());
      low = std::min(low, x);
      high = std::max(high, x);
    }
    if (dy == 0) {
      low = std::min(low, b.x());
      high = std::max(high, b.x());
    }
  }
  return {low, high};
}

}  // namespace watersky::detail
