// SPDX-License-Identifier: MIT
#pragma once
/// FLIR's radiometric JPEG: beside the picture for people it holds the sensor's 16-bit counts, in
/// APP1 segments that begin "FLIR\0" and together make an FFF file.
///
/// Experimental: written from the format's description (the tag tables of ExifTool's
/// documentation) and tested on bytes made from it; no real file has been read yet.
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>

#include "watersky/flight/thermal_scale.hpp"

namespace watersky {

struct FlirImage {
  cv::Mat counts;                           ///< CV_16UC1
  std::optional<PlanckThermalScale> scale;  ///< of the camera's record, where it is whole
  std::string camera;                       ///< "FLIR Tau 640", may be empty
};

/// nullopt for a JPEG without such counts; InvalidInput when they are damaged. `name` stands in
/// errors.
[[nodiscard]] Result<std::optional<FlirImage>> find_flir_image(std::span<const std::uint8_t> jpeg,
                                                               const std::string& name);

}  // namespace watersky
