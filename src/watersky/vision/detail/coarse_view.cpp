// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/coarse_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "watersky/base/contract.hpp"

namespace watersky::detail {
namespace {

/// The shorter side is averaged down to between this and twice this.
constexpr int kShortSide_px = 240;
/// Gaussian, in pixels of the frame, that averages noise over some 4 pi sigma² = 18 of them.
constexpr double kBlur_px = 1.2;
/// Means at least this many within-class sigmas apart: a Gaussian cut in half gives 2.65.
constexpr double kSeparation = 2.8;
/// Of two modes, the valley is at most this part of the lower peak.
constexpr double kValley = 0.75;
constexpr double kSmallestFraction = 0.002;
/// Across the border between classes the level changes, from kStepReach_px before it to as far
/// behind, by at least this part of their contrast: at edges it does (0.49 to 0.83 as seen), by
/// shading it does not (0.09 to 0.34).
constexpr double kStep = 0.42;
/// Correlation of the classes of pixels kLag_px apart: noise cut in half has none.
constexpr double kCoherence = 0.15;
constexpr int kStepReach_px = 3;
constexpr int kLag_px = 4;

/// Counts over pairs of pixels of one frame.
struct Pairs {
  long all = 0;      ///< kLag_px apart
  long agree = 0;    ///< of those, of one class
  long borders = 0;  ///< between neighbours of two classes
  double steps =
      0.0;  ///< change of level across those, from kStepReach_px before to kLag_px behind
};

int factor_of(cv::Size frame) {
  return std::max(1, std::min(frame.height, frame.width) / kShortSide_px);
}

/// Distances in pixels of a view.
struct Reach {
  int before;  ///< kStepReach_px
  int lag;     ///< kLag_px
};

/// Pairs (x, x + lag) along a line of pixels; the line lies in memory `stride` apart. `shown` may
/// be null. Plain loops over bytes, so that the compiler makes vectors of them (bench/segment).
void count_pairs(const float* level, const unsigned char* bright, const unsigned char* shown,
                 std::ptrdiff_t stride, const Reach& reach, int from, int to, Pairs& pairs) {
  const unsigned char* next = bright + stride;
  const unsigned char* far = bright + reach.lag * stride;
  const std::ptrdiff_t before = -reach.before * stride, behind = reach.lag * stride;
  if (shown) {
    for (int x = from; x < to; ++x) {
      if (!shown[x + before] || !shown[x] || !shown[x + behind]) continue;
      ++pairs.all;
      pairs.agree += bright[x] == far[x];
      if (bright[x] == next[x]) continue;
      ++pairs.borders;
      pairs.steps += static_cast<double>(std::abs(level[x + behind] - level[x + before]));
    }
    return;
  }
  int agree = 0, borders = 0;
  for (int x = from; x < to; ++x) {
    agree += bright[x] == far[x];
    borders += bright[x] != next[x];
  }
  pairs.all += to - from;
  pairs.agree += agree;
  pairs.borders += borders;
  if (borders == 0) return;
  for (int x = from; x < to; ++x)
    if (bright[x] != next[x])
      pairs.steps += static_cast<double>(std::abs(level[x + behind] - level[x + before]));
}

/// Whether Otsu's classes have edges between them and hold together: one walk along rows and
/// columns, over pairs of neighbours (edges) and of pixels kLag_px apart (coherence).
bool has_two_classes(const CoarseView& view, const Reach& reach) {
  const double f = view.bright_fraction, contrast = view.bright - view.dark;
  const int rows = view.level.rows, cols = view.level.cols;
  if (std::min(rows, cols) <= 2 * reach.lag || contrast <= 0.0) return false;
  const cv::Mat bright = view.level > view.threshold;
  // Made here, so without gaps between rows: all three march alike.
  WATERSKY_REQUIRE(view.level.isContinuous() && bright.isContinuous() &&
                   (view.valid.empty() || view.valid.isContinuous()));
  const std::ptrdiff_t stride = cols;
  Pairs pairs;
  // Every other row: what is asked for is a mean over thousands of pairs.
  const int step = rows >= kShortSide_px / 2 ? 2 : 1;
  for (int y = 0; y < rows; y += step) {
    const float* level = view.level.ptr<float>(y);
    const unsigned char* shown = view.valid.empty() ? nullptr : view.valid.ptr(y);
    count_pairs(level, bright.ptr(y), shown, 1, reach, reach.before, cols - reach.lag, pairs);
    if (y >= reach.before && y + reach.lag < rows)
      count_pairs(level, bright.ptr(y), shown, stride, reach, reach.before, cols - reach.lag,
                  pairs);
  }
  if (pairs.all == 0 || pairs.borders == 0) return false;
  const double chance = f * f + (1.0 - f) * (1.0 - f);
  const double alike = static_cast<double>(pairs.agree) / static_cast<double>(pairs.all);
  return (alike - chance) / (1.0 - chance) >= kCoherence &&
         pairs.steps / static_cast<double>(pairs.borders) >= kStep * contrast;
}

}  // namespace

Split split_bins(const double (&counts)[256]) {
  Split split;
  double n = 0.0, sum = 0.0, square = 0.0;
  for (int i = 0; i < 256; ++i) {
    n += counts[i];
    sum += i * counts[i];
    square += static_cast<double>(i) * i * counts[i];
  }
  if (n <= 0.0) return split;
  double below = 0.0, sum_below = 0.0, best = 0.0;
  for (int i = 0; i < 255; ++i) {
    below += counts[i];
    sum_below += i * counts[i];
    const double above = n - below;
    if (below <= 0.0 || above <= 0.0) continue;
    const double dark = sum_below / below, bright = (sum - sum_below) / above;
    const double between = below * above * (bright - dark) * (bright - dark);
    if (between > best) {
      best = between;
      split = {i, dark, bright, above / n, 0.0, false};
    }
  }
  if (best <= 0.0) return split;
  const double within = (square - sum * sum / n) / n - best / (n * n);
  const double sigma = std::sqrt(std::max(within, 1e-9));
  const double gap = split.bright_bin - split.dark_bin;
  split.separation = gap / sigma;
  if (split.separation < kSeparation) return split;
  // Density smoothed a little, to see the valley and not the dice.
  const double bandwidth = std::max(1.5, 0.3 * sigma);
  const int reach = static_cast<int>(std::ceil(3.0 * bandwidth));
  std::vector<double> kernel(static_cast<std::size_t>(reach) + 1);
  for (int k = 0; k <= reach; ++k)
    kernel[static_cast<std::size_t>(k)] = std::exp(-0.5 * k * k / (bandwidth * bandwidth));
  std::array<double, 256> density{};
  for (int i = 0; i < 256; ++i)
    for (int k = -reach; k <= reach; ++k)
      density[static_cast<std::size_t>(i)] +=
          kernel[static_cast<std::size_t>(std::abs(k))] * counts[std::clamp(i + k, 0, 255)];
  const auto first = density.begin();
  const auto cut = first + split.last_dark_bin + 1;
  const auto dark_peak = std::max_element(first, cut);
  const auto bright_peak = std::max_element(cut, density.end());
  const double valley = *std::min_element(dark_peak, bright_peak + 1);
  split.two_modes = valley <= kValley * std::min(*dark_peak, *bright_peak);
  return split;
}

std::optional<TwoLevels> two_classes_of(const cv::Mat& level, const cv::Mat& valid,
                                        double threshold, int reduced) {
  CoarseView view{.level = level, .valid = valid, .threshold = threshold};
  double n[2] = {}, sum[2] = {}, square = 0.0, all = 0.0;
  const auto middle = static_cast<float>(threshold);
  for (int y = 0; y < level.rows; ++y) {
    const float* row = level.ptr<float>(y);
    const unsigned char* shown = valid.empty() ? nullptr : valid.ptr(y);
    // Row by row in single precision: the compiler makes vectors of it.
    float above = 0.0F, sums = 0.0F, squares = 0.0F;
    int bright = 0, members = level.cols;
    if (shown) {
      members = 0;
      for (int x = 0; x < level.cols; ++x) {
        const float v = shown[x] ? row[x] - middle : 0.0F;
        members += shown[x] != 0;
        bright += v > 0.0F;
        above += v > 0.0F ? v : 0.0F;
        sums += v;
        squares += v * v;
      }
    } else {
      for (int x = 0; x < level.cols; ++x) {
        const float v = row[x] - middle;
        bright += v > 0.0F;
        above += v > 0.0F ? v : 0.0F;
        sums += v;
        squares += v * v;
      }
    }
    n[1] += bright;
    n[0] += members - bright;
    sum[1] += static_cast<double>(above);
    sum[0] += static_cast<double>(sums - above);
    all += static_cast<double>(sums);
    square += static_cast<double>(squares);
  }
  const double total = n[0] + n[1];
  if (std::min(n[0], n[1]) < std::max(1.0, kSmallestFraction * total)) return std::nullopt;
  const double dark = sum[0] / n[0], bright = sum[1] / n[1], contrast = bright - dark;
  const double within =
      (square - all * all / total) / total - n[0] * n[1] / (total * total) * contrast * contrast;
  view.dark = threshold + dark;
  view.bright = threshold + bright;
  view.bright_fraction = n[1] / total;
  if (contrast < kSeparation * std::sqrt(std::max(within, 0.0))) return std::nullopt;
  // Reduced further than a view would be, the same distances are fewer pixels.
  const double finer =
      std::min(1.0, static_cast<double>(factor_of(level.size() * reduced)) / reduced);
  const Reach reach{std::max(1, cvRound(finer * kStepReach_px)),
                    std::max(1, cvRound(finer * kLag_px))};
  if (!has_two_classes(view, reach)) return std::nullopt;
  return TwoLevels{view.dark, view.bright};
}

CoarseView coarse_view(const cv::Mat& frame, const cv::Mat& valid, Cleaned cleaned) {
  CoarseView view;
  const int factor = factor_of(frame.size());
  const cv::Size size(frame.cols / factor, frame.rows / factor);
  const cv::Rect whole(0, 0, size.width * factor, size.height * factor);
  const auto reduced = [&](const cv::Mat& image) {
    cv::Mat small;
    if (factor == 1) return image;
    cv::resize(image(whole), small, size, 0, 0, cv::INTER_AREA);
    return small;
  };
  // What the averaging over factor x factor pixels has not yet done.
  const double blur_px =
      std::sqrt(std::max(0.0, kBlur_px * kBlur_px - factor * factor / 12.0)) / factor;
  const auto blur = [&](cv::Mat& image) {
    if (blur_px > 0.25)
      cv::GaussianBlur(image, image, cv::Size(0, 0), blur_px, blur_px, cv::BORDER_REFLECT);
  };
  if (valid.empty()) {
    // Blurring would spread each dead or hot pixel to a spot.
    cv::Mat clean;
    if (cleaned == Cleaned::Before) {
      cv::medianBlur(frame, clean, 3);
      clean = reduced(clean);
    } else {
      cv::medianBlur(reduced(frame), clean, 3);
    }
    clean.convertTo(view.level, CV_32F);
    blur(view.level);
  } else {
    // Mean over the valid pixels only: blurred levels over blurred validity.
    cv::Mat gray, masked, weight;
    cv::medianBlur(frame, gray, 3);
    gray.copyTo(masked, valid);
    reduced(masked).convertTo(view.level, CV_32F);
    cv::Mat shown = valid != 0;
    reduced(shown).convertTo(weight, CV_32F, 1.0 / 255.0);
    blur(view.level);
    blur(weight);
    view.valid = weight > 0.5;
    cv::divide(view.level, cv::max(weight, 0.5), view.level);
  }

  double least = 0.0, most = 0.0;
  if (!view.valid.empty() && cv::countNonZero(view.valid) == 0) {
    view.level.release();
    return view;
  }
  cv::minMaxLoc(view.level, &least, &most, nullptr, nullptr, view.valid);
  view.median = view.low = view.high = view.threshold = view.dark = view.bright = least;
  if (most - least < 1e-6) return view;

  // Fine bins first, for the quantiles: whatever outliers are left must not stretch the 256.
  constexpr int kFine = 4096;
  std::array<std::uint32_t, kFine> fine{};
  const auto origin = static_cast<float>(least);
  const auto fine_per_level = static_cast<float>((kFine - 1) / (most - least));
  std::uint32_t shown_px = 0;
  for (int y = 0; y < view.level.rows; ++y) {
    const float* row = view.level.ptr<float>(y);
    const unsigned char* shown = view.valid.empty() ? nullptr : view.valid.ptr(y);
    for (int x = 0; x < view.level.cols; ++x) {
      if (shown && !shown[x]) continue;
      ++fine[static_cast<std::size_t>(static_cast<int>((row[x] - origin) * fine_per_level))];
      ++shown_px;
    }
  }
  const auto quantile = [&](double q) {
    double left = q * shown_px;
    std::size_t i = 0;
    while (i + 1 < kFine && (left -= fine[i]) > 0.0) ++i;
    return least + (static_cast<double>(i) + 0.5) / fine_per_level;
  };
  view.median = quantile(0.5);
  view.low = quantile(0.0005);
  view.high = quantile(0.9995);
  const double margin = 0.05 * (view.high - view.low) + 1.0 / fine_per_level;
  const double first = view.low - margin;
  const double bins_per_level = 256.0 / (view.high - view.low + 2.0 * margin);
  double counts[256] = {};
  for (std::size_t i = 0; i < kFine; ++i) {
    const double level = least + (static_cast<double>(i) + 0.5) / fine_per_level;
    counts[static_cast<int>(std::clamp((level - first) * bins_per_level, 0.0, 255.0))] += fine[i];
  }
  const Split split = split_bins(counts);
  view.threshold = first + (split.last_dark_bin + 1.0) / bins_per_level;
  view.dark = first + (split.dark_bin + 0.5) / bins_per_level;
  view.bright = first + (split.bright_bin + 0.5) / bins_per_level;
  view.bright_fraction = split.bright_fraction;
  view.two_classes =
      split.separation >= kSeparation &&
      std::min(split.bright_fraction, 1.0 - split.bright_fraction) >= kSmallestFraction &&
      has_two_classes(view, {kStepReach_px, kLag_px});
  return view;
}

}  // namespace watersky::detail
