// SPDX-License-Identifier: MIT
#pragma once
/// Otsu's threshold, alone and with a flight's memory.
///
/// Otsu splits every histogram in two, also that of a frame which shows only water. A flight
/// knows better: its frames that show two classes tell where ice and water lie and how far apart,
/// and a frame that does not is measured against those.
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/vision/polarity.hpp"
#include "watersky/vision/segmenter.hpp"

namespace watersky {

namespace detail {
struct CoarseView;
}

/// Otsu's split of gray levels: those above `level` are the bright class.
struct OtsuThreshold {
  int level = 0;
  double separability = 0.0;  ///< η: between-class over total variance, in [0, 1]; 0: one level
  double dark_mean = 0.0;
  double bright_mean = 0.0;
  double bright_fraction = 0.0;
};

/// The lowest level that maximises the between-class variance, found in exact sums.
/// `histogram[i]`: number of pixels of gray level i.
[[nodiscard]] OtsuThreshold otsu_threshold(std::span<const std::uint32_t> histogram);

/// The same for an image, CV_8UC1 or CV_16UC1 with all its levels as bins. `valid` as in
/// Segmenter. Unsupported for another type, InvalidInput when nothing is valid.
[[nodiscard]] Result<OtsuThreshold> otsu_threshold(const cv::Mat& gray, const cv::Mat& valid = {});

struct OtsuParameters {
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

/// (2.31) on Otsu's threshold. Colour is read as luminance: it is what the camera's JPEG holds
/// at full resolution and with the least noise, and what a decoder gives when asked for gray,
/// so that a frame is judged alike however it was loaded.
///
/// Without observe(), or given an image of which it was shown nothing alike (8 or 16 bit), plain
/// Otsu for each image. After observe():
/// - a frame that shows two classes whose contrast and place agree with the flight's is split
///   between its own. Places may drift with the camera's gain, up to the drift seen or half the
///   contrast;
/// - any other frame is taken to show mostly one class, the nearer one, and split where the
///   flight would, moved by the frame's drift from that class;
/// - the split lies where the smaller class's pixels are as likely as the noise of the larger
///   (σ² / contrast · log of their ratio off the middle), so that water alone stays water.
/// Where not even the flight shows two classes, Otsu's threshold of all its frames together is
/// all there is: see FlightClasses::two_classes, and say so.
class OtsuSegmenter final : public Segmenter {
 public:
  /// Parameters out of range are a Usage error that names them.
  [[nodiscard]] static Status check(const OtsuParameters& parameters);

  explicit OtsuSegmenter(const OtsuParameters& parameters = {},
                         IcePolarity ice = IcePolarity::Auto);

  /// Images of a type that segment() refuses are not counted.
  void observe(const cv::Mat& image, const cv::Mat& valid) override;
  [[nodiscard]] Result<cv::Mat> segment(const cv::Mat& image, const cv::Mat& valid) const override;

  /// The polarity in use after observe(): the given one, or the flight's.
  [[nodiscard]] PolarityEstimate polarity() const;
  /// The polarity that segment() would use for this image without a flight.
  [[nodiscard]] Result<PolarityEstimate> polarity_of(const cv::Mat& image,
                                                     const cv::Mat& valid) const;
  [[nodiscard]] const FlightClasses& classes() const { return classes_; }

 private:
  struct TwoClassFrame {
    double dark, bright, sigma;
  };
  void pool(const detail::CoarseView& view);
  void learn();

  OtsuParameters parameters_;
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
