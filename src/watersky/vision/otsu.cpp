// SPDX-License-Identifier: MIT
#include "watersky/vision/otsu.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "watersky/vision/detail/image.hpp"

namespace watersky {
namespace {

constexpr int kBins = 65536;

/// Adds an image's levels to a histogram that has room for all of them.
template <class Level>
void count_levels(const cv::Mat& gray, const cv::Mat& valid, std::vector<std::uint32_t>& bins) {
  for (int y = 0; y < gray.rows; ++y) {
    const Level* row = gray.ptr<Level>(y);
    const unsigned char* shown = valid.empty() ? nullptr : valid.ptr(y);
    for (int x = 0; x < gray.cols; ++x)
      if (!shown || shown[x]) ++bins[row[x]];
  }
}

/// Neighbours are alike, and adding to the bin that was added to just now must wait for it: four
/// histograms by turns take half the time (bench/segment).
void count_levels(const cv::Mat& gray, std::vector<std::uint32_t>& bins) {
  std::array<std::array<std::uint32_t, 256>, 4> turns{};
  for (int y = 0; y < gray.rows; ++y) {
    const unsigned char* row = gray.ptr(y);
    int x = 0;
    for (; x + 4 <= gray.cols; x += 4)
      for (std::size_t i = 0; i < 4; ++i) ++turns[i][row[x + static_cast<int>(i)]];
    for (; x < gray.cols; ++x) ++turns[0][row[x]];
  }
  for (const auto& turn : turns)
    for (std::size_t i = 0; i < turn.size(); ++i) bins[i] += turn[i];
}

}  // namespace

OtsuThreshold otsu_threshold(std::span<const std::uint32_t> histogram) {
  OtsuThreshold result;
  double n = 0.0, sum = 0.0, square = 0.0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    const double count = histogram[i], level = static_cast<double>(i);
    n += count;
    sum += level * count;
    square += level * level * count;
  }
  if (n == 0.0) return result;
  double below = 0.0, sum_below = 0.0, best = 0.0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    if (histogram[i] == 0) continue;
    below += histogram[i];
    sum_below += static_cast<double>(i) * histogram[i];
    const double above = n - below;
    if (above <= 0.0) break;
    const double difference = sum_below / below - (sum - sum_below) / above;
    const double between = below * above * difference * difference;
    if (between > best) {
      best = between;
      result = {static_cast<int>(i), 0.0, sum_below / below, (sum - sum_below) / above, above / n};
    }
  }
  if (best > 0.0) {
    result.separability = std::min(1.0, best / (n * square - sum * sum));
  } else {
    result.dark_mean = result.bright_mean = sum / n;
    result.level = static_cast<int>(sum / n);
  }
  return result;
}

Result<OtsuThreshold> otsu_threshold(const cv::Mat& gray, const cv::Mat& valid) {
  WATERSKY_CHECK(detail::check_image(gray, valid));
  if (gray.channels() != 1) return Error{ErrorCode::Unsupported, "image has 3 channels; give one"};
  std::vector<std::uint32_t> bins(gray.depth() == CV_8U ? 256 : kBins);
  if (gray.depth() == CV_8U && valid.empty())
    count_levels(gray, bins);
  else if (gray.depth() == CV_8U)
    count_levels<unsigned char>(gray, valid, bins);
  else
    count_levels<unsigned short>(gray, valid, bins);
  if (!valid.empty() && cv::countNonZero(valid) == 0)
    return Error{ErrorCode::InvalidInput, "image has no valid pixel: nothing to threshold"};
  return otsu_threshold(bins);
}

cv::Mat OtsuSegmenter::bright(const Frame& frame) const {
  double level = 0.0;
  if (frame.flight_threshold) {
    level = std::floor(*frame.flight_threshold);
  } else {
    const auto otsu = otsu_threshold(frame.gray, frame.valid);
    WATERSKY_REQUIRE(otsu.ok());
    level = otsu->level;
  }
  return frame.gray > level;
}

}  // namespace watersky
