// SPDX-License-Identifier: MIT
#include "watersky/io/pyramid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "watersky/base/contract.hpp"

namespace watersky {

namespace {

template <class T>
cv::Mat thinned(const cv::Mat& raster) {
  cv::Mat half((raster.rows + 1) / 2, (raster.cols + 1) / 2, raster.type());
  for (int r = 0; r < half.rows; ++r) {
    const T* from = raster.ptr<T>(2 * r);
    T* to = half.ptr<T>(r);
    for (int c = 0; c < half.cols; ++c) to[c] = from[2 * c];
  }
  return half;
}

cv::Mat mean_of_known(const cv::Mat& raster) {
  cv::Mat half((raster.rows + 1) / 2, (raster.cols + 1) / 2, CV_32F);
  const int last = raster.cols - 1;
  for (int r = 0; r < half.rows; ++r) {
    const float* upper = raster.ptr<float>(2 * r);
    // At an odd border the last cells count twice, which does not change their mean.
    const float* lower = raster.ptr<float>(std::min(2 * r + 1, raster.rows - 1));
    float* to = half.ptr<float>(r);
    for (int c = 0; c < half.cols; ++c) {
      const int left = 2 * c;
      const int right = std::min(2 * c + 1, last);
      const float cells[4] = {upper[left], upper[right], lower[left], lower[right]};
      float sum = 0;
      float count = 0;
      for (const float p : cells) {
        const bool known = p == p;
        sum += known ? p : 0.0F;
        count += known ? 1.0F : 0.0F;
      }
      to[c] = count > 0 ? sum / count : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return half;
}

/// The mean of four pixels, two channels at a time in one word.
std::uint32_t mean_of_four(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  constexpr std::uint32_t kPair = 0x00ff00ff;
  constexpr std::uint32_t kHalf = 0x00020002;
  const std::uint32_t even = (a & kPair) + (b & kPair) + (c & kPair) + (d & kPair) + kHalf;
  const std::uint32_t odd =
      ((a >> 8) & kPair) + ((b >> 8) & kPair) + ((c >> 8) & kPair) + ((d >> 8) & kPair) + kHalf;
  return ((even >> 2) & kPair) | (((odd >> 2) & kPair) << 8);
}

/// The same of those that were seen.
std::uint32_t mean_of_seen(const std::array<std::uint32_t, 4>& cells) {
  std::array<std::uint32_t, 3> sum{};
  std::uint32_t count = 0;
  for (const std::uint32_t cell : cells) {
    if ((cell >> 24) == 0) continue;
    for (unsigned channel = 0; channel < 3; ++channel)
      sum[channel] += (cell >> (8 * channel)) & 255;
    ++count;
  }
  if (count == 0) return 0;
  return sum[0] / count | (sum[1] / count) << 8 | (sum[2] / count) << 16 | 0xff000000U;
}

cv::Mat mean_color(const cv::Mat& bgra) {
  cv::Mat half((bgra.rows + 1) / 2, (bgra.cols + 1) / 2, CV_8UC4);
  const int last = bgra.cols - 1;
  for (int r = 0; r < half.rows; ++r) {
    const auto* upper = bgra.ptr<std::uint32_t>(2 * r);
    const auto* lower = bgra.ptr<std::uint32_t>(std::min(2 * r + 1, bgra.rows - 1));
    auto* to = half.ptr<std::uint32_t>(r);
    for (int c = 0; c < half.cols; ++c) {
      const int left = 2 * c;
      const int right = std::min(2 * c + 1, last);
      const std::array<std::uint32_t, 4> cells = {upper[left], upper[right], lower[left],
                                                  lower[right]};
      const bool all = ((cells[0] & cells[1] & cells[2] & cells[3]) >> 24) == 255;
      to[c] = all ? mean_of_four(cells[0], cells[1], cells[2], cells[3]) : mean_of_seen(cells);
    }
  }
  return half;
}

}  // namespace

cv::Mat halved(const cv::Mat& raster) {
  switch (raster.type()) {
    case CV_32F: return mean_of_known(raster);
    case CV_8UC4: return mean_color(raster);
    case CV_8U: return thinned<std::uint8_t>(raster);
    case CV_16U: return thinned<std::uint16_t>(raster);
    default: WATERSKY_REQUIRE(raster.type() == CV_64F); return thinned<double>(raster);
  }
}

std::vector<cv::Mat> pyramid(const cv::Mat& raster, int max_side) {
  std::vector<cv::Mat> levels;
  cv::Mat level = raster;
  while (std::max(level.cols, level.rows) > max_side) {
    level = halved(level);
    levels.push_back(level);
  }
  return levels;
}

}  // namespace watersky
