// SPDX-License-Identifier: MIT
#pragma once
/// What comes out of calibrating a camera, as files: camera.yaml (an OpenCV calibration file, as
/// `watersky map --camera` takes it), calibration.json and report.html. Names and contents are a
/// contract.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "watersky/target_calibration/target_calibration.hpp"

namespace watersky {

struct CameraCalibrationRun {
  TargetCalibration calibration;
  LensChoice lens = LensChoice::Auto;  ///< as asked for
  CalibrationParameters parameters;
  /// Between neighbouring points of the target; without it lengths are in spacings. The
  /// intrinsics do not depend on it.
  std::optional<double> spacing_m;
  /// JPEGs of the views, in their order, from view_jpeg(); a view may have none.
  std::vector<std::string> pictures;
};

/// The image with the points that were found in it, at most 480 px wide: circles are points that
/// were used, crosses those that were not. Empty when it cannot be encoded.
[[nodiscard]] std::string view_jpeg(const cv::Mat& image, const CalibrationView& view);

[[nodiscard]] nlohmann::json camera_calibration_json(const CameraCalibrationRun& run);
[[nodiscard]] std::string camera_calibration_report_html(const CameraCalibrationRun& run);

/// The three files.
Status write_camera_calibration(const std::filesystem::path& folder,
                                const CameraCalibrationRun& run);

/// Whether OUT may be made: as check_output(), with calibration.json as the mark of an earlier
/// run. An empty folder may stand there.
Status check_calibration_output(const std::filesystem::path& out, bool overwrite);

}  // namespace watersky
