// SPDX-License-Identifier: MIT
#include "watersky/io/pyramid.hpp"

#include <algorithm>
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

cv::Mat mean_color(const cv::Mat& bgra) {
  cv::Mat half((bgra.rows + 1) / 2, (bgra.cols + 1) / 2, CV_8UC4);
  const int last = bgra.cols - 1;
  for (int r = 0; r < half.rows; ++r) {
    const cv::Vec4b* upper = bgra.ptr<cv::Vec4b>(2 * r);
    const cv::Vec4b* lower = bgra.ptr<cv::Vec4b>(std::min(2 * r + 1, bgra.rows - 1));
    cv::Vec4b* to = half.ptr<cv::Vec4b>(r);
    for (int c = 0; c < half.cols; ++c) {
      const int left = 2 * c;
      const int right = std::min(2 * c + 1, last);
      const cv::Vec4b cells[4] = {upper[left], upper[right], lower[left], lower[right]};
      int blue = 0;
      int green = 0;
      int red = 0;
      int count = 0;
      for (const cv::Vec4b& x : cells) {
        const int seen = x[3] != 0 ? 1 : 0;
        blue += seen * x[0];
        green += seen * x[1];
        red += seen * x[2];
        count += seen;
      }
      if (count == 4) {
        to[c] = cv::Vec4b(static_cast<std::uint8_t>((blue + 2) / 4), static_cast<std::uint8_t>((green + 2) / 4),
                          static_cast<std::uint8_t>((red + 2) / 4), 255);
      } else if (count > 0) {
        to[c] = cv::Vec4b(static_cast<std::uint8_t>(blue / count), static_cast<std::uint8_t>(green / count),
                          static_cast<std::uint8_t>(red / count), 255);
      } else {
        to[c] = cv::Vec4b(0, 0, 0, 0);
      }
    }
  }
  return half;
}

}  // namespace

cv::Mat halved(const cv::Mat& raster) {
  switch (raster.type()) {
    case CV_32F: return mean_of_known(raster);
    case CV_8UC4: return mean_color(raster);
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
