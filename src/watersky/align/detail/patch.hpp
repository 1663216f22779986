// SPDX-License-Identifier: MIT
#pragma once
/// A small piece of a picture that is looked for again in others.
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace watersky::align {

/// A window around a place of a host picture (CV_32FC1), with the gradients that finding it again
/// needs. Found by inverse compositional least squares over shift, gain and offset (Baker and
/// Matthews 2004), under a given local map from host to picture.
class Patch {
 public:
  static constexpr int kHalf = 7;
  static constexpr int kSide = 2 * kHalf + 1;

  /// nullopt where the window leaves the picture, or shows nothing that would fix it both ways.
  /// `noise`: one sigma of a pixel.
  [[nodiscard]] static std::optional<Patch> cut(const cv::Mat& picture, const Eigen::Vector2d& at,
                                                double noise);

  struct Found {
    Eigen::Vector2d at;
    double correlation = 0.0;  ///< of window and picture, -1 to 1
  };
  /// `picture_from_host` takes steps in the host to steps in the picture. nullopt where it leaves
  /// the picture, does not settle, or settles farther than `most_px` from the start.
  [[nodiscard]] std::optional<Found> find(const cv::Mat& picture, const Eigen::Vector2d& start,
                                          const Eigen::Matrix2d& picture_from_host,
                                          double most_px) const;

  /// Of where it is found, px², for unit noise: the inverse of the gradients' products.
  [[nodiscard]] const Eigen::Matrix2d& unit_covariance() const { return unit_covariance_; }

 private:
  std::vector<float> values_;                   ///< zero mean
  std::vector<float> gradient_u_, gradient_v_;  ///< less their parts along the values and 1
  double energy_ = 0.0;                         ///< sum of squared values
  Eigen::Matrix2d unit_covariance_ = Eigen::Matrix2d::Identity();
};

/// One sigma of the noise from pixel to pixel, robust against edges; CV_32FC1.
[[nodiscard]] double pixel_noise(const cv::Mat& picture);

}  // namespace watersky::align
