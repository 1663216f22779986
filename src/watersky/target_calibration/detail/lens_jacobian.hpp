// SPDX-License-Identifier: MIT
#pragma once
/// The lens models as least squares needs them: with their derivatives.
#include <Eigen/Core>
#include <array>
#include <string_view>
#include <vector>

#include "watersky/camera/camera_model.hpp"

namespace watersky::detail {

inline constexpr int kLensParameters = 12;

/// fx fy cx cy, then k1 k2 p1 p2 k3 k4 k5 k6 of a pinhole or k1 k2 k3 k4 of a fisheye, as
/// CameraModel has them.
struct Lens {
  LensModel model = LensModel::Pinhole;
  std::array<double, kLensParameters> parameters{};
};

/// "fx", "k1": of one of the parameters.
[[nodiscard]] std::string_view parameter_name(LensModel model, int parameter);

struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, kLensParameters> by_lens;
  Eigen::Matrix<double, 2, 3> by_point;
};

/// Where the lens shows a point of the camera's frame (2.10 to 2.12), by OpenCV's formulas. False
/// where it has no answer: not in front of a pinhole, or not finite. No regard to where the
/// distortion folds back. `derivatives`: whether by_lens and by_point are wanted.
[[nodiscard]] bool project(const Lens& lens, const Eigen::Vector3d& p_camera, bool derivatives,
                           Projection& projection);

}  // namespace watersky::detail
