// SPDX-License-Identifier: MIT
#pragma once
/// What a camera adds to every picture, learnt from a flight and taken out again: defective
/// pixels, fixed-pattern noise, vignetting.
///
/// A flight tells the camera from the sea because the sea moves through the picture. Everything
/// is therefore judged over several frames, and only what proves itself is applied: the frames
/// are halved, each half makes its own estimate, and what the halves do not share is no pattern.
/// With few frames, or a camera that sees the same all the time, nothing is corrected.
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

/// Pixels that stand out by more than 14 times the noise and leave their four neighbours untouched
/// (below 0.15 of the height, or 2.5 times the noise): no lens makes such a point. The image of a
/// floe of one pixel through a lens as sharp as diffraction at 10 µm, F/1 and 12 µm pixels allows
/// (σ of 0.4 px) gives its neighbours 0.21 of its height. Two defects side by side are left alone
/// if they stand out to one side. CV_8UC1 or CV_16UC1, else Unsupported.
[[nodiscard]] Result<std::vector<cv::Point>> find_defective_pixels(const cv::Mat& gray);

/// What a flight showed of its camera. Levels are gray levels, 8 bit or counts.
struct SensorFindings {
  std::size_t frames = 0;  ///< observed
  bool moving = false;     ///< the sea moves through the picture: the camera can be told from it
  double noise = 0.0;      ///< one sigma, from frame to frame
  double column_rms = 0.0, row_rms = 0.0, pixel_rms = 0.0;  ///< of the fixed pattern
  double pattern_left_rms = 0.0;  ///< what correct() is expected to leave of it
  /// What a corner has more than the middle: share of the level for 8 bit, counts for 16.
  double corner_step = 0.0;
  /// From the darkest to the brightest distance from the middle, in the same terms.
  double shading_range = 0.0, shading_sigma = 0.0;
  std::vector<cv::Point> defects;
  bool corrects_pattern = false;
  bool corrects_vignetting = false;

  /// One sentence for each thing that correct() does; none when it does nothing.
  [[nodiscard]] std::vector<std::string> notes() const;
};

/// observe() frames of a flight that see different places, learn() once, then correct() any.
class SensorCorrection {
 public:
  /// `image`: 8 or 16 bit, 1 or 3 (BGR) channels; `valid` as in Segmenter. The first frame
  /// decides on size and type; frames of another are not counted. Of colour images only the
  /// vignetting is learnt: their pixels were interpolated and compressed.
  void observe(const cv::Mat& image, const cv::Mat& valid = {});
  void learn();

  /// Whether correct() changes anything.
  [[nodiscard]] bool needed() const;
  /// The image as a faultless camera would have given it, of the same type; the image itself,
  /// not copied, where there is nothing to do. Of an image of another size than the observed ones
  /// (decoded smaller) only the vignetting is taken out. May be called from several threads.
  [[nodiscard]] cv::Mat correct(const cv::Mat& image) const;

  [[nodiscard]] const SensorFindings& findings() const { return findings_; }

 private:
  static constexpr std::size_t kRings = 12;
  /// What one half of the frames says.
  struct Half {
    cv::Mat sum;            ///< CV_32F of high-passed frames
    cv::Mat columns, rows;  ///< CV_32F, of the steps from one to the next
    int frames = 0;
    std::vector<std::vector<float>> slopes;  ///< radial, per ring of the radius
  };
  /// Light (its logarithm for 8 bit) by the distance from the middle; ρ = 1 in the corners. Any
  /// shape: a lens darkens the corners, a camera that corrects another lens may do the opposite.
  struct Radial {
    std::vector<double> steps;  ///< at equal distances from ρ = 0 to 1
    double sigma = 0.0;         ///< of the last
    [[nodiscard]] double step(double rho) const;
  };

  /// Gives back the frame without its finest detail.
  cv::Mat observe_pattern(const cv::Mat& gray, const cv::Mat& valid, Half& half);
  void observe_coarse(const cv::Mat& image, const cv::Mat& valid, Half& half);
  void learn_defects();
  void learn_pattern();
  void learn_vignetting();
  [[nodiscard]] static Radial fit(const std::vector<std::vector<float>>& slopes);
  [[nodiscard]] cv::Mat radial_map(cv::Size size) const;

  cv::Size size_;
  int type_ = -1;
  Half halves_[2];
  cv::Mat defect_count_;  ///< CV_8U
  cv::Mat least_, most_;  ///< of each pixel over the frames: a stuck one does not move
  cv::Mat previous_coarse_;
  double previous_energy_ = 0.0;
  std::vector<double> correlations_, noises_;

  SensorFindings findings_;
  Radial radial_;
  cv::Mat offset_;  ///< CV_32F, to subtract; empty: nothing
  cv::Mat gain_;    ///< CV_32F or CV_32FC3, to multiply by then; empty: one
};

}  // namespace watersky
