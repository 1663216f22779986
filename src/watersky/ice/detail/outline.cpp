// SPDX-License-Identifier: MIT
#include "watersky/ice/detail/outline.hpp"

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace watersky::ice::detail {

namespace {

constexpr std::uint8_t kTraced = 254;

// East, south, west, north: turning right is +1. For each heading, the cell ahead on the left
// and on the right as seen from a corner, relative to the corner's own cell (its south-east).
constexpr int kStepX[4] = {1, 0, -1, 0};
constexpr int kStepY[4] = {0, 1, 0, -1};
constexpr int kLeftX[4] = {0, 0, -1, -1};
constexpr int kLeftY[4] = {-1, 0, 0, -1};
constexpr int kRightX[4] = {0, -1, -1, 0};
constexpr int kRightY[4] = {0, 0, -1, -1};
constexpr int kWest = 2;

class Tracer {
 public:
  Tracer(cv::Mat& ice, const cv::Mat& pieces, std::vector<CornerRing>& rings)
      : ice_(ice), pieces_(pieces), rings_(rings), stride_(static_cast<std::ptrdiff_t>(ice.step)) {}

  /// From the north-west corner of a cell whose north edge is the line's first in reading
  /// order, so that the line turns there. Walks with ice on the left and keeps to the same
  /// 4-connected piece where two pieces meet at a corner.
  void trace(int x0, int y0) {
    piece_ = pieces_.at<int>(y0, x0);
    line_.clear();
    meetings_.clear();
    seen_.clear();
    int x = x0;
    int y = y0;
    int heading = kWest;
    mark(x0, y0);
    do {
      const std::uint8_t* here = ice_.data + y * stride_ + x;
      const bool left = here[kLeftY[heading] * stride_ + kLeftX[heading]] != 0;
      const bool right = here[kRightY[heading] * stride_ + kRightX[heading]] != 0;
      if (!left) {
        if (right) part_at({x, y});
        line_.push_back({x, y});
        heading = (heading + 3) & 3;
      } else if (right) {
        line_.push_back({x, y});
        heading = (heading + 1) & 3;
      }
      x += kStepX[heading];
      y += kStepY[heading];
      if (heading == kWest) mark(x, y);
    } while (x != x0 || y != y0 || heading != kWest);
    emit(std::exchange(line_, {}));
  }

 private:
  void mark(int x, int y) { ice_.at<std::uint8_t>(y, x) = kTraced; }

  /// At a corner where ice meets ice diagonally: when the line has been here before, what it
  /// ran since is a closed line of its own.
  void part_at(cv::Point corner) {
    const std::int64_t key = static_cast<std::int64_t>(corner.y) * ice_.cols + corner.x;
    const auto [found, is_new] = seen_.try_emplace(key, line_.size());
    if (is_new) {
      meetings_.push_back(key);
      return;
    }
    const std::size_t first = found->second;
    while (meetings_.back() != key) {
      seen_.erase(meetings_.back());
      meetings_.pop_back();
    }
    emit({line_.begin() + static_cast<std::ptrdiff_t>(first), line_.end()});
    line_.resize(first);
  }

  void emit(std::vector<cv::Point> corners) {
    CornerRing ring;
    ring.piece = piece_;
    double twice_area = 0;
    cv::Point previous = corners.back();
    for (const cv::Point& p : corners) {
      // Rows run south, so the sign is the other way round.
      twice_area += static_cast<double>(p.x) * previous.y - static_cast<double>(previous.x) * p.y;
      ring.edge_cells += std::abs(p.x - previous.x) + std::abs(p.y - previous.y);
      previous = p;
    }
    ring.signed_area_cells = 0.5 * twice_area;
    ring.corners = std::move(corners);
    rings_.push_back(std::move(ring));
  }

  cv::Mat& ice_;
  const cv::Mat& pieces_;
  std::vector<CornerRing>& rings_;
  std::ptrdiff_t stride_;
  int piece_ = 0;
  std::vector<cv::Point> line_;
  std::unordered_map<std::int64_t, std::size_t> seen_;  ///< meeting corner → place in line_
  std::vector<std::int64_t> meetings_;                  ///< in the order of line_
};

}  // namespace

std::vector<CornerRing> trace_outlines(cv::Mat& ice, const cv::Mat& pieces) {
  std::vector<CornerRing> rings;
  Tracer tracer(ice, pieces, rings);
  for (int y = 1; y < ice.rows; ++y) {
    const std::uint8_t* above = ice.ptr<std::uint8_t>(y - 1);
    const std::uint8_t* here = ice.ptr<std::uint8_t>(y);
    for (int x = 1; x < ice.cols; ++x)
      if (here[x] == 255 && above[x] == 0) tracer.trace(x, y);
  }
  return rings;
}

}  // namespace watersky::ice::detail
