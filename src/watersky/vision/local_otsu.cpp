// SPDX-License-Identifier: MIT
#include "watersky/vision/local_otsu.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "watersky/vision/detail/image.hpp"

namespace watersky {
namespace {

/// A histogram that pixels enter and leave, with its sums.
class SlidingHistogram {
 public:
  void add(int level) {
    ++counts_[static_cast<std::size_t>(level)];
    ++pixels_;
    sum_ += level;
  }
  void remove(int level) {
    --counts_[static_cast<std::size_t>(level)];
    --pixels_;
    sum_ -= level;
  }

  struct Split {
    int level = 0;
    double contrast = 0.0;
  };
  /// Otsu's split; the mean level without contrast when there is one level only.
  [[nodiscard]] Split split(int lowest, int highest) const {
    if (pixels_ == 0) return {};
    Split best{static_cast<int>(sum_ / pixels_), 0.0};
    double most = 0.0;
    const auto n = static_cast<double>(pixels_), sum = static_cast<double>(sum_);
    long below = 0, sum_below = 0;
    for (int level = lowest; level < highest; ++level) {
      const int count = counts_[static_cast<std::size_t>(level)];
      if (count == 0) continue;
      below += count;
      sum_below += static_cast<long>(level) * count;
      if (below == pixels_) break;
      // n² times the between-class variance: (n s_b - n_b s)² / (n_b (n - n_b)).
      const auto b = static_cast<double>(below);
      const double difference = n * static_cast<double>(sum_below) - b * sum;
      const double between = difference * difference / (b * (n - b));
      if (between > most) {
        most = between;
        const auto s = static_cast<double>(sum_below);
        best = {level, (sum - s) / (n - b) - s / b};
      }
    }
    return best;
  }

 private:
  std::array<int, 256> counts_{};
  long pixels_ = 0;
  long sum_ = 0;
};

}  // namespace

LocalThresholds local_otsu_thresholds(const cv::Mat& gray, const cv::Mat& valid,
                                      const LocalWindow& window, int stride_px) {
  WATERSKY_REQUIRE(gray.type() == CV_8UC1 && stride_px >= 1 && window.radius_px >= 0);
  const int radius = window.radius_px;
  const int rows = (gray.rows + stride_px - 1) / stride_px;
  const int cols = (gray.cols + stride_px - 1) / stride_px;
  LocalThresholds out{cv::Mat(rows, cols, CV_8U), cv::Mat(rows, cols, CV_32F)};
  if (gray.empty()) return out;
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(gray, &least, &most, nullptr, nullptr, valid);
  const int lowest = static_cast<int>(least), highest = static_cast<int>(most);

  // How far the window reaches sideways in each of its rows.
  const int window_rows = 2 * radius + 1;
  std::vector<int> reach(static_cast<std::size_t>(window_rows), radius);
  const auto reach_in = [&](int dy) -> int& {
    const int window_row = dy + radius;
    return reach[static_cast<std::size_t>(window_row)];
  };
  if (!window.square)
    for (int dy = -radius; dy <= radius; ++dy) {
      int& r = reach_in(dy);
      while (r * r + dy * dy > radius * radius) --r;
    }
  for (int row = 0; row < rows; ++row) {
    const int y = row * stride_px;
    const int top = std::max(-radius, -y), bottom = std::min(radius, gray.rows - 1 - y);
    SlidingHistogram histogram;
    const auto column_of = [&](int dy, int x, auto&& change) {
      if (x < 0 || x >= gray.cols || (!valid.empty() && !valid.ptr(y + dy)[x])) return;
      change(gray.ptr(y + dy)[x]);
    };
    const auto add = [&](int level) { histogram.add(level); };
    const auto remove = [&](int level) { histogram.remove(level); };
    for (int dy = top; dy <= bottom; ++dy) {
      const int r = std::min(reach_in(dy), gray.cols - 1);
      for (int x = 0; x <= r; ++x) column_of(dy, x, add);
    }
    for (int x = 0;; ++x) {
      if (x % stride_px == 0) {
        const auto split = histogram.split(lowest, highest);
        out.level.at<unsigned char>(row, x / stride_px) = static_cast<unsigned char>(split.level);
        out.contrast.at<float>(row, x / stride_px) = static_cast<float>(split.contrast);
        if (x / stride_px == cols - 1) break;
      }
      for (int dy = top; dy <= bottom; ++dy) {
        const int r = reach_in(dy);
        column_of(dy, x - r, remove);
        column_of(dy, x + 1 + r, add);
      }
    }
  }
  return out;
}

LocalOtsuSegmenter::LocalOtsuSegmenter(const LocalOtsuParameters& parameters,
                                       const TwoClassEvidence& evidence, IcePolarity ice)
    : TwoClassSegmenter(evidence, ice), parameters_(parameters) {
  WATERSKY_REQUIRE(validate(parameters).ok());
}

cv::Mat LocalOtsuSegmenter::bright(const Frame& frame) const {
  const bool deep = frame.gray.depth() != CV_8U;
  const double scale = deep && frame.high > frame.low ? 255.0 / (frame.high - frame.low) : 1.0;
  const auto level_8 = [&](double level) { return deep ? (level - frame.low) * scale : level; };
  const cv::Mat gray = detail::to_8_bit(frame.gray, frame.low, frame.high);
  const LocalThresholds local = local_otsu_thresholds(
      gray, frame.valid, {parameters_.radius_px, parameters_.square}, parameters_.stride_px);

  const double threshold = level_8(frame.flight_threshold.value_or(frame.threshold));
  // One class alone, of Gaussian noise, is cut into halves 1.6 of its sigmas apart.
  constexpr double kAboveNoise = 2.0;
  const double contrast = scale * (frame.bright - frame.dark);
  cv::Scalar mean, sigma;
  cv::meanStdDev(gray, mean, sigma,
                 frame.valid.empty() ? cv::noArray() : cv::InputArray(frame.valid));
  const double f = std::clamp((mean[0] - level_8(frame.dark)) / contrast, 0.0, 1.0);
  const double noise =
      std::sqrt(std::max(0.0, sigma[0] * sigma[0] - f * (1.0 - f) * contrast * contrast));
  const double least = std::max(parameters_.least_contrast * contrast, kAboveNoise * noise);
  cv::Mat levels(local.level.size(), CV_32F);
  for (int row = 0; row < levels.rows; ++row)
    for (int col = 0; col < levels.cols; ++col)
      levels.at<float>(row, col) =
          local.contrast.at<float>(row, col) < static_cast<float>(least)
              ? static_cast<float>(threshold)
              // A bright level lies above it by a whole one: halfway, so that either may move.
              : static_cast<float>(local.level.at<unsigned char>(row, col)) + 0.5F;

  cv::Mat bright(gray.size(), CV_8U);
  const int stride = parameters_.stride_px;
  std::vector<float> row_levels(static_cast<std::size_t>(levels.cols));
  for (int y = 0; y < gray.rows; ++y) {
    const int above = y / stride, below = std::min(above + 1, levels.rows - 1);
    const float down = static_cast<float>(y % stride) / static_cast<float>(stride);
    for (int col = 0; col < levels.cols; ++col)
      row_levels[static_cast<std::size_t>(col)] =
          (1.0F - down) * levels.at<float>(above, col) + down * levels.at<float>(below, col);
    const unsigned char* in = gray.ptr(y);
    unsigned char* out = bright.ptr(y);
    for (int x = 0; x < gray.cols; ++x) {
      const auto left = static_cast<std::size_t>(x / stride);
      const std::size_t right = std::min(left + 1, row_levels.size() - 1);
      const float along = static_cast<float>(x % stride) / static_cast<float>(stride);
      const float level = (1.0F - along) * row_levels[left] + along * row_levels[right];
      out[x] = static_cast<float>(in[x]) > level ? 255 : 0;
    }
  }
  return bright;
}

}  // namespace watersky
