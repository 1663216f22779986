// SPDX-License-Identifier: MIT
#pragma once
/// The simulator's own lenses, written from OpenCV's documented formulas and sharing nothing with
/// camera/.
#include <Eigen/Core>
#include <array>
#include <optional>

#include "watersky/base/parameters.hpp"

namespace watersky::sim {

/// Intrinsics and OpenCV's distortion: pinhole k1 k2 p1 p2 k3 k4 k5 k6, fisheye k1 k2 k3 k4.
struct LensParameters {
  int width_px = 640;
  int height_px = 512;
  double focal_px = 765.0;  ///< a 13 mm lens before 17 µm pixels
  double centre_right_px = 0.0;
  double centre_down_px = 0.0;
  bool fisheye = false;
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0, k4 = 0.0, k5 = 0.0, k6 = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.width_px, ParameterInfo{"width_px", "px", "columns of the image", 8, 20000});
    visit(self.height_px, ParameterInfo{"height_px", "px", "rows of the image", 8, 20000});
    visit(self.focal_px, ParameterInfo{"focal_px", "px", "focal length", 1, 100000});
    visit(self.centre_right_px,
          ParameterInfo{"centre_right_px", "px", "principal point right of the image's middle",
                        -5000, 5000});
    visit(self.centre_down_px,
          ParameterInfo{"centre_down_px", "px", "principal point below the image's middle", -5000,
                        5000});
    visit(self.fisheye,
          ParameterInfo{"fisheye", "1", "OpenCV's fisheye lens with k1 to k4, not the pinhole"});
    visit(self.k1, ParameterInfo{"k1", "1", "radial distortion", -10, 10});
    visit(self.k2, ParameterInfo{"k2", "1", "radial distortion", -10, 10});
    visit(self.p1, ParameterInfo{"p1", "1", "tangential distortion", -1, 1});
    visit(self.p2, ParameterInfo{"p2", "1", "tangential distortion", -1, 1});
    visit(self.k3, ParameterInfo{"k3", "1", "radial distortion", -10, 10});
    visit(self.k4,
          ParameterInfo{"k4", "1", "radial distortion, denominator (fisheye: last term)", -10, 10});
    visit(self.k5, ParameterInfo{"k5", "1", "radial distortion, denominator", -10, 10});
    visit(self.k6, ParameterInfo{"k6", "1", "radial distortion, denominator", -10, 10});
  }
};

/// Directions are in the camera's frame: x right, y down, z forward. Pixels are (column, row),
/// the centre of the first is (0, 0).
class Lens {
 public:
  explicit Lens(const LensParameters& parameters);

  [[nodiscard]] double u0() const { return u0_; }
  [[nodiscard]] double v0() const { return v0_; }

  /// nullopt behind a pinhole camera, and beyond the radius where the distortion folds back.
  [[nodiscard]] std::optional<Eigen::Vector2d> pixel(const Eigen::Vector3d& direction) const;
  /// The unit direction a pixel sees, by Newton's method to 1e-12 on the image plane; nullopt
  /// where nothing within the valid radius is imaged.
  [[nodiscard]] std::optional<Eigen::Vector3d> direction(const Eigen::Vector2d& pixel) const;

 private:
  [[nodiscard]] Eigen::Vector2d distorted(const Eigen::Vector2d& p, Eigen::Matrix2d* slope) const;
  [[nodiscard]] double fisheye_radius(double angle, double* slope) const;

  LensParameters p_;
  double u0_, v0_;
  double limit_;  ///< largest tan (pinhole) or angle (fisheye) off axis before the fold
};

}  // namespace watersky::sim
