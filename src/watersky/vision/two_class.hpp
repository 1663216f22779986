// SPDX-License-Identifier: MIT
#pragma once
/// What the classical methods share: two classes of pixels, which of them is ice, (2.31), and a
/// flight's memory of where its ice and water lie.
///
/// Every split in two of gray levels finds two halves, also in a frame that shows only water or
/// fog. So a frame is split only where it shows contrast, and a flight knows better still: its
/// frames that show two classes tell where ice and water lie and how far apart, and a frame that
/// does not is measured against those.
///
/// **Contrast** that can be used, in a frame whose noise has been averaged over some 18 pixels:
/// Otsu's classes lie at least 2.8 of their sigmas apart (a Gaussian cut in half: 2.65), the
/// smaller one is at least 0.2 % of the frame, classes of pixels 4 px apart agree more than chance
/// would have it (0.15 of the way to certainty: noise has none), and across the border between
/// classes the level changes by 0.42 of their contrast within 7 px (shading does not).
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/vision/polarity.hpp"
#include "watersky/vision/segmenter.hpp"

namespace watersky {

namespace detail {
struct CoarseView;
}

/// From classes to probabilities.
struct TwoClassEvidence {
  double p_ice_if_ice = 0.7;
  double p_ice_if_water = 0.4;
  int close_px = 0;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.p_ice_if_ice,
          ParameterInfo{"p_ice_if_ice", "1", "P1 of (2.31): P(ice) of a pixel classed ice", 0.5,
                        0.9999});
    visit(self.p_ice_if_water,
          ParameterInfo{"p_ice_if_water", "1", "P2 of (2.31): P(ice) of a pixel classed water",
                        0.0001, 0.5});
    visit(self.close_px,
          ParameterInfo{
              "close_px", "px",
              "morphological closing of the ice mask, edge of its kernel, made odd; 0 for none", 0,
              99});
  }
};

/// What a flight's frames say about its two classes, in gray levels.
struct FlightClasses {
  bool two_classes = false;  ///< false: neither a frame nor all together show two
  double dark = 0.0, bright = 0.0;
  double sigma = 0.0;        ///< of one pixel within its class
  double drift_sigma = 0.0;  ///< how far the levels of whole frames wander
  std::size_t frames = 0;
  std::size_t two_class_frames = 0;
};

/// Whether a frame's two classes are the flight's: their contrast within a factor of two of it,
/// their middle no farther off than it drifts. Two kinds of ice, or waves, are not.
[[nodiscard]] bool agrees_with(const FlightClasses& flight, double dark, double bright);

/// A segmenter that splits frames in two. Colour is read as luminance: it is what the camera's
/// JPEG holds at full resolution and with the least noise, and what a decoder gives when asked
/// for gray, so that a frame is judged alike however it was loaded.
///
/// Without observe(), or given an image of which it was shown nothing alike (8 or 16 bit), each
/// image by itself: split by the method where it shows contrast, not known (NaN) where not.
/// After observe():
/// - a frame that shows two classes whose contrast and place agree with the flight's is split by
///   the method. Places may drift with the camera's gain, up to the drift seen or half the
///   contrast;
/// - any other frame is taken to show mostly one class, the nearer one, and split by level where
///   the flight would, moved by the frame's drift from that class. Where the frame's level lies
///   too near the middle to tell which class it is, as fog does, or all its pixels are equal, it
///   is not known;
/// - levels are split where the smaller class's pixels are as likely as the noise of the larger
///   (σ² / contrast · log of their ratio off the middle), so that water alone stays water.
/// Where not even the flight shows two classes, Otsu's threshold of all its frames together is
/// all there is: see FlightClasses::two_classes; findings() says so.
class TwoClassSegmenter : public Segmenter {
 public:
  /// Parameters out of range are a Usage error that names them.
  [[nodiscard]] static Status check(const TwoClassEvidence& evidence);

  /// Images of a type that segment() refuses are not counted.
  void observe(const cv::Mat& image, const cv::Mat& valid) final;
  [[nodiscard]] Result<cv::Mat> segment(const cv::Mat& image, const cv::Mat& valid) const final;
  [[nodiscard]] Findings findings() const final;
  [[nodiscard]] Findings findings_of(const cv::Mat& image, const cv::Mat& valid) const final;

  /// The polarity in use after observe(): the given one, or the flight's.
  [[nodiscard]] PolarityEstimate polarity() const;
  /// The polarity that segment() would use for this image without a flight.
  [[nodiscard]] Result<PolarityEstimate> polarity_of(const cv::Mat& image,
                                                     const cv::Mat& valid) const;
  [[nodiscard]] const FlightClasses& classes() const { return classes_; }

 protected:
  /// What a method sees of a frame that shows two classes.
  struct Frame {
    const cv::Mat& gray;   ///< CV_8UC1 or CV_16UC1
    const cv::Mat& valid;  ///< CV_8U or empty: all valid; at least one pixel is
    double dark, bright;   ///< mean levels of Otsu's classes, noise averaged away
    double threshold;      ///< Otsu's, of the averaged levels
    double low, high;      ///< all levels but 0.05 % lie above, below
    /// Where the flight splits this frame; nullopt without a flight.
    std::optional<double> flight_threshold;
  };

  TwoClassSegmenter(const TwoClassEvidence& evidence, IcePolarity ice);

 private:
  /// The bright class: CV_8U of the frame's size, 255 or 0. What it is where `valid` is 0 does
  /// not count.
  [[nodiscard]] virtual cv::Mat bright(const Frame& frame) const = 0;

  struct TwoClassFrame {
    double dark, bright, sigma;
  };
  void pool(const detail::CoarseView& view);
  void learn();

  TwoClassEvidence evidence_;
  IcePolarity ice_;
  int depth_ = -1;  ///< of the observed images; -1: none
  std::size_t colour_frames_ = 0;
  std::vector<TwoClassFrame> two_class_;
  std::vector<double> scores_;                ///< ShapeEvidence of those frames, thinned when many
  std::vector<std::uint32_t> pooled_levels_;  ///< of all frames, until one shows two classes
  double pixel_variance_sum_ = 0.0;
  FlightClasses classes_;
};

}  // namespace watersky
