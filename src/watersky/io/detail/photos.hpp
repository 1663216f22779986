// SPDX-License-Identifier: MIT
#pragma once
/// What photo_flight and log_flight share: the photographs of one camera and its intrinsics.
#include <filesystem>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/io/camera_table.hpp"
#include "watersky/io/read_options.hpp"

namespace watersky::detail {

struct PhotoFile {
  std::filesystem::path path;
  PhotoMetadata metadata;
};

struct PhotoSet {
  std::vector<PhotoFile> photos;  ///< at least one, all of one camera, by name
  std::vector<LeftOut> left_out;  ///< unreadable ones
};

/// The photographs in `folder`, or in `folder`/images when it holds none itself. NotFound when
/// there is none, InvalidInput naming two files when two cameras are mixed.
[[nodiscard]] Result<PhotoSet> read_photo_set(const std::filesystem::path& folder,
                                              const Progress& progress);

/// By --camera, --focal-px, camera.yaml or camera.xml in `folder`, or the photograph itself, in
/// this order. InvalidInput when a calibration's image has another shape than the photographs;
/// one of another size but the same shape is scaled, and `notes` says so.
[[nodiscard]] Result<Intrinsics> choose_intrinsics(const std::filesystem::path& folder,
                                                   const PhotoFile& photo,
                                                   const ReadOptions& options,
                                                   std::vector<std::string>& notes);

/// The same for images that say nothing of their lens: NotFound when there is neither option nor
/// calibration.
[[nodiscard]] Result<Intrinsics> choose_intrinsics(const std::filesystem::path& folder,
                                                   const std::string& image, int width_px,
                                                   int height_px, const ReadOptions& options,
                                                   std::vector<std::string>& notes);

/// Fits a calibration to images of `size`, as above.
[[nodiscard]] Result<CameraModel> fitted_to(const CameraModel& camera, int width_px, int height_px,
                                            const std::string& calibration,
                                            const std::string& image,
                                            std::vector<std::string>& notes);

/// "3 photographs", "1 photograph".
[[nodiscard]] std::string counted(std::size_t n, const std::string& noun);

/// The one sentence about a mount that nobody gave.
inline constexpr const char* kAssumedMountNote =
    "the mount is not known: assumed that the camera looks straight down, image top forward "
    "(give --mount ROLL,PITCH,YAW)";
inline constexpr const char* kMountOnGimbalNote =
    "--mount is taken as the camera on the gimbal, whose recorded attitude already says where it "
    "points (0,0,0 along the gimbal's forward axis)";

}  // namespace watersky::detail
