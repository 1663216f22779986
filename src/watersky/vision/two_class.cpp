// SPDX-License-Identifier: MIT
#include "watersky/vision/two_class.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "watersky/vision/detail/coarse_view.hpp"
#include "watersky/vision/detail/image.hpp"
#include "watersky/vision/otsu.hpp"

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
/// A frame of one class is the nearer one's of the flight when that is so many drift sigmas away
/// at most and so many times as likely as the other.
constexpr double kMostSigmas = 3.5;
constexpr double kClassOdds = 10.0;
/// The drift of few frames is not known well: at least this part of the contrast.
constexpr double kLeastDrift = 0.1;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// How a frame of an observed flight is split.
struct FlightSplit {
  enum class By { Method, Level, Nothing } by = By::Level;
  double level = 0.0;
};

FlightSplit split_by_flight(const FlightClasses& flight, const detail::CoarseView& view) {
  const double contrast = flight.bright - flight.dark;
  const double middle = 0.5 * (flight.bright + flight.dark);
  if (!flight.two_classes) return {FlightSplit::By::Level, middle};
  const bool own = view.two_classes && agrees_with(flight, view.dark, view.bright);
  double threshold = view.threshold;
  double bright_fraction = view.bright_fraction;
  if (!own) {
    const double drift = view.median - (view.median > middle ? flight.bright : flight.dark);
    const double sigma = std::max(flight.drift_sigma, kLeastDrift * contrast);
    const double near = std::abs(drift), far = contrast - near;
    const bool between = view.median > flight.dark && view.median < flight.bright;
    // A lens cap, a full well and a frozen sensor have a level, but it says nothing.
    const bool one_level = !(view.high > view.low);
    const bool undecided =
        one_level ||
        (between && (near > kMostSigmas * sigma ||
                     far * far - near * near < 2.0 * sigma * sigma * std::log(kClassOdds)));
    if (undecided) return {FlightSplit::By::Nothing, 0.0};
    threshold = middle + drift;
    const double shown = view.valid.empty() ? static_cast<double>(view.level.total())
                                            : static_cast<double>(cv::countNonZero(view.valid));
    cv::Mat bright = view.level > threshold;
    if (!view.valid.empty()) bright.setTo(0, view.valid == 0);
    bright_fraction = cv::countNonZero(bright) / shown;
  }
  const double f = std::clamp(bright_fraction, kRarest, 1.0 - kRarest);
  const double most = kMostOffMiddle * contrast;
  return {own ? FlightSplit::By::Method : FlightSplit::By::Level,
          threshold + std::clamp(flight.sigma * flight.sigma / contrast * std::log((1.0 - f) / f),
                                 -most, most)};
}

/// Closes gaps in the ice narrower than `close_px`.
void close_ice(cv::Mat& is_ice, const cv::Mat& valid, int close_px) {
  if (close_px <= 1) return;
  if (!valid.empty()) is_ice.setTo(0, valid == 0);
  const int edge = close_px | 1;
  cv::morphologyEx(is_ice, is_ice, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(edge, edge)));
}

PolarityEstimate polarity_in(const detail::CoarseView& view, bool in_colour) {
  std::vector<double> scores;
  if (view.two_classes)
    scores.push_back(shape_evidence(view.level > view.threshold, view.valid).score);
  return estimate_polarity(scores, 1, in_colour);
}

}  // namespace

bool agrees_with(const FlightClasses& flight, double dark, double bright) {
  const double contrast = flight.bright - flight.dark, own_contrast = bright - dark;
  const double off = std::abs(0.5 * (bright + dark) - 0.5 * (flight.bright + flight.dark));
  return own_contrast < kContrastFactor * contrast && own_contrast > contrast / kContrastFactor &&
         off <= std::max(3.0 * flight.drift_sigma, 0.5 * contrast);
}

Status TwoClassSegmenter::check(const TwoClassEvidence& evidence) { return validate(evidence); }

TwoClassSegmenter::TwoClassSegmenter(const TwoClassEvidence& evidence, IcePolarity ice)
    : evidence_(evidence), ice_(ice) {
  WATERSKY_REQUIRE(check(evidence).ok());
}

void TwoClassSegmenter::observe(const cv::Mat& image, const cv::Mat& valid) {
  if (!detail::check_image(image, valid)) return;
  if (depth_ >= 0 && image.depth() != depth_) return;
  const cv::Mat gray = detail::luminance(image);
  const auto view = detail::coarse_view(gray, valid);
  if (view.level.empty()) return;
  depth_ = image.depth();
  ++classes_.frames;
  colour_frames_ += detail::colourful(image);

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

void TwoClassSegmenter::pool(const detail::CoarseView& view) {
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

void TwoClassSegmenter::learn() {
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

PolarityEstimate TwoClassSegmenter::polarity() const {
  if (ice_ != IcePolarity::Auto) return {ice_, 1.0, "given"};
  return estimate_polarity(scores_, classes_.frames, 2 * colour_frames_ > classes_.frames);
}

Result<PolarityEstimate> TwoClassSegmenter::polarity_of(const cv::Mat& image,
                                                        const cv::Mat& valid) const {
  WATERSKY_CHECK(detail::check_image(image, valid));
  if (ice_ != IcePolarity::Auto) return PolarityEstimate{ice_, 1.0, "given"};
  return polarity_in(detail::coarse_view(detail::luminance(image), valid),
                     detail::colourful(image));
}

Result<cv::Mat> TwoClassSegmenter::segment(const cv::Mat& image, const cv::Mat& valid) const {
  WATERSKY_CHECK(detail::check_image(image, valid));
  const cv::Mat gray = detail::luminance(image);
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  const auto unknown = [&] { return cv::Mat(image.size(), CV_32F, cv::Scalar(kUnknown)); };
  // Shapes are looked at only to find the polarity.
  const bool by_shapes = ice_ == IcePolarity::Auto && depth_ != image.depth();
  const auto view = detail::coarse_view(
      gray, valid, by_shapes ? detail::Cleaned::Before : detail::Cleaned::After);
  if (view.level.empty()) return unknown();

  Frame frame{gray,           valid,    view.dark, view.bright,
              view.threshold, view.low, view.high, std::nullopt};
  using By = FlightSplit::By;
  By by = view.two_classes ? By::Method : By::Nothing;
  IcePolarity ice = ice_;
  if (depth_ == image.depth()) {
    const FlightSplit split = split_by_flight(classes_, view);
    by = split.by;
    frame.flight_threshold = split.level;
    if (ice == IcePolarity::Auto) ice = polarity().polarity;
  } else if (ice == IcePolarity::Auto && by == By::Method) {
    ice = polarity_in(view, detail::colourful(image)).polarity;
  }
  if (by == By::Nothing) return unknown();

  cv::Mat is_ice =
      by == By::Method ? bright(frame) : cv::Mat(gray > std::floor(*frame.flight_threshold));
  if (ice == IcePolarity::Darker) cv::bitwise_not(is_ice, is_ice);
  close_ice(is_ice, valid, evidence_.close_px);
  const auto p1 = static_cast<float>(evidence_.p_ice_if_ice);
  const auto p2 = static_cast<float>(evidence_.p_ice_if_water);
  cv::Mat p_ice(image.size(), CV_32F);
  for (int y = 0; y < p_ice.rows; ++y) {
    const unsigned char* in = is_ice.ptr(y);
    float* out = p_ice.ptr<float>(y);
    for (int x = 0; x < p_ice.cols; ++x) out[x] = in[x] ? p1 : p2;
  }
  if (!valid.empty()) p_ice.setTo(kUnknown, valid == 0);
  return p_ice;
}

Findings TwoClassSegmenter::findings() const {
  Findings findings;
  if (depth_ < 0) return findings;
  findings.polarity = polarity();
  if (!classes_.two_classes || classes_.two_class_frames == 0) {
    findings.notes.emplace_back(
        "No frame shows ice and water apart: the split may be shading or noise. Look at the "
        "images before you trust it.");
  } else if (ice_ == IcePolarity::Auto) {
    findings.notes.push_back(polarity_note(*findings.polarity));
  }
  return findings;
}

Findings TwoClassSegmenter::findings_of(const cv::Mat& image, const cv::Mat& valid) const {
  Findings findings;
  if (!detail::check_image(image, valid)) return findings;
  const auto view = detail::coarse_view(detail::luminance(image), valid);
  if (depth_ == image.depth()) {
    findings.polarity = polarity();
    if (!view.level.empty() && split_by_flight(classes_, view).by == FlightSplit::By::Nothing)
      findings.notes.emplace_back(kNoteBetween);
    return findings;
  }
  if (!view.two_classes) {
    findings.notes.emplace_back(kNoteNoContrast);
    return findings;
  }
  findings.polarity = ice_ != IcePolarity::Auto ? PolarityEstimate{ice_, 1.0, "given"}
                                                : polarity_in(view, detail::colourful(image));
  if (ice_ == IcePolarity::Auto)
    findings.notes.push_back(polarity_note(
        {findings.polarity->polarity, findings.polarity->confidence,
         detail::colourful(image) ? "the image is in visible light, where ice is brighter"
                                  : "by the shapes of its pieces"}));
  return findings;
}

}  // namespace watersky
