// SPDX-License-Identifier: MIT
#pragma once
/// The figures of a camera's calibration, as inline SVG.
#include <string>

#include "watersky/target_calibration/target_calibration.hpp"

namespace watersky::detail {

/// Residuals where in the image they are, magnified; their scale is drawn.
[[nodiscard]] std::string residual_svg(const TargetCalibration& calibration);
/// Residuals about nothing: a round cloud is noise.
[[nodiscard]] std::string residual_cloud_svg(const TargetCalibration& calibration);
/// How many points each part of the image has; parts without any are hatched.
[[nodiscard]] std::string coverage_svg(const TargetCalibration& calibration);
/// To which side and how far the target was tilted in each view.
[[nodiscard]] std::string tilt_svg(const TargetCalibration& calibration);
/// A straight grid as the lens shows it.
[[nodiscard]] std::string distortion_svg(const TargetCalibration& calibration);
/// How far the lens moves pixels off a straight one's, along the radius to the farthest corner.
[[nodiscard]] std::string radial_svg(const TargetCalibration& calibration);

}  // namespace watersky::detail
