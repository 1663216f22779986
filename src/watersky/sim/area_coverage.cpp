// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "watersky/sim/sea.hpp"

namespace watersky::sim {

AreaCoverage::AreaCoverage(cv::Size cells)
    : change_(cv::Mat::zeros(cells.height, cells.width + 1, CV_64F)) {}

void AreaCoverage::add(const Outline& outline) {
  const double sign = signed_area_m2(outline) > 0.0 ? 1.0 : -1.0;
  for (std::size_t i = 0; i < outline.size(); ++i)
    add_edge(outline[i], outline[(i + 1) % outline.size()], sign);
}

// An edge covers, in each row it passes, what lies to its right (Green's theorem): the share of
// the cells it crosses and all of the cells behind them. Each part between two grid lines adds
// its trapezoid to its own cell and the rest of its height to the next.
void AreaCoverage::add_edge(Eigen::Vector2d a, Eigen::Vector2d b, double sign) {
  const double rows = change_.rows, columns = change_.cols - 1;
  if (a.y() == b.y()) return;
  if (a.y() > b.y()) {
    std::swap(a, b);
    sign = -sign;
  }
  if (b.y() <= 0.0 || a.y() >= rows) return;
  const double slope = (b.x() - a.x()) / (b.y() - a.y());
  const double y_begin = std::max(a.y(), 0.0), y_end = std::min(b.y(), rows);
  for (int row = static_cast<int>(y_begin); row < y_end; ++row) {
    double* change = change_.ptr<double>(row);
    const double y0 = std::max<double>(y_begin, row), y1 = std::min<double>(y_end, row + 1);
    const double height = sign * (y1 - y0);
    const double x0 = a.x() + (y0 - a.y()) * slope, x1 = a.x() + (y1 - a.y()) * slope;
    const double left = std::min(x0, x1), right = std::max(x0, x1);
    if (left >= columns) continue;
    if (right <= 0.0) {
      change[0] += height;
      continue;
    }
    const double width = right - left;
    if (left < 0.0) change[0] += height * (-left / width);
    const double begin = std::max(left, 0.0), end = std::min(right, columns);
    int column = static_cast<int>(begin);
    do {
      const double low = std::max<double>(begin, column), high = std::min<double>(end, column + 1);
      const double part = width > 0.0 ? height * ((high - low) / width) : height;
      const double covered = part * (column + 1 - 0.5 * (low + high));
      change[column] += covered;
      change[column + 1] += part - covered;
      ++column;
    } while (column < end);
  }
}

cv::Mat AreaCoverage::share() const {
  cv::Mat share(change_.rows, change_.cols - 1, CV_32F);
  for (int r = 0; r < share.rows; ++r) {
    double sum = 0.0;
    for (int c = 0; c < share.cols; ++c) {
      sum += change_.at<double>(r, c);
      share.at<float>(r, c) = static_cast<float>(std::clamp(std::abs(sum), 0.0, 1.0));
    }
  }
  return share;
}

}  // namespace watersky::sim
