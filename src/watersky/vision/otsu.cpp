// SPDX-License-Identifier: MIT
#include "watersky/vision/otsu.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>

#include "watersky/vision/detail/coarse_view.hpp"

namespace watersky {
namespace {

constexpr int kBins = 65536;
/// A frame teaches the flight only when its smaller class is at least this part of it.
constexpr double kTeachingFraction = 0.02;
/// A frame's own contrast agrees with the flight's within this factor, either way.
constexpr double kContrastFactor = 2.0;
/// No class is thought rarer than this, nor the threshold moved further than this part of the
/// contrast from the middle.
constexpr double kRarest = 0.02;
constexpr double kMostOffMiddle = 0.25;
constexpr std::size_t kManyShapes = 32;
/// Mean difference between the highest and the lowest channel, of full scale, that is colour.
constexpr double kColourful = 0.015;

Status check_image(const cv::Mat& image, const cv::Mat& valid) {
  if (image.empty()) return Error{ErrorCode::InvalidInput, "image is empty: nothing to segment"};
  if ((image.depth() != CV_8U && image.depth() != CV_16U) ||
      (image.channels() != 1 && image.channels() != 3))
    return Error{ErrorCode::Unsupported, "image is of type " + cv::typeToString(image.type()) +
                                             "; give 8 or 16 bit with 1 or 3 channels"};
  if (!valid.empty() && (valid.type() != CV_8UC1 || valid.size() != image.size()))
    return Error{ErrorCode::InvalidInput,
                 "validity mask is " + std::to_string(valid.cols) + "x" +
                     std::to_string(valid.rows) + " " + cv::typeToString(valid.type()) +
                     " for an image of " + std::to_string(image.cols) + "x" +
                     std::to_string(image.rows) + "; give CV_8UC1 of the same size"};
  return {};
}

cv::Mat luminance(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

bool colourful(const cv::Mat& image) {
  if (image.channels() != 3) return false;
  const double full_scale = image.depth() == CV_8U ? 255.0 : 65535.0;
  cv::Mat small;
  cv::resize(image, small, cv::Size(64, 64), 0, 0, cv::INTER_NEAREST);
  small.convertTo(small, CV_32FC3);
  double sum = 0.0;
  for (const auto& p : cv::Mat_<cv::Vec3f>(small))
    sum += std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]});
  return sum / (64.0 * 64.0) > kColourful * full_scale;
}

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

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Where a frame of an observed flight is split.
double flight_threshold(const FlightClasses& flight, const detail::CoarseView& view) {
  const double contrast = flight.bright - flight.dark;
  const double middle = 0.5 * (flight.bright + flight.dark);
  if (!flight.two_classes || view.level.empty()) return middle;
  const double own_contrast = view.bright - view.dark;
  const double own_middle = 0.5 * (view.bright + view.dark);
  const double most_drift = std::max(3.0 * flight.drift_sigma, 0.5 * contrast);
  const bool own = view.two_classes && own_contrast < kContrastFactor * contrast &&
                   own_contrast > contrast / kContrastFactor &&
                   std::abs(own_middle - middle) <= most_drift;
  double threshold = view.threshold;
  double bright_fraction = view.bright_fraction;
  if (!own) {
    const double drift = view.median - (view.median > middle ? flight.bright : flight.dark);
    threshold = middle + drift;
    const double shown = view.valid.empty() ? static_cast<double>(view.level.total())
                                            : static_cast<double>(cv::countNonZero(view.valid));
    cv::Mat bright = view.level > threshold;
    if (!view.valid.empty()) bright.setTo(0, view.valid == 0);
    bright_fraction = cv::countNonZero(bright) / shown;
  }
  const double f = std::clamp(bright_fraction, kRarest, 1.0 - kRarest);
  const double most = kMostOffMiddle * contrast;
  return threshold +
         std::clamp(flight.sigma * flight.sigma / contrast * std::log((1.0 - f) / f), -most, most);
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
  WATERSKY_CHECK(check_image(gray, valid));
  if (gray.channels() != 1) return Error{ErrorCode::Unsupported, "image has 3 channels; give one"};
  std::vector<std::uint32_t> bins(gray.depth() == CV_8U ? 256 : kBins);
  if (gray.depth() == CV_8U)
    count_levels<unsigned char>(gray, valid, bins);
  else
    count_levels<unsigned short>(gray, valid, bins);
  if (!valid.empty() && cv::countNonZero(valid) == 0)
    return Error{ErrorCode::InvalidInput, "image has no valid pixel: nothing to threshold"};
  return otsu_threshold(bins);
}

Status OtsuSegmenter::check(const OtsuParameters& parameters) { return validate(parameters); }

OtsuSegmenter::OtsuSegmenter(const OtsuParameters& parameters, IcePolarity ice)
    : parameters_(parameters), ice_(ice) {
  WATERSKY_REQUIRE(check(parameters).ok());
}

void OtsuSegmenter::observe(const cv::Mat& image, const cv::Mat& valid) {
  if (!check_image(image, valid)) return;
  if (depth_ >= 0 && image.depth() != depth_) return;
  const cv::Mat gray = luminance(image);
  const auto view = detail::coarse_view(gray, valid);
  if (view.level.empty()) return;
  depth_ = image.depth();
  ++classes_.frames;
  colour_frames_ += colourful(image);

  // Noise reaches beyond the coarse levels, but not as far as dead and hot pixels do.
  const double reach = 3.0 * (view.high - view.low);
  cv::Mat clipped;
  cv::max(gray, view.low - reach, clipped);
  cv::min(clipped, view.high + reach, clipped);
  cv::Scalar mean, deviation;
  cv::meanStdDev(clipped, mean, deviation, valid.empty() ? cv::noArray() : cv::InputArray(valid));
  const double variance = deviation[0] * deviation[0];
  pixel_variance_sum_ += variance;
  const double f = view.bright_fraction, contrast = view.bright - view.dark;
  if (view.two_classes && std::min(f, 1.0 - f) >= kTeachingFraction) {
    two_class_.push_back(
        {view.dark, view.bright,
         std::sqrt(std::max(0.0, variance - f * (1.0 - f) * contrast * contrast))});
    // Shapes take most of the time, and after many frames the next one adds little.
    if (ice_ == IcePolarity::Auto && two_class_.size() % (1 + two_class_.size() / kManyShapes) == 0)
      scores_.push_back(shape_evidence(view.level > view.threshold, view.valid).score);
  }
  if (two_class_.empty()) pool(view);
  learn();
}

void OtsuSegmenter::pool(const detail::CoarseView& view) {
  pooled_levels_.resize(kBins);
  const float bins_per_level = depth_ == CV_8U ? 256.0F : 1.0F;
  for (int y = 0; y < view.level.rows; ++y) {
    const float* row = view.level.ptr<float>(y);
    const unsigned char* shown = view.valid.empty() ? nullptr : view.valid.ptr(y);
    for (int x = 0; x < view.level.cols; ++x)
      if (!shown || shown[x])
        ++pooled_levels_[static_cast<std::size_t>(
            std::clamp(row[x] * bins_per_level, 0.0F, kBins - 1.0F))];
  }
}

void OtsuSegmenter::learn() {
  classes_.two_class_frames = two_class_.size();
  if (!two_class_.empty()) {
    std::vector<double> contrasts, middles, sigmas, drifts;
    for (const auto& frame : two_class_) {
      contrasts.push_back(frame.bright - frame.dark);
      middles.push_back(0.5 * (frame.bright + frame.dark));
      sigmas.push_back(frame.sigma);
    }
    const double contrast = median(contrasts), middle = median(middles);
    for (const double m : middles) drifts.push_back(std::abs(m - middle));
    classes_.two_classes = true;
    classes_.dark = middle - 0.5 * contrast;
    classes_.bright = middle + 0.5 * contrast;
    classes_.sigma = median(sigmas);
    classes_.drift_sigma = 1.4826 * median(drifts);
    return;
  }
  // No frame shows both: perhaps some are all water and some all ice.
  const OtsuThreshold pooled = otsu_threshold(pooled_levels_);
  const double levels_per_bin = depth_ == CV_8U ? 1.0 / 256.0 : 1.0;
  const auto first = std::find_if(pooled_levels_.begin(), pooled_levels_.end(),
                                  [](auto count) { return count > 0; });
  const auto last = std::find_if(pooled_levels_.rbegin(), pooled_levels_.rend(),
                                 [](auto count) { return count > 0; });
  const long low = first - pooled_levels_.begin();
  const long range = std::max(1L, (pooled_levels_.rend() - last) - low);
  double counts[256] = {};
  for (long i = 0; i < range; ++i)
    counts[i * 256 / range] += pooled_levels_[static_cast<std::size_t>(low + i)];
  classes_.two_classes = detail::split_bins(counts).two_modes;
  classes_.dark = (pooled.dark_mean + 0.5) * levels_per_bin;
  classes_.bright = (pooled.bright_mean + 0.5) * levels_per_bin;
  // Within frames of one class the pixels' own variance is the noise.
  classes_.sigma = classes_.two_classes
                       ? std::sqrt(pixel_variance_sum_ / static_cast<double>(classes_.frames))
                       : 0.0;
  classes_.drift_sigma = 0.0;
}

PolarityEstimate OtsuSegmenter::polarity() const {
  if (ice_ != IcePolarity::Auto) return {ice_, 1.0, "given"};
  return estimate_polarity(scores_, classes_.frames, 2 * colour_frames_ > classes_.frames);
}

Result<PolarityEstimate> OtsuSegmenter::polarity_of(const cv::Mat& image,
                                                    const cv::Mat& valid) const {
  WATERSKY_CHECK(check_image(image, valid));
  if (ice_ != IcePolarity::Auto) return PolarityEstimate{ice_, 1.0, "given"};
  const auto view = detail::coarse_view(luminance(image), valid);
  std::vector<double> scores;
  if (view.two_classes)
    scores.push_back(shape_evidence(view.level > view.threshold, view.valid).score);
  return estimate_polarity(scores, 1, colourful(image));
}

Result<cv::Mat> OtsuSegmenter::segment(const cv::Mat& image, const cv::Mat& valid) const {
  WATERSKY_CHECK(check_image(image, valid));
  const cv::Mat gray = luminance(image);
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  if (!valid.empty() && cv::countNonZero(valid) == 0)
    return cv::Mat(image.size(), CV_32F, cv::Scalar(kUnknown));

  double level = 0.0;
  IcePolarity ice = ice_;
  if (depth_ == image.depth()) {
    level = flight_threshold(classes_, detail::coarse_view(gray, valid));
    if (ice == IcePolarity::Auto) ice = polarity().polarity;
  } else {
    WATERSKY_TRY(const OtsuThreshold otsu, otsu_threshold(gray, valid));
    // One gray level everywhere: there is nothing to tell ice from water by.
    if (otsu.separability == 0.0) return cv::Mat(image.size(), CV_32F, cv::Scalar(kUnknown));
    level = otsu.level;
    if (ice == IcePolarity::Auto) {
      WATERSKY_TRY(const PolarityEstimate estimate, polarity_of(image, valid));
      ice = estimate.polarity;
    }
  }

  cv::Mat is_ice;
  cv::compare(gray, std::floor(level), is_ice,
              ice == IcePolarity::Darker ? cv::CMP_LE : cv::CMP_GT);
  if (parameters_.close_px > 1) {
    if (!valid.empty()) is_ice.setTo(0, valid == 0);
    const int edge = parameters_.close_px | 1;
    cv::morphologyEx(is_ice, is_ice, cv::MORPH_CLOSE,
                     cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(edge, edge)));
  }
  cv::Mat p_of_mask(1, 256, CV_32F, cv::Scalar(parameters_.p_ice_if_water)), p_ice;
  p_of_mask.at<float>(255) = static_cast<float>(parameters_.p_ice_if_ice);
  cv::LUT(is_ice, p_of_mask, p_ice);
  if (!valid.empty()) p_ice.setTo(kUnknown, valid == 0);
  return p_ice;
}

}  // namespace watersky
