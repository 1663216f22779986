// SPDX-License-Identifier: MIT
#pragma once
/// One picture onto another: the homography that takes pixels of A to pixels of B.
///
///   WATERSKY_TRY(const auto registrar, make_registrar(RegistrationMethod::Klt));
///   WATERSKY_TRY(auto previous, registrar->prepare(first));
///   for (…) {
///     WATERSKY_TRY(auto frame, registrar->prepare(image));
///     WATERSKY_TRY(const Registration r, registrar->align(previous, frame));
///     if (r.fit) …  // r.reason says why not
///     previous = std::move(frame);
///   }
///
/// Orb, Sift, Akaze and Surf are the thesis's procedure (4.3.2) to the letter: brute force
/// matching, matches farther than twice the least distance dropped, at least 4 left, RANSAC, and
/// success where the mean reprojection error of what is left is below 5 px.
///
/// Klt is ours, made for ice of little contrast: detectors with fixed contrast thresholds find
/// nothing there, while tracking places that are merely the best there are still works. A start is
/// found by correlation over turns and shifts at a few thousand pixels; corners are tracked both
/// ways in the contrast-normalised picture; MAGSAC++ and least squares give the homography, at
/// ever finer scale. What comes out is believed only if the pictures themselves agree under it far
/// beyond chance, all over their overlap. Where that fails, SIFT on the normalised picture makes
/// another start. docs/registration.md has the figures.
#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

enum class RegistrationMethod { Klt, Orb, Sift, Akaze, Surf };

[[nodiscard]] std::span<const RegistrationMethod> registration_methods();
/// "klt", "orb", "sift", "akaze", "surf".
[[nodiscard]] std::string_view name_of(RegistrationMethod method);
[[nodiscard]] std::optional<RegistrationMethod> registration_method(std::string_view name);
/// Unsupported where this build's OpenCV lacks the method: SURF without its nonfree part.
[[nodiscard]] Status available(RegistrationMethod method);

/// The same place in both pictures. Pixels; the centre of the first is 0,0.
struct PointPair {
  cv::Point2d a, b;
  /// Of b for a given a, px², up to a factor that all pairs share: along an edge a window slides.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
};

/// A homography that was found, and how well it is known.
struct HomographyFit {
  /// Pixels of A to pixels of B, the last element 1.
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  /// Of h11, h12, h13, h21, h22, h23, h31, h32 (row-major, h33 = 1), scaled by the residuals.
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();
  /// The same knowledge as where A's corner pixels fall in B, px²: x, y of the top left, top
  /// right, bottom right, bottom left one.
  Eigen::Matrix<double, 8, 8> corner_covariance = Eigen::Matrix<double, 8, 8>::Zero();
  /// Root mean square over the four corners of the predicted error of where they fall, px of B.
  double corner_sigma_px = 0.0;
  std::vector<PointPair> inliers;  ///< what it was estimated from
};

/// What came of a pair. Without a fit `reason` says why, in a clause.
struct Registration {
  std::optional<HomographyFit> fit;
  std::string reason;
  std::vector<cv::Point2d> points_a, points_b;  ///< detected; Klt detects in A alone
  std::vector<PointPair> matches;               ///< after the method's own rule
  /// Of the homography before it was judged, mean distance in B, px; NaN where there was none.
  double mean_reprojection_px = std::numeric_limits<double>::quiet_NaN();  ///< over `matches`
  double inlier_mean_px = std::numeric_limits<double>::quiet_NaN();
  std::size_t inliers = 0;  ///< of the estimate before it was judged
  /// Correlation of the normalised pictures under the homography, Klt alone; else NaN.
  double correlation = std::numeric_limits<double>::quiet_NaN();
  double overlap = std::numeric_limits<double>::quiet_NaN();  ///< share of A seen in B; Klt alone
  /// Refused although the pictures agree: what they share leaves a corner of A too uncertain.
  bool ill_determined = false;
  std::string_view start;  ///< what Klt began from: "given", "correlation", "features"
};

/// A picture made ready for one registrar. Cheap to copy; keeps the pixels it was made of.
class RegistrationFrame {
 public:
  struct Data {
    virtual ~Data() = default;
    cv::Size size;
  };
  RegistrationFrame() = default;
  explicit RegistrationFrame(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  [[nodiscard]] const Data* data() const { return data_.get(); }
  [[nodiscard]] cv::Size size() const { return data_ ? data_->size : cv::Size(); }

 private:
  std::shared_ptr<const Data> data_;
};

/// Const members may be called from several threads.
class Registrar {
 public:
  virtual ~Registrar() = default;

  /// 8 or 16 bit, 1 or 3 (BGR) channels, else Unsupported. `valid` (CV_8UC1 of its size or empty)
  /// is 0 where nothing must be used. The pixels must not change while the frame lives.
  [[nodiscard]] virtual Result<RegistrationFrame> prepare(const cv::Mat& image,
                                                          const cv::Mat& valid = {}) const = 0;

  /// Frames that another registrar prepared are Usage errors; a pair without an answer is a
  /// Registration without a fit. `start`, where the homography is known roughly (some tens of
  /// pixels), is tried first by Klt; the others ignore it.
  [[nodiscard]] virtual Result<Registration> align(
      const RegistrationFrame& a, const RegistrationFrame& b,
      const std::optional<Eigen::Matrix3d>& start = std::nullopt) const = 0;
};

/// Unsupported as available() says.
[[nodiscard]] Result<std::unique_ptr<Registrar>> make_registrar(RegistrationMethod method);

/// Both pictures side by side: circles are what was detected, lines the matches, as in the
/// thesis's Figure 4.8; inliers in another colour. CV_8UC3, no wider than `most_width_px`.
[[nodiscard]] cv::Mat draw_matches(const cv::Mat& a, const cv::Mat& b, const Registration& found,
                                   int most_width_px = 1600);

}  // namespace watersky
