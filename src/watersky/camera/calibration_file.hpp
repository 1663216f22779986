// SPDX-License-Identifier: MIT
#pragma once
/// OpenCV calibration files, YAML or XML (A.2.3): camera_matrix, distortion_coefficients (or
/// Camera_Matrix, Distortion_Coefficients), image_width, image_height, optional camera_model
/// (pinhole, fisheye).
#include <filesystem>

#include "watersky/camera/camera_model.hpp"

namespace watersky {

/// NotFound, or InvalidInput naming the file and the field.
[[nodiscard]] Result<CameraModel> read_calibration(const std::filesystem::path& file);

/// The same from text; `name` stands in errors and its ending (.xml, otherwise YAML) decides.
[[nodiscard]] Result<CameraModel> parse_calibration(const std::string& text,
                                                    const std::string& name);

/// Written as OpenCV itself would, so cv::FileStorage and read_calibration both read it.
[[nodiscard]] std::string format_calibration(const CameraModel& camera);

}  // namespace watersky
