// SPDX-License-Identifier: MIT
#include "watersky/vision/learned_segmenter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/vision/detail/coarse_view.hpp"
#include "watersky/vision/detail/fine_detail.hpp"
#include "watersky/vision/detail/ice_inference.hpp"
#include "watersky/vision/detail/image.hpp"
#include "watersky/vision/detail/polarity_cues.hpp"

namespace watersky {
namespace {

using detail::IceScene;
using detail::LevelStatistics;
using detail::Planes;

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
/// (2.31) of a frame that is split by the flight's levels: as experiments/segmentation measures
/// P1 and P2 of Otsu's method, rounded towards one half.
constexpr TwoClassEvidence kByLevel{.p_ice_if_ice = 0.85, .p_ice_if_water = 0.1};
/// The most that one frame may say of a flight's polarity, and how many frames count at the most:
/// they show the same sea again and again.
constexpr double kMostLogOddsPerFrame = 4.0;
constexpr double kIndependentFrames = 4.0;

double p_of(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

/// A plane at half the size of the padded image, at the image's size.
cv::Mat enlarged(const cv::Mat& half, cv::Size size) {
  cv::Mat full;
  cv::resize(half, full, half.size() * 2, 0, 0, cv::INTER_LINEAR);
  return full.size() == size ? full : full(cv::Rect(cv::Point(), size)).clone();
}

/// At a quarter of its size: by halves, which OpenCV is much faster at.
cv::Mat quartered(const cv::Mat& image) {
  cv::Mat half, quarter;
  const auto halved = [](cv::Size size) {
    return cv::Size(std::max(1, size.width / 2), std::max(1, size.height / 2));
  };
  cv::resize(image, half, halved(image.size()), 0, 0, cv::INTER_AREA);
  cv::resize(half, quarter, halved(half.size()), 0, 0, cv::INTER_AREA);
  return quarter;
}

cv::Mat nearest(const cv::Mat& valid, cv::Size size) {
  cv::Mat resized;
  if (!valid.empty()) cv::resize(valid, resized, size, 0, 0, cv::INTER_NEAREST);
  return resized;
}

/// P(ice) of a gray image by level: what the coarse network says of it at a quarter of its size,
/// averaged over pixels of one level.
cv::Mat by_level(const IceNetworks& networks, const IceScene& small, const LevelStatistics& levels,
                 const cv::Mat& gray, bool ponds_are_ice) {
  const cv::Mat logit =
      detail::log_odds(detail::rough_p_ice(networks, small, levels, ponds_are_ice));
  // 256 levels over the range that matters.
  const double first = gray.depth() == CV_8U ? 0.0 : levels.first;
  const double scale = gray.depth() == CV_8U ? 1.0 : levels.bins_per_level;
  constexpr int kLevels = 256;
  std::array<double, kLevels> sum{}, weight{};
  for (int y = 0; y < logit.rows; ++y)
    for (int x = 0; x < logit.cols; ++x) {
      const double bin = (small.quarter.at<float>(y, x) - first) * scale;
      const auto i = static_cast<std::size_t>(std::clamp(bin, 0.0, kLevels - 1.0));
      sum[i] += logit.at<float>(y, x);
      weight[i] += 1.0;
    }
  cv::Mat table(1, kLevels, CV_32F);
  for (int i = 0; i < kLevels; ++i) {
    // A rare level is judged with its neighbours.
    double s = 0.0, w = 0.0;
    for (int reach = 0; w < 20.0 && reach < kLevels; ++reach)
      for (const int j : {i - reach, i + reach})
        if (j >= 0 && j < kLevels && (reach > 0 || j == i)) {
          s += sum[static_cast<std::size_t>(j)];
          w += weight[static_cast<std::size_t>(j)];
        }
    table.at<float>(i) = static_cast<float>(p_of(w > 0.0 ? s / w : 0.0));
  }
  cv::Mat eight = gray, smooth, p_ice;
  if (gray.depth() != CV_8U) gray.convertTo(eight, CV_8U, scale, -first * scale);
  cv::GaussianBlur(eight, smooth, {3, 3}, 0);
  cv::LUT(smooth, table, p_ice);
  return p_ice;
}

Error no_network(bool in_colour) {
  return {ErrorCode::Unsupported,
          std::string("the model has no network for ") + (in_colour ? "colour" : "gray") +
              " images; train one with 'watersky segment train', or choose another method"};
}

PolarityEstimate estimate_of(double p_brighter, const std::string& evidence) {
  return {p_brighter >= 0.5 ? IcePolarity::Brighter : IcePolarity::Darker,
          std::max(p_brighter, 1.0 - p_brighter), evidence};
}

}  // namespace

/// How an image is going to be looked at.
struct LearnedSegmenter::View {
  bool colour = false;
  const IceNetworks* networks = nullptr;
  cv::Mat picture;  ///< gray unless colour
  cv::Mat valid;
  int reduced = 1;  ///< picture and valid are of the image's size divided by that
  IceScene scene;
  LevelStatistics levels;
  bool contrast = false;  ///< shows two classes; in colour also what shows one
  double p_brighter = 1.0;
  double log_odds_by_shapes = 0.0;  ///< of bright ice, where it was to be found
};

LearnedSegmenter::LearnedSegmenter(const LearnedParameters& parameters, SegmentationQuality quality,
                                   IcePolarity ice, const IceModel& model)
    : parameters_(parameters),
      quality_(quality),
      ice_(ice),
      model_(model),
      levels_(kByLevel, ice) {}

bool LearnedSegmenter::observed(const cv::Mat& image) const {
  return frames_ > 0 && image.depth() == depth_;
}

bool LearnedSegmenter::in_colour(const cv::Mat& image) const {
  if (image.channels() != 3) return false;
  return observed(image) ? 2 * colour_frames_ > frames_ : detail::colourful(image);
}

/// The image at the size at which it is looked at.
Result<LearnedSegmenter::View> LearnedSegmenter::look(const cv::Mat& image, const cv::Mat& valid,
                                                      bool by_flight) const {
  const bool find_polarity = ice_ == IcePolarity::Auto && !by_flight;
  View view;
  view.colour = in_colour(image);
  const auto& networks = view.colour ? model_.colour : model_.gray;
  if (!networks) return no_network(view.colour);
  view.networks = &*networks;
  view.picture = view.colour ? image : detail::luminance(image);
  view.valid = valid;
  if (quality_ == SegmentationQuality::Fast) {
    view.picture = quartered(view.picture);
    view.valid = nearest(valid, view.picture.size());
    view.reduced = 4;
  }
  view.scene = detail::ice_scene(view.picture, view.valid, view.colour);
  if (!detail::level_statistics(view.scene, view.levels)) return view;
  if (view.colour) {
    view.contrast = true;
    return view;
  }
  // At a quarter of the image's size noise is averaged over sixteen pixels.
  cv::Mat quarter = view.scene.quarter, quarter_valid = view.scene.quarter_valid;
  if (view.reduced > 1) {
    view.picture.convertTo(quarter, CV_32F);
    quarter_valid = view.valid;
  }
  const auto classes = detail::two_classes_of(quarter, quarter_valid, view.levels.threshold, 4);
  view.contrast = classes.has_value();
  // Rough ice on a frame without water has two levels as well, but not the flight's.
  if (classes && by_flight && levels_.classes().two_classes)
    view.contrast = agrees_with(levels_.classes(), classes->dark, classes->bright);
  if (!find_polarity) {
    view.p_brighter = ice_ == IcePolarity::Auto       ? flight_p_brighter()
                      : ice_ == IcePolarity::Brighter ? 1.0
                                                      : 0.0;
  } else if (view.contrast) {
    const auto odds = detail::polarity_log_odds(
        detail::polarity_cues(quarter, quarter_valid, view.levels), view.networks->polarity);
    view.p_brighter = p_of(odds.by_shapes + odds.by_surfaces);
    view.log_odds_by_shapes = odds.by_shapes;
  }
  view.levels = view.levels.with_ice(view.p_brighter >= 0.5);
  return view;
}

void LearnedSegmenter::observe(const cv::Mat& image, const cv::Mat& valid) {
  if (!detail::check_image(image, valid) || (depth_ >= 0 && depth_ != image.depth())) return;
  if (!valid.empty() && cv::countNonZero(valid) == 0) return;
  depth_ = image.depth();
  ++frames_;
  colour_frames_ += detail::colourful(image);
  levels_.observe(image, valid);
  if (!model_.gray || ice_ != IcePolarity::Auto) return;
  const auto view = look(detail::luminance(image), valid, false);
  if (!view || !view->contrast) return;
  // A flight has shapes enough.
  polarity_sum_ +=
      std::clamp(view->log_odds_by_shapes, -kMostLogOddsPerFrame, kMostLogOddsPerFrame);
  ++polarity_frames_;
}

double LearnedSegmenter::flight_p_brighter() const {
  if (polarity_frames_ == 0) {
    const PolarityEstimate by_shapes = levels_.polarity();
    return by_shapes.polarity == IcePolarity::Brighter ? by_shapes.confidence
                                                       : 1.0 - by_shapes.confidence;
  }
  const auto n = static_cast<double>(polarity_frames_);
  return p_of(polarity_sum_ / n * std::min(n, kIndependentFrames));
}

PolarityEstimate LearnedSegmenter::polarity() const {
  if (ice_ != IcePolarity::Auto) return {ice_, 1.0, "given"};
  return estimate_of(flight_p_brighter(),
                     "by the shapes of the two classes in " + std::to_string(polarity_frames_) +
                         " of " + std::to_string(frames_) + " frames that were looked at");
}

Findings LearnedSegmenter::findings() const {
  Findings findings;
  if (frames_ == 0) return findings;
  if (2 * colour_frames_ > frames_) {
    findings.polarity = PolarityEstimate{IcePolarity::Brighter, 1.0, "in colour ice is white"};
    return findings;
  }
  findings.polarity = polarity();
  if (polarity_frames_ == 0 && levels_.classes().two_class_frames == 0) {
    findings.notes.emplace_back(
        "No frame shows ice and water apart: what is ice was told from the levels of all frames. "
        "Look at the images before you trust it.");
  } else if (ice_ == IcePolarity::Auto) {
    findings.notes.push_back(polarity_note(*findings.polarity));
  }
  return findings;
}

Findings LearnedSegmenter::findings_of(const cv::Mat& image, const cv::Mat& valid) const {
  Findings findings;
  if (!detail::check_image(image, valid)) return findings;
  if (observed(image)) {
    if (in_colour(image)) return findings;
    findings.polarity = polarity();
    const auto p = segment(image, valid);
    if (p && cv::countNonZero(*p == *p) == 0) findings.notes.emplace_back(kNoteBetween);
    return findings;
  }
  const auto view = look(image, valid, false);
  if (!view) return findings;
  if (view->colour) {
    findings.polarity = PolarityEstimate{IcePolarity::Brighter, 1.0, "in colour ice is white"};
    return findings;
  }
  if (!view->contrast) {
    findings.notes.emplace_back(kNoteNoContrast);
    return findings;
  }
  findings.polarity =
      ice_ != IcePolarity::Auto
          ? PolarityEstimate{ice_, 1.0, "given"}
          : estimate_of(view->p_brighter, "by the shapes and surfaces of its two classes");
  if (ice_ == IcePolarity::Auto) findings.notes.push_back(polarity_note(*findings.polarity));
  return findings;
}

cv::Mat LearnedSegmenter::p_of_view(const View& view, const cv::Mat& image,
                                    const cv::Mat& valid) const {
  const bool ponds = parameters_.ponds_are_ice;
  cv::Mat p_ice;
  switch (quality_) {
    case SegmentationQuality::Fast:
      if (view.colour)  // one level of three channels is no level
        cv::resize(enlarged(detail::probability(
                                detail::ice_scores(*view.networks, view.scene, view.levels), ponds),
                            view.picture.size()),
                   p_ice, image.size(), 0, 0, cv::INTER_LINEAR);
      else
        p_ice = by_level(*view.networks, view.scene, view.levels, detail::luminance(image), ponds);
      break;
    case SegmentationQuality::Standard:
      p_ice = enlarged(
          detail::probability(detail::ice_scores(*view.networks, view.scene, view.levels), ponds),
          image.size());
      break;
    case SegmentationQuality::Best:
      p_ice = detail::probability(best_scores(view, valid), ponds);
      break;
  }
  // With the other polarity ice would be water: as likely as that is, so much less is known.
  const double sure = std::max(view.p_brighter, 1.0 - view.p_brighter);
  if (sure < kSureOfPolarity) p_ice.convertTo(p_ice, -1, 2.0 * sure - 1.0, 1.0 - sure);
  return p_ice;
}

/// The mean of the scores of the image and of it at twice its size.
Planes LearnedSegmenter::best_scores(const View& view, const cv::Mat& valid) const {
  const cv::Size size = view.picture.size();
  Planes scores = detail::ice_scores(*view.networks, view.scene, view.levels);
  cv::Mat larger;
  cv::resize(view.picture, larger, size * 2, 0, 0, cv::INTER_CUBIC);
  const IceScene scene = detail::ice_scene(larger, nearest(valid, larger.size()), view.colour);
  LevelStatistics levels;
  Planes closer;
  if (detail::level_statistics(scene, levels))
    closer = detail::ice_scores(*view.networks, scene, levels.with_ice(view.levels.sign > 0.0F));
  for (std::size_t c = 0; c < scores.size(); ++c) {
    scores[c] = enlarged(scores[c], size);
    if (!closer.empty()) scores[c] = 0.5 * (scores[c] + closer[c](cv::Rect(cv::Point(), size)));
  }
  return scores;
}

Result<cv::Mat> LearnedSegmenter::segment(const cv::Mat& image, const cv::Mat& valid) const {
  WATERSKY_CHECK(detail::check_image(image, valid));
  const auto unknown = [&] { return cv::Mat(image.size(), CV_32F, cv::Scalar(kUnknown)); };
  if (!valid.empty() && cv::countNonZero(valid) == 0) return unknown();
  WATERSKY_TRY(const View view, look(image, valid, observed(image)));
  cv::Mat p_ice;
  if (view.contrast) {
    p_ice = p_of_view(view, image, valid);
  } else if (!view.colour && observed(image)) {
    WATERSKY_TRY(p_ice, levels_.segment(image, valid));
    // It may think otherwise of which class is ice.
    if (levels_.polarity().polarity != polarity().polarity)
      p_ice = (kByLevel.p_ice_if_ice + kByLevel.p_ice_if_water) - p_ice;
  } else {
    return unknown();
  }
  if (!valid.empty()) p_ice.setTo(kUnknown, valid == 0);
  return p_ice;
}

Result<cv::Mat> LearnedSegmenter::classify(const cv::Mat& image, const cv::Mat& valid) const {
  WATERSKY_CHECK(detail::check_image(image, valid));
  const cv::Scalar none(kUnknown, kUnknown, kUnknown);
  cv::Mat classes(image.size(), CV_32FC3, none);
  if (!valid.empty() && cv::countNonZero(valid) == 0) return classes;
  WATERSKY_TRY(const View view, look(image, valid, observed(image)));
  if (!view.contrast) return classes;
  Planes scores;
  if (quality_ == SegmentationQuality::Best) {
    scores = best_scores(view, valid);
  } else {
    scores = detail::ice_scores(*view.networks, view.scene, view.levels);
    for (auto& plane : scores) plane = enlarged(plane, view.picture.size());
  }
  // Each class against the other two: the softmax of the three.
  Planes p;
  for (std::size_t c = 0; c < detail::kClasses; ++c) {
    const Planes turned{scores[(c + 2) % 3], scores[c], scores[(c + 1) % 3]};
    p.push_back(detail::probability(turned));
  }
  cv::merge(p, classes);
  if (classes.size() != image.size())
    cv::resize(classes, classes, image.size(), 0, 0, cv::INTER_LINEAR);
  if (!valid.empty()) classes.setTo(none, valid == 0);
  return classes;
}

}  // namespace watersky
