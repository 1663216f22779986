// SPDX-License-Identifier: MIT
#pragma once
/// The default method: a small trained classifier that is not told whether ice is brighter or
/// darker, and whose probabilities mean what they say.
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/vision/ice_model.hpp"
#include "watersky/vision/otsu.hpp"
#include "watersky/vision/segmenter.hpp"

namespace watersky {

/// Fast decides at a quarter of the size and reads the rest off the gray levels; Best also looks
/// at twice the size.
enum class SegmentationQuality { Fast, Standard, Best };

struct LearnedParameters {
  bool ponds_are_ice = false;  ///< melt ponds on floes count as ice
};

/// P(ice) by two small networks at two scales, see docs/segmentation.md.
///
/// A gray image does not say by its levels which class is ice. Unless that is given, it is found
/// from the shapes and surfaces of the classes, in a flight from the shapes in all its frames.
/// Where it is not sure (kSureOfPolarity), P(ice) lies as much nearer to one half. In colour ice is
/// white.
///
/// Without observe() every image is judged by itself. After it, a gray frame that does not show
/// two classes is split by the levels of the flight's ice and water, as OtsuSegmenter does it, so
/// that a frame of water alone stays water. Nothing is known (NaN) of a gray image without
/// contrast that could be ice against water, see two_class.hpp, that is not of a flight.
class LearnedSegmenter final : public Segmenter {
 public:
  /// `model` must hold networks for the kind of images that it is given, gray or colour:
  /// otherwise segment() is Unsupported and says how to train them.
  explicit LearnedSegmenter(const LearnedParameters& parameters = {},
                            SegmentationQuality quality = SegmentationQuality::Standard,
                            IcePolarity ice = IcePolarity::Auto,
                            const IceModel& model = IceModel::shipped());

  void observe(const cv::Mat& image, const cv::Mat& valid) override;
  [[nodiscard]] Result<cv::Mat> segment(const cv::Mat& image, const cv::Mat& valid) const override;
  [[nodiscard]] Findings findings() const override;
  [[nodiscard]] Findings findings_of(const cv::Mat& image, const cv::Mat& valid) const override;

  /// The polarity in use after observe(): the given one, or the flight's.
  [[nodiscard]] PolarityEstimate polarity() const;

  /// Probabilities of melt pond, ice and open water, CV_32FC3, NaN where segment() does not know.
  /// As the image's most likely polarity has it; of frames that show one class only, nothing.
  [[nodiscard]] Result<cv::Mat> classify(const cv::Mat& image, const cv::Mat& valid) const;

 private:
  struct View;
  [[nodiscard]] bool observed(const cv::Mat& image) const;
  [[nodiscard]] bool in_colour(const cv::Mat& image) const;
  [[nodiscard]] double flight_p_brighter() const;
  [[nodiscard]] Result<View> look(const cv::Mat& image, const cv::Mat& valid, bool by_flight) const;
  [[nodiscard]] cv::Mat p_of_view(const View& view, const cv::Mat& image,
                                  const cv::Mat& valid) const;
  [[nodiscard]] std::vector<cv::Mat> best_scores(const View& view, const cv::Mat& valid) const;

  LearnedParameters parameters_;
  SegmentationQuality quality_;
  IcePolarity ice_;
  IceModel model_;
  /// Knows where a flight's ice and water lie, for frames that show only one of them.
  OtsuSegmenter levels_;
  std::size_t frames_ = 0, colour_frames_ = 0, polarity_frames_ = 0;
  double polarity_sum_ = 0.0;  ///< log-odds of bright ice
  int depth_ = -1;
};

}  // namespace watersky
