// SPDX-License-Identifier: MIT
#pragma once
/// From pixels to P(ice): the interface that every segmentation method keeps.
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/vision/polarity.hpp"

namespace watersky {

/// What a method has to say about what it was shown, for reports.
struct Findings {
  /// What ice was taken for; nullopt: the method has no use for it.
  std::optional<PolarityEstimate> polarity;
  std::vector<std::string> notes;  ///< what to know before trusting the result, a sentence each
};

/// Notes on a frame of which nothing is known: by itself, and in a flight.
inline constexpr const char* kNoteNoContrast = "Shows no contrast that could be ice against water.";
inline constexpr const char* kNoteBetween =
    "Shows one class only, and its level lies too far between the flight's ice and water to tell "
    "which.";

/// Turns images of one flight into probabilities.
///
/// A flight is shown first to observe() (all of it, or a sample), so that a method may learn
/// what ice and water look like in it; then segment() is called for each frame. segment() is
/// const and may be called from several threads at once; each image's result depends on it and
/// on what was observed, not on the order of calls.
class Segmenter {
 public:
  virtual ~Segmenter() = default;

  /// `image`: 8 or 16 bit, 1 or 3 (BGR) channels. `valid`: CV_8U of the same size, 0 where the
  /// image shows nothing; may be empty: all valid.
  virtual void observe(const cv::Mat& image, const cv::Mat& valid) = 0;

  /// P(ice) per pixel: CV_32F of the image's size in [0, 1], NaN where the method does not know
  /// (that pixel adds no evidence) and where `valid` is 0. Unsupported for an image type that
  /// the method does not take.
  [[nodiscard]] virtual Result<cv::Mat> segment(const cv::Mat& image,
                                                const cv::Mat& valid) const = 0;

  /// About the flight, after observe().
  [[nodiscard]] virtual Findings findings() const { return {}; }
  /// About one image, as segment() sees it. An image that segment() refuses has none.
  [[nodiscard]] virtual Findings findings_of(const cv::Mat& image, const cv::Mat& valid) const {
    static_cast<void>(image), static_cast<void>(valid);
    return {};
  }

 protected:
  Segmenter() = default;
  Segmenter(const Segmenter&) = default;
  Segmenter& operator=(const Segmenter&) = default;
};

}  // namespace watersky
