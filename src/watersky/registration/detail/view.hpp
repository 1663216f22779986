// SPDX-License-Identifier: MIT
#pragma once
/// A picture reduced and made even in contrast: what the eyes of the KLT registrar see.
#include <Eigen/Core>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

#include "watersky/registration/registration.hpp"

namespace watersky::detail {

/// One scale of a picture. Its pixel x is the mean of full pixels s x to s x + s - 1.
struct View {
  int reduction = 1;   ///< s
  cv::Mat levels;      ///< CV_8UC1: kMiddle + kGain times the normalised value, clamped
  cv::Mat valid;       ///< CV_8UC1 or empty: all
  cv::Mat textured;    ///< CV_8UC1: where there is more than noise; of even_view() alone
  double texture = 0;  ///< rms of what is left after flattening, gray levels
  double noise = 0;    ///< rms from pixel to pixel where the view is quietest, before blurring
  double blur_px = 0;  ///< that was taken against the noise
  [[nodiscard]] cv::Size size() const { return levels.size(); }
  /// Full pixels from this view's.
  [[nodiscard]] Eigen::Matrix3d full_from_view() const;
};

inline constexpr double kMiddle = 128.0, kGain = 32.0;

/// Local mean taken out and divided by the local spread, which makes a picture of c times the
/// contrast, and one in other units, the same but for its noise. Blurred so far that the noise is
/// a quarter of the texture: gradients of noise pull a track to where it began.
[[nodiscard]] View even_view(const cv::Mat& gray, const cv::Mat& valid, int reduction);
/// The places that tracking does best at: strongest corners, apart from each other.
[[nodiscard]] std::vector<cv::Point2f> corners_in(const View& view, int most, double apart_px);

/// A finer scale: nothing done to it but averaging.
struct Scale {
  int reduction = 1;
  cv::Mat pixels;  ///< CV_32FC1
  cv::Mat valid;   ///< CV_8UC1 or empty
  /// Inside `outline`, spread over it.
  [[nodiscard]] std::vector<cv::Point2f> corners(int most,
                                                 const std::vector<cv::Point2f>& outline) const;
};
[[nodiscard]] Eigen::Matrix3d full_from_reduced(int reduction);

struct Features {
  std::vector<cv::KeyPoint> keypoints;  ///< in the view's pixels
  cv::Mat descriptors;                  ///< RootSIFT, CV_32F; of small pictures ORB, CV_8U
};

/// A frame of the KLT registrar. The coarse view is made at once, the others when first needed.
class KltFrame final : public RegistrationFrame::Data {
 public:
  KltFrame(cv::Mat gray, cv::Mat valid);

  [[nodiscard]] const View& coarse() const { return coarse_; }
  /// A few thousand floats about 0, tapered at the border; reduced again from coarse().
  [[nodiscard]] const cv::Mat& tiny() const { return tiny_; }
  [[nodiscard]] int tiny_reduction() const { return tiny_reduction_; }
  [[nodiscard]] const std::vector<cv::Point2f>& coarse_corners() const;
  /// coarse() as track_near() wants it.
  [[nodiscard]] Scale coarse_scale() const;
  /// Scales finer than coarse(), each about three times the one before; the last is full size.
  [[nodiscard]] std::size_t finer_scales() const { return finer_reductions_.size(); }
  [[nodiscard]] const Scale& finer(std::size_t i) const;
  /// The blur that the noise would ask for at a finer scale, its pixels.
  [[nodiscard]] double finer_blur_px(std::size_t i) const;
  /// SIFT of a view of some 900 pixels; of a small picture ORB of the coarse one, which costs a
  /// tenth.
  [[nodiscard]] const Features& features() const;
  [[nodiscard]] const View& feature_view() const { return *feature_view_; }

 private:
  cv::Mat gray_, valid_;
  View coarse_;
  cv::Mat tiny_;
  int tiny_reduction_ = 1;
  std::vector<int> finer_reductions_;
  // What is made when first needed; once_flag because frames are shared between threads.
  mutable std::once_flag corners_once_, features_once_;
  mutable std::vector<cv::Point2f> corners_;
  mutable std::vector<Scale> finer_;
  mutable std::unique_ptr<std::once_flag[]> finer_once_;
  mutable Features features_;
  mutable View feature_own_;
  mutable const View* feature_view_ = nullptr;
};

}  // namespace watersky::detail
