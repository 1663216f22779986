// SPDX-License-Identifier: MIT
#pragma once
/// Intrinsics from what a photograph says of its camera and a table of cameras that fly often.
#include <optional>
#include <string_view>

#include "watersky/camera/camera_model.hpp"
#include "watersky/io/exif.hpp"

namespace watersky {

struct KnownCamera {
  std::string_view model;        ///< as EXIF's Model writes it
  std::string_view common_name;  ///< "DJI Phantom 3 Advanced"
  double sensor_width_mm = 0.0;  ///< of the `width_px` pixels
  int width_px = 0;              ///< full resolution; binned modes share the sensor's width
  int height_px = 0;
  double focal_mm = 0.0;      ///< of a fixed lens when EXIF does not say; 0: EXIF must
  double focal_sigma = 0.02;  ///< one sigma of the nominal focal length, relative
  bool wide_fisheye = false;  ///< a pinhole does not describe it: only a calibration does
};

/// nullptr when the camera is not in the table.
[[nodiscard]] const KnownCamera* find_known_camera(std::string_view make, std::string_view model);

struct Intrinsics {
  CameraModel camera;
  CalibrationSource source;
};

/// The best that a photograph offers: DJI's own calibration of this very camera (DewarpData),
/// its CalibratedFocalLength, the focal length with the table or with the sensor's resolution,
/// the 35 mm equivalent. NotFound, explaining --camera and --focal-px, when there is none.
[[nodiscard]] Result<Intrinsics> intrinsics_from(const PhotoMetadata& photo);

/// A pinhole with its centre in the image's middle.
[[nodiscard]] Result<Intrinsics> intrinsics_from_focal_px(double focal_px, int width_px,
                                                          int height_px);

}  // namespace watersky
