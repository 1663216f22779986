// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/enlarge.hpp"

#include <algorithm>

#include "watersky/vision/detail/dispatch.hpp"

namespace watersky::detail {
namespace {

/// Between two rows: `part` of the way from `above` to `below`.
WATERSKY_MULTIVERSION void blend(const float* __restrict above, const float* __restrict below,
                                 float part, int width, float* __restrict out) {
  for (int x = 0; x < width; ++x) out[x] = above[x] + part * (below[x] - above[x]);
}

/// A row of `width` values at twice as many places: a quarter and three quarters of the way.
WATERSKY_MULTIVERSION void widen(const float* __restrict row, int width, float* __restrict out) {
  out[0] = row[0];
  for (int x = 0; x + 1 < width; ++x) {
    out[2 * x + 1] = 0.75F * row[x] + 0.25F * row[x + 1];
    out[2 * x + 2] = 0.25F * row[x] + 0.75F * row[x + 1];
  }
  out[2 * width - 1] = row[width - 1];
}

}  // namespace

void enlarged_row(const cv::Mat& half, int y, float* between, float* row) {
  const int above = std::max(0, (y + 1) / 2 - 1);
  const int below = std::min((y + 1) / 2, half.rows - 1);
  blend(half.ptr<float>(above), half.ptr<float>(below), y % 2 == 0 ? 0.75F : 0.25F, half.cols,
        between);
  widen(between, half.cols, row);
}

}  // namespace watersky::detail
