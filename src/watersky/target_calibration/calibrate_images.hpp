// SPDX-License-Identifier: MIT
#pragma once
/// From images to a calibration: the target is found in each, then calibrate_views().
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/target_calibration/target_calibration.hpp"
#include "watersky/target_calibration/target_detection.hpp"

namespace watersky {

struct CalibrationImage {
  std::string name;                       ///< stands in reasons and in the result
  std::function<Result<cv::Mat>()> load;  ///< may be called more than once, from any thread
};

struct ImageCalibrationOptions {
  TargetRequest target;
  LensChoice lens = LensChoice::Auto;
  int threads = 1;
  CalibrationParameters parameters;
};

/// What kind and size of target are not given for is what most images show; those that show
/// something else are looked at again for that. Images that cannot be read, that are of another
/// size than most, and in which the target is not found, become views with their reason. Errors
/// are those of calibrate_views(), and NotFound when no image shows a target.
[[nodiscard]] Result<TargetCalibration> calibrate_images(
    const std::vector<CalibrationImage>& images, const ImageCalibrationOptions& options,
    const Progress& progress = {});

}  // namespace watersky
