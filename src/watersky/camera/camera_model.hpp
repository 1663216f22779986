// SPDX-License-Identifier: MIT
#pragma once
/// Lens models: OpenCV's pinhole with its 4, 5 or 8 distortion coefficients, and its fisheye
/// model (2.10 to 2.12). Pixels are OpenCV's: the centre of the first pixel is (0, 0).
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/geo/rigid3.hpp"

namespace watersky {

/// A position in an image: u along columns, v along rows.
struct Pixel {
  double u = 0.0;
  double v = 0.0;
};

enum class LensModel { Pinhole, Fisheye };

/// The intrinsics: fs_u, fs_v, u_0, v_0 of (2.12), the distortion, and the image size they are for.
class CameraModel {
 public:
  /// `distortion` are OpenCV's coefficients in its order: k1 k2 p1 p2 [k3 [k4 k5 k6]] for
  /// Pinhole, k1 k2 k3 k4 for Fisheye; empty or all zero for none. InvalidInput for a size or
  /// focal length that is not positive, a value that is not finite, or another count.
  [[nodiscard]] static Result<CameraModel> make(LensModel lens, int width_px, int height_px,
                                                const Eigen::Matrix3d& camera_matrix,
                                                std::vector<double> distortion = {});

  [[nodiscard]] LensModel lens() const { return lens_; }
  [[nodiscard]] int width_px() const { return width_px_; }
  [[nodiscard]] int height_px() const { return height_px_; }
  [[nodiscard]] const Eigen::Matrix3d& camera_matrix() const { return camera_matrix_; }
  [[nodiscard]] const std::vector<double>& distortion() const { return distortion_; }
  [[nodiscard]] bool distorts() const { return distorts_; }
  /// The mean of the two focal lengths.
  [[nodiscard]] double focal_px() const {
    return 0.5 * (camera_matrix_(0, 0) + camera_matrix_(1, 1));
  }

  /// The pixel that sees a direction, or nullopt when it is behind the camera (z <= 0; a fisheye
  /// sees to its own limit) or beyond the radius where the distortion polynomial folds back and
  /// would show ghosts. The pixel may lie outside the image: see contains().
  [[nodiscard]] std::optional<Pixel> project(const Vector<Camera>& direction) const;
  [[nodiscard]] std::optional<Pixel> project(const Point<Camera>& p) const {
    return project(Vector<Camera>{p.v});
  }
  /// The unit direction that a pixel sees; nullopt beyond the lens's valid radius. Undoes
  /// project() to 1e-9 rad up to 0.98 of that radius; at the radius itself the slope is 0.
  [[nodiscard]] std::optional<Vector<Camera>> direction(const Pixel& pixel) const;

  /// Whether a pixel position lies on the image, half a pixel around the outer centres included.
  [[nodiscard]] bool contains(const Pixel& p) const {
    return p.u >= -0.5 && p.v >= -0.5 && p.u <= width_px_ - 0.5 && p.v <= height_px_ - 0.5;
  }

  /// The same lens on an image of another size; keeps pixel centres: u0' = (u0 + ½)s - ½.
  [[nodiscard]] CameraModel scaled_to(int width_px, int height_px) const;

  /// The same lens on an image reduced by a whole number, each pixel the mean of n x n, as JPEG
  /// decoders do it: sizes are rounded up, so the last column and row may be partly empty.
  [[nodiscard]] CameraModel reduced_by(int n) const;

  /// The same camera without distortion (an undistorted image's model).
  [[nodiscard]] CameraModel without_distortion() const;

  /// Largest undistorted radius (tan of the angle off axis; the angle itself for Fisheye) at
  /// which the distortion still grows: at most 20 for a pinhole that distorts, π for a fisheye.
  /// Infinite for a pinhole without distortion.
  [[nodiscard]] double max_radius() const { return max_radius_; }

 private:
  CameraModel() = default;
  [[nodiscard]] CameraModel scaled(double su, double sv, int width_px, int height_px) const;

  LensModel lens_ = LensModel::Pinhole;
  int width_px_ = 0;
  int height_px_ = 0;
  Eigen::Matrix3d camera_matrix_ = Eigen::Matrix3d::Identity();
  std::vector<double> distortion_;  ///< padded to 8 (Pinhole) or 4 (Fisheye)
  bool distorts_ = false;
  double max_radius_ = 0.0;
};

/// Where a camera's intrinsics come from: every report says it.
struct CalibrationSource {
  std::string description;      ///< "camera.yaml", "EXIF focal length and the table (DJI FC300S)"
  double focal_sigma_px = 0.0;  ///< one sigma; 0 when the source does not say
};

/// Removes distortion from images of one camera; the tables are made once.
class Undistorter {
 public:
  explicit Undistorter(const CameraModel& camera);

  /// The image as the distortion-free camera sees it. Where the original shows nothing the
  /// result is 0 and `valid` (CV_8U, 255 valid) is 0: a border is no evidence. `image` must have
  /// the camera's size.
  void undistort(const cv::Mat& image, cv::Mat& undistorted, cv::Mat& valid) const;

  /// The model of the undistorted images.
  [[nodiscard]] const CameraModel& undistorted_camera() const { return undistorted_; }

 private:
  CameraModel undistorted_;
  cv::Mat map_u_, map_v_, valid_;
};

}  // namespace watersky
