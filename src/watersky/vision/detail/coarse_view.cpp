// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/coarse_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

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
/// Across the border between classes the level rises, within kStepReach_px, by at least this
/// part of their contrast: edges do (0.6 to 1.4 as seen), shading does not (0.1 to 0.5).
constexpr double kStep = 0.55;
/// Correlation of the classes of pixels kLag_px apart: noise cut in half has none.
constexpr double kCoherence = 0.15;
constexpr int kStepReach_px = 3;
constexpr int kLag_px = 4;

/// Whether Otsu's classes have edges between them and hold together.
bool has_two_classes(const CoarseView& view) {
  const double f = view.bright_fraction, contrast = view.bright - view.dark;
  if (std::min(view.level.rows, view.level.cols) <= 2 * kLag_px || contrast <= 0.0) return false;
  cv::Mat bright = view.level > view.threshold;
  cv::Mat valid = view.valid.empty() ? cv::Mat(bright.size(), CV_8U, cv::Scalar(255)) : view.valid;
  double agree = 0.0, pairs = 0.0;
  const int rows = bright.rows, cols = bright.cols;
  for (const cv::Point lag : {cv::Point(kLag_px, 0), cv::Point(0, kLag_px)}) {
    const cv::Rect here(0, 0, cols - lag.x, rows - lag.y), there(lag.x, lag.y, here.width, here.height);
    const cv::Mat both = valid(here) & valid(there);
    pairs += cv::countNonZero(both);
    agree += cv::countNonZero(both & (bright(here) == bright(there)));
  }
  const double chance = f * f + (1.0 - f) * (1.0 - f);
  if (pairs == 0.0 || (agree / pairs - chance) / (1.0 - chance) < kCoherence) return false;

  cv::Mat edge, highest, lowest;
  cv::morphologyEx(bright, edge, cv::MORPH_GRADIENT,
                   cv::getStructuringElement(cv::MORPH_CROSS, cv::Size(3, 3)));
  const cv::Mat reach = cv::getStructuringElement(
      cv::MORPH_RECT, cv::Size(2 * kStepReach_px + 1, 2 * kStepReach_px + 1));
  // Not where the view ends: what is shown there is filled in.
  cv::erode(valid, valid, reach);
  edge &= valid;
  if (cv::countNonZero(edge) == 0) return false;
  cv::dilate(view.level, highest, reach);
  cv::erode(view.level, lowest, reach);
  return cv::mean(highest - lowest, edge)[0] >= kStep * contrast;
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

CoarseView coarse_view(const cv::Mat& gray, const cv::Mat& valid) {
  CoarseView view;
  const int factor = std::max(1, std::min(gray.rows, gray.cols) / kShortSide_px);
  const cv::Size size(std::max(1, gray.cols / factor), std::max(1, gray.rows / factor));
  const auto reduced = [&](const cv::Mat& image) {
    cv::Mat small;
    if (factor == 1) return image;
    cv::resize(image, small, size, 0, 0, cv::INTER_AREA);
    return small;
  };
  // What the averaging over factor x factor pixels has not yet done.
  const double blur_px =
      std::sqrt(std::max(0.0, kBlur_px * kBlur_px - factor * factor / 12.0)) / factor;
  const auto blur = [&](cv::Mat& image) {
    if (blur_px > 0.25)
      cv::GaussianBlur(image, image, cv::Size(7, 7), blur_px, blur_px, cv::BORDER_REFLECT);
  };
  if (valid.empty()) {
    reduced(gray).convertTo(view.level, CV_32F);
    blur(view.level);
  } else {
    // Mean over the valid pixels only: blurred levels over blurred validity.
    cv::Mat masked, weight;
    gray.copyTo(masked, valid);
    reduced(masked).convertTo(view.level, CV_32F);
    cv::Mat shown = valid != 0;
    reduced(shown).convertTo(weight, CV_32F, 1.0 / 255.0);
    blur(view.level);
    blur(weight);
    view.valid = weight > 0.5;
    cv::divide(view.level, cv::max(weight, 0.5), view.level);
  }

  std::vector<float> levels;
  levels.reserve(view.level.total());
  for (int y = 0; y < view.level.rows; ++y) {
    const float* row = view.level.ptr<float>(y);
    const unsigned char* shown = view.valid.empty() ? nullptr : view.valid.ptr(y);
    for (int x = 0; x < view.level.cols; ++x)
      if (!shown || shown[x]) levels.push_back(row[x]);
  }
  if (levels.empty()) {
    view.level.release();
    return view;
  }
  // Dead and hot pixels must not stretch the bins.
  std::vector<float> sample;
  for (std::size_t i = 0; i < levels.size(); i += 5) sample.push_back(levels[i]);
  const auto quantile = [&](double q) {
    const auto k = sample.begin() + static_cast<long>(q * static_cast<double>(sample.size() - 1));
    std::nth_element(sample.begin(), k, sample.end());
    return static_cast<double>(*k);
  };
  view.median = quantile(0.5);
  const double low = quantile(0.0005), high = quantile(0.9995);
  view.threshold = view.dark = view.bright = view.median;
  if (high - low < 1e-6) return view;
  const double margin = 0.05 * (high - low), first = low - margin;
  const double bins_per_level = 255.0 / (high - low + 2.0 * margin);
  double counts[256] = {};
  for (const float level : levels)
    counts[static_cast<int>(std::clamp((level - first) * bins_per_level, 0.0, 255.0))] += 1.0;
  const Split split = split_bins(counts);
  view.threshold = first + (split.last_dark_bin + 1.0) / bins_per_level;
  view.dark = first + (split.dark_bin + 0.5) / bins_per_level;
  view.bright = first + (split.bright_bin + 0.5) / bins_per_level;
  view.bright_fraction = split.bright_fraction;
  view.two_classes = split.separation >= kSeparation &&
                     std::min(split.bright_fraction, 1.0 - split.bright_fraction) >= kSmallestFraction &&
                     has_two_classes(view);
  return view;
}

}  // namespace watersky::detail
