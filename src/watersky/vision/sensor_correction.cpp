// SPDX-License-Identifier: MIT
#include "watersky/vision/sensor_correction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace watersky {
namespace {

constexpr std::size_t kLeastFrames = 6;
constexpr double kDefectSigmas = 14.0;
/// What a defect leaves untouched, see find_defective_pixels(): share of its height, sigmas.
constexpr double kNeighbourShare = 0.15;
constexpr double kNeighbourSigmas = 2.5;
/// Columns and rows are told from shading within this many of them.
constexpr int kStripeReach_px = 31;
/// Halves of the frames correlate at least so far in a pattern that is one.
constexpr double kLeastHalfCorrelation = 0.05;
/// A pattern weaker than this part of the noise is not worth the time, and in 8 bit one below
/// this many levels not the rounding.
constexpr double kPatternPerNoise = 0.2;
constexpr double kLeastPattern8 = 0.3;
/// The same for vignetting: share of the level (8 bit), parts of the noise (16 bit).
constexpr double kLeastStep8 = 0.05;
constexpr double kLeastStepPerNoise = 1.0;
/// Frames correlate no further in their coarse detail when the sea moves through the picture.
constexpr double kMostStillness = 0.3;
constexpr int kCoarseShortSide = 64;

double median(std::vector<float> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// One sigma of a high-passed frame's noise by its median magnitude: edges and defects are few.
double noise_of(const cv::Mat& high) {
  std::vector<float> magnitude;
  const int step =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(high.total()) / 2e4)));
  magnitude.reserve(high.total() / static_cast<std::size_t>(step * step) + 1);
  for (int y = 0; y < high.rows; y += step)
    for (int x = 0; x < high.cols; x += step) magnitude.push_back(std::abs(high.at<float>(y, x)));
  return 1.4826 * median(std::move(magnitude));
}

/// The frame less its 5x5 median, which keeps edges and takes no note of single columns.
struct Split {
  cv::Mat smooth, high;
};
Split split(const cv::Mat& gray) {
  Split s;
  cv::medianBlur(gray, s.smooth, 5);
  cv::subtract(gray, s.smooth, s.high, cv::noArray(), CV_32F);
  return s;
}

/// How much higher each column stands than the one before it, as the mean of the differences
/// between the two that are not edges; 1 x columns, the first 0. `noise` holds the pattern too, so
/// a step near the bound is an edge of the scene along the whole column, and counts as none.
cv::Mat column_steps(const cv::Mat& gray, double noise) {
  cv::Mat difference, mean;
  cv::subtract(gray.colRange(1, gray.cols), gray.colRange(0, gray.cols - 1), difference,
               cv::noArray(), CV_32F);
  const double bound = 4.0 * std::sqrt(2.0) * std::max(noise, 0.25);
  cv::min(difference, bound, difference);
  cv::max(difference, -bound, difference);
  cv::reduce(difference, mean, 0, cv::REDUCE_AVG);
  cv::Mat steps = cv::Mat::zeros(1, gray.cols, CV_32F);
  mean.copyTo(steps.colRange(1, gray.cols));
  constexpr int kBlur_px = 3;  // an edge's blur steps beside it
  for (int x = 1; x < gray.cols; ++x)
    if (std::abs(mean.at<float>(x - 1)) > 0.6 * bound)
      steps.colRange(std::max(0, x - kBlur_px), std::min(gray.cols, x + kBlur_px + 1)) = 0.0;
  return steps;
}

/// Steps summed up, less what is slow: that is shading, or the sum of the steps' errors. Windows
/// stay symmetric towards the ends, so that no slope is left there.
cv::Mat stripes(const cv::Mat& steps) {
  const int n = steps.cols;
  std::vector<double> sum(static_cast<std::size_t>(n) + 1, 0.0), level(static_cast<std::size_t>(n));
  double now = 0.0;
  for (int x = 0; x < n; ++x) {
    const auto i = static_cast<std::size_t>(x);
    level[i] = now += steps.at<float>(x);
    sum[i + 1] = sum[i] + now;
  }
  cv::Mat stripe(1, n, CV_32F);
  for (int x = 0; x < n; ++x) {
    const int reach = std::min({kStripeReach_px / 2, x, n - 1 - x});
    const double slow =
        (sum[static_cast<std::size_t>(x + reach + 1)] - sum[static_cast<std::size_t>(x - reach)]) /
        (2 * reach + 1);
    stripe.at<float>(x) = static_cast<float>(level[static_cast<std::size_t>(x)] - slow);
  }
  return stripe;
}

std::vector<cv::Point> defects_in(const cv::Mat& high, double noise) {
  std::vector<cv::Point> found;
  // Rounding hides noise below half a level.
  const double sigma = std::max(noise, 0.5);
  const auto bound = static_cast<float>(kDefectSigmas * sigma);
  for (int y = 1; y + 1 < high.rows; ++y) {
    const float* row = high.ptr<float>(y);
    const float* above = high.ptr<float>(y - 1);
    const float* below = high.ptr<float>(y + 1);
    for (int x = 1; x + 1 < high.cols; ++x) {
      if (std::abs(row[x]) <= bound) continue;
      const float sign = row[x] > 0 ? 1.0F : -1.0F;
      const float neighbour =
          std::max({sign * row[x - 1], sign * row[x + 1], sign * above[x], sign * below[x]});
      if (neighbour < std::max(kNeighbourShare * std::abs(row[x]), kNeighbourSigmas * sigma))
        found.emplace_back(x, y);
    }
  }
  return found;
}

double correlation(const cv::Mat& a, const cv::Mat& b) {
  const double aa = a.dot(a), bb = b.dot(b);
  return aa > 0 && bb > 0 ? a.dot(b) / std::sqrt(aa * bb) : 0.0;
}

/// One part of the pattern: what of it is true, by what two halves of the frames share.
struct Share {
  double true_rms = 0.0;
  double weight = 0.0;  ///< of the mean of both halves that leaves the least error
};

Share share_of(const cv::Mat& a, const cv::Mat& b) {
  const double n = static_cast<double>(a.total());
  const double common = a.dot(b) / n;
  const double r = correlation(a, b);
  if (!(r > kLeastHalfCorrelation) || r * std::sqrt(n) < 4.0) return {};
  return {std::sqrt(common), 2.0 * r / (1.0 + r)};
}

void remove_mean(cv::Mat& m) { m -= cv::mean(m)[0]; }

}  // namespace

Result<std::vector<cv::Point>> find_defective_pixels(const cv::Mat& gray) {
  if (gray.type() != CV_8UC1 && gray.type() != CV_16UC1)
    return Error{ErrorCode::Unsupported, "image is of type " + cv::typeToString(gray.type()) +
                                             "; give 8 or 16 bit with 1 channel"};
  if (gray.empty()) return std::vector<cv::Point>();
  const cv::Mat high = split(gray).high;
  return defects_in(high, noise_of(high));
}

std::vector<std::string> SensorFindings::notes() const {
  std::vector<std::string> notes;
  char text[200];
  if (!defects.empty()) {
    std::snprintf(text, sizeof text, "%zu defective pixels were replaced by their neighbours.",
                  defects.size());
    notes.emplace_back(text);
  }
  if (corrects_pattern) {
    std::snprintf(text, sizeof text,
                  "Fixed-pattern noise was removed: columns %.2g, rows %.2g, pixels %.2g levels "
                  "rms against noise of %.2g; %.2g are expected to be left.",
                  column_rms, row_rms, pixel_rms, noise, pattern_left_rms);
    notes.emplace_back(text);
  }
  if (corrects_vignetting) {
    // A share of the light is below one; less than a count is not corrected.
    if (shading_range < 1.0)
      std::snprintf(text, sizeof text,
                    "Vignetting was removed: around the picture's middle the light ranged over "
                    "%.0f %% (± %.1f) of the brightest.",
                    100 * shading_range, 100 * shading_sigma);
    else
      std::snprintf(text, sizeof text,
                    "Shading around the picture's middle was removed: it ranged over %.3g (± %.2g) "
                    "counts.",
                    shading_range, shading_sigma);
    notes.emplace_back(text);
  }
  return notes;
}

void SensorCorrection::observe(const cv::Mat& image, const cv::Mat& valid) {
  if (image.empty() || (image.depth() != CV_8U && image.depth() != CV_16U) ||
      (image.channels() != 1 && image.channels() != 3) || std::min(image.cols, image.rows) < 32)
    return;
  if (type_ < 0) {
    type_ = image.type();
    size_ = image.size();
    for (Half& half : halves_) half.slopes.resize(kRings);
  }
  if (image.type() != type_ || image.size() != size_) return;
  Half& half = halves_[findings_.frames % 2];
  // Defects would look like a sea that stands still.
  observe_coarse(image.channels() == 1 ? observe_pattern(image, valid, half) : image, valid, half);
  ++half.frames;
  ++findings_.frames;
}

cv::Mat SensorCorrection::observe_pattern(const cv::Mat& gray, const cv::Mat& valid, Half& half) {
  auto [smooth, high] = split(gray);
  const double noise = noise_of(high);
  noises_.push_back(noise);
  if (defect_count_.empty()) {
    defect_count_ = cv::Mat::zeros(gray.size(), CV_8U);
    least_ = gray.clone();
    most_ = gray.clone();
  }
  for (const cv::Point& p : defects_in(high, noise)) {
    uchar& count = defect_count_.at<uchar>(p);
    count = static_cast<uchar>(std::min(255, count + 1));
  }
  cv::min(least_, gray, least_);
  cv::max(most_, gray, most_);
  // What is left of the scene counts no more than noise does.
  const double bound = 4.0 * std::max(noise, 0.25);
  cv::min(high, bound, high);
  cv::max(high, -bound, high);
  if (!valid.empty()) high.setTo(0.0, valid == 0);
  if (half.sum.empty()) half.sum = cv::Mat::zeros(gray.size(), CV_32F);
  half.sum += high;
  const auto add = [](cv::Mat& sum, const cv::Mat& steps) {
    sum = sum.empty() ? steps : cv::Mat(sum + steps);
  };
  add(half.columns, column_steps(gray, noise));
  add(half.rows, column_steps(gray.t(), noise));
  return smooth;
}

void SensorCorrection::observe_coarse(const cv::Mat& image, const cv::Mat& valid, Half& half) {
  // Whole blocks only: some ten times as fast, for a few pixels less at the far edges.
  const int factor = std::max(1, std::min(image.cols, image.rows) / kCoarseShortSide);
  const double scale = 1.0 / factor;
  const cv::Size size(image.cols / factor, image.rows / factor);
  const cv::Rect whole(0, 0, size.width * factor, size.height * factor);
  cv::Mat small, levels, shown;
  cv::resize(image(whole), small, size, 0, 0, cv::INTER_AREA);
  if (small.channels() == 3) cv::cvtColor(small, small, cv::COLOR_BGR2GRAY);
  small.convertTo(levels, CV_32F);
  if (!valid.empty()) cv::resize(valid(whole), shown, size, 0, 0, cv::INTER_NEAREST);

  // Does the sea move? What is smooth has no say, for it may be vignetting, nor have rows and
  // columns, which may be the pattern's.
  cv::Mat detail, mean;
  cv::GaussianBlur(levels, detail, {}, 3.0, 3.0, cv::BORDER_REFLECT);
  detail = levels - detail;
  cv::reduce(detail, mean, 0, cv::REDUCE_AVG);
  detail -= cv::repeat(mean, size.height, 1);
  cv::reduce(detail, mean, 1, cv::REDUCE_AVG);
  detail -= cv::repeat(mean, 1, size.width);
  const double energy = detail.dot(detail) / static_cast<double>(detail.total());
  const double cell_noise = noises_.empty() ? 0.5 : noises_.back() * scale;
  const auto shows = [&](double e) { return e > 4.0 * cell_noise * cell_noise + 0.01; };
  // A sea without detail cannot be mistaken for a pattern.
  if (!previous_coarse_.empty())
    correlations_.push_back(
        shows(energy) && shows(previous_energy_) ? correlation(detail, previous_coarse_) : 0.0);
  previous_coarse_ = detail;
  previous_energy_ = energy;

  // Slopes away from the middle, in ρ. The scene's edges lie either way and are few: the median
  // over a ring sees through them, which a mean would not.
  const bool relative = image.depth() == CV_8U;
  const auto usable = [&](int y, int x) {
    const float level = levels.at<float>(y, x);
    return (shown.empty() || shown.at<uchar>(y, x)) && (!relative || (level > 4 && level < 250));
  };
  cv::Mat value = levels;
  if (relative) cv::log(cv::max(levels, 1.0), value);
  const double cx = 0.5 * image.cols / factor - 0.5, cy = 0.5 * image.rows / factor - 0.5;
  const double half_diagonal = 0.5 * std::hypot(image.cols, image.rows) / factor;
  for (int y = 1; y + 1 < size.height; ++y)
    for (int x = 1; x + 1 < size.width; ++x) {
      const double dx = x - cx, dy = y - cy, r = std::hypot(dx, dy);
      if (r < 1.0 || !usable(y, x - 1) || !usable(y, x + 1) || !usable(y - 1, x) ||
          !usable(y + 1, x))
        continue;
      const double gx = 0.5 * (value.at<float>(y, x + 1) - value.at<float>(y, x - 1));
      const double gy = 0.5 * (value.at<float>(y + 1, x) - value.at<float>(y - 1, x));
      const auto ring = std::min(kRings - 1, static_cast<std::size_t>(r / half_diagonal * kRings));
      half.slopes[ring].push_back(static_cast<float>((gx * dx + gy * dy) / r * half_diagonal));
    }
}

void SensorCorrection::learn() {
  findings_.defects.clear();
  findings_.corrects_pattern = findings_.corrects_vignetting = false;
  offset_.release();
  gain_.release();
  if (!noises_.empty()) {
    std::vector<float> noises(noises_.begin(), noises_.end());
    findings_.noise = median(std::move(noises));
  }
  findings_.moving =
      !correlations_.empty() &&
      median(std::vector<float>(correlations_.begin(), correlations_.end())) < kMostStillness;
  if (findings_.frames < kLeastFrames || !findings_.moving) return;
  if (!defect_count_.empty()) {
    learn_defects();
    learn_pattern();
  }
  learn_vignetting();
}

void SensorCorrection::learn_defects() {
  const auto half = static_cast<int>((findings_.frames + 1) / 2);
  // A pixel that never moves is stuck, where the others do.
  cv::Mat range;
  cv::subtract(most_, least_, range, cv::noArray(), CV_32F);
  const double typical = cv::mean(range)[0];
  for (int y = 0; y < size_.height; ++y)
    for (int x = 0; x < size_.width; ++x)
      if (defect_count_.at<uchar>(y, x) >= half ||
          (typical > 8.0 && range.at<float>(y, x) == 0.0F && findings_.frames >= 8))
        findings_.defects.emplace_back(x, y);
  // More than this is no list of defects but something that was not understood.
  if (findings_.defects.size() > static_cast<std::size_t>(size_.area()) / 200)
    findings_.defects.clear();
}

void SensorCorrection::learn_pattern() {
  std::array<cv::Mat, 2> mean, columns, rows;
  for (std::size_t i = 0; i < 2; ++i) {
    const double frames = halves_[i].frames;
    mean[i] = halves_[i].sum / frames;
    for (const cv::Point& p : findings_.defects) mean[i].at<float>(p) = 0.0F;
    remove_mean(mean[i]);
    // The median took what neighbouring columns share, so whole columns come from their steps.
    cv::Mat line;
    cv::reduce(mean[i], line, 0, cv::REDUCE_AVG);
    mean[i] -= cv::repeat(line, size_.height, 1);
    cv::reduce(mean[i], line, 1, cv::REDUCE_AVG);
    mean[i] -= cv::repeat(line, 1, size_.width);
    columns[i] = stripes(halves_[i].columns / frames);
    rows[i] = stripes(halves_[i].rows / frames).t();
  }
  const Share column = share_of(columns[0], columns[1]), row = share_of(rows[0], rows[1]),
              pixel = share_of(mean[0], mean[1]);
  findings_.column_rms = column.true_rms;
  findings_.row_rms = row.true_rms;
  findings_.pixel_rms = pixel.true_rms;
  const auto square = [](double x) { return x * x; };
  const double all =
      std::sqrt(square(column.true_rms) + square(row.true_rms) + square(pixel.true_rms));
  const double least = std::max(kPatternPerNoise * findings_.noise,
                                CV_MAT_DEPTH(type_) == CV_8U ? kLeastPattern8 : 0.0);
  if (!(all > least)) return;
  findings_.corrects_pattern = true;
  findings_.pattern_left_rms = std::sqrt(square(column.true_rms) * (1 - column.weight) +
                                         square(row.true_rms) * (1 - row.weight) +
                                         square(pixel.true_rms) * (1 - pixel.weight));
  offset_ = pixel.weight * 0.5 * (mean[0] + mean[1]);
  offset_ += cv::repeat(column.weight * 0.5 * (columns[0] + columns[1]), size_.height, 1);
  offset_ += cv::repeat(row.weight * 0.5 * (rows[0] + rows[1]), 1, size_.width);
}

SensorCorrection::Radial SensorCorrection::fit(const std::vector<std::vector<float>>& slopes) {
  std::array<double, kRings> slope{}, variance{};
  for (std::size_t k = 0; k < kRings; ++k) {
    if (slopes[k].size() < 50) continue;
    slope[k] = median(slopes[k]);
    std::vector<float> off(slopes[k].size());
    std::transform(slopes[k].begin(), slopes[k].end(), off.begin(),
                   [m = static_cast<float>(slope[k])](float s) { return std::abs(s - m); });
    // Neighbouring slopes share pixels and structure: some eight make one.
    const double sigma = 1.2533 * 1.4826 * median(std::move(off));
    variance[k] = sigma * sigma * 8.0 / static_cast<double>(slopes[k].size());
  }
  // The slopes, straight between the middles of rings, summed up from the middle of the picture.
  Radial radial;
  constexpr std::size_t kSteps = 240;
  radial.steps.assign(kSteps + 1, 0.0);
  double now = 0.0;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double at = (static_cast<double>(i) + 0.5) / kSteps * kRings - 0.5;
    const double clamped = std::clamp(at, 0.0, kRings - 1.0);
    const std::size_t k = std::min(static_cast<std::size_t>(clamped), kRings - 2);
    const double t = clamped - static_cast<double>(k);
    now += ((1 - t) * slope[k] + t * slope[k + 1]) / kSteps;
    radial.steps[i + 1] = now;
  }
  double sum = 0.0;
  for (const double v : variance) sum += v / (kRings * kRings);
  radial.sigma = std::sqrt(sum);
  return radial;
}

double SensorCorrection::Radial::step(double rho) const {
  const double at = std::clamp(rho, 0.0, 1.0) * static_cast<double>(steps.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), steps.size() - 2);
  const double t = at - static_cast<double>(i);
  return (1 - t) * steps[i] + t * steps[i + 1];
}

void SensorCorrection::learn_vignetting() {
  std::vector<std::vector<float>> all = halves_[0].slopes;
  for (std::size_t k = 0; k < kRings; ++k)
    all[k].insert(all[k].end(), halves_[1].slopes[k].begin(), halves_[1].slopes[k].end());
  radial_ = fit(all);
  const bool relative = CV_MAT_DEPTH(type_) == CV_8U;
  const auto [least, most] = std::minmax_element(radial_.steps.begin(), radial_.steps.end());
  const double range = *most - *least;
  const double corner = radial_.steps.back();
  findings_.corner_step = relative ? std::expm1(corner) : corner;
  findings_.shading_range = relative ? -std::expm1(-range) : range;
  findings_.shading_sigma = radial_.sigma;
  if (range < (relative ? kLeastStep8 : std::max(1.0, kLeastStepPerNoise * findings_.noise)))
    return;
  if (range < 4.0 * radial_.sigma) return;
  // Each half must find what the other did, or it is the sea's.
  const Radial a = fit(halves_[0].slopes), b = fit(halves_[1].slopes);
  double differ = 0.0;
  for (std::size_t i = 0; i < a.steps.size(); ++i)
    differ = std::max(differ, std::abs(a.steps[i] - b.steps[i]));
  if (differ > 0.5 * range) return;
  findings_.corrects_vignetting = true;
  if (relative) {
    // The middle may be darkest or brightest: the picture as a whole keeps its brightness.
    double sum = 0.0, area = 0.0;
    for (std::size_t i = 0; i < radial_.steps.size(); ++i) {
      sum += static_cast<double>(i) * radial_.steps[i];
      area += static_cast<double>(i);
    }
    for (double& step : radial_.steps) step -= sum / area;
  }
  const cv::Mat map = radial_map(size_);
  if (!relative) {
    offset_ = offset_.empty() ? map : cv::Mat(offset_ + map);
    return;
  }
  gain_ = map;
}

/// What to subtract (16 bit), or to multiply by (8 bit, repeated for each channel).
cv::Mat SensorCorrection::radial_map(cv::Size size) const {
  const bool relative = CV_MAT_DEPTH(type_) == CV_8U;
  cv::Mat map(size, CV_32F);
  const double cx = 0.5 * (size.width - 1), cy = 0.5 * (size.height - 1);
  const double scale = 4.0 / (static_cast<double>(size.width) * size.width +
                              static_cast<double>(size.height) * size.height);
  for (int y = 0; y < size.height; ++y) {
    float* row = map.ptr<float>(y);
    for (int x = 0; x < size.width; ++x) {
      const double step =
          radial_.step(std::sqrt(((x - cx) * (x - cx) + (y - cy) * (y - cy)) * scale));
      row[x] = static_cast<float>(relative ? std::min(4.0, std::exp(-step)) : step);
    }
  }
  if (CV_MAT_CN(type_) == 3) cv::merge(std::vector<cv::Mat>(3, map), map);
  return map;
}

bool SensorCorrection::needed() const {
  return findings_.corrects_pattern || findings_.corrects_vignetting || !findings_.defects.empty();
}

cv::Mat SensorCorrection::correct(const cv::Mat& image) const {
  if (!needed() || image.depth() != CV_MAT_DEPTH(type_)) return image;
  const bool same = image.size() == size_ && image.type() == type_;
  if (!same) {
    if (!findings_.corrects_vignetting || image.channels() != CV_MAT_CN(type_)) return image;
    cv::Mat out;
    const cv::Mat map = radial_map(image.size());
    if (image.depth() == CV_8U)
      cv::multiply(image, map, out, 1.0, image.depth());
    else
      cv::subtract(image, map, out, cv::noArray(), image.depth());
    return out;
  }
  cv::Mat out;
  if (!offset_.empty() && !gain_.empty()) {
    cv::Mat level;
    cv::subtract(image, offset_, level, cv::noArray(), CV_32F);
    cv::multiply(level, gain_, out, 1.0, image.depth());
  } else if (!offset_.empty()) {
    cv::subtract(image, offset_, out, cv::noArray(), image.depth());
  } else if (!gain_.empty()) {
    cv::multiply(image, gain_, out, 1.0, image.depth());
  } else {
    out = image.clone();
  }
  const auto replace = [&]<class Level>(Level) {
    // From what was corrected, and from defects that are already replaced only where there is
    // nothing else: pairs side by side lean on the others.
    for (const cv::Point& p : findings_.defects) {
      std::array<Level, 8> around{};
      std::size_t n = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = p.x + dx, y = p.y + dy;
          if ((dx == 0 && dy == 0) || x < 0 || y < 0 || x >= out.cols || y >= out.rows) continue;
          around[n++] = out.at<Level>(y, x);
        }
      const auto middle = around.begin() + static_cast<std::ptrdiff_t>(n / 2);
      std::nth_element(around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(n));
      out.at<Level>(p) = *middle;
    }
  };
  if (type_ == CV_8UC1) replace(std::uint8_t{});
  if (type_ == CV_16UC1) replace(std::uint16_t{});
  return out;
}

}  // namespace watersky
