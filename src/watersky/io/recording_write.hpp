// SPDX-License-Identifier: MIT
#pragma once
/// A flight as an MCAP file, our own recording: Foxglove shows it without configuration, and
/// read_message_flight() gives the same flight back.
///
/// Attached are flight.yaml, camera.yaml and known points as a flight folder has them; messages in
/// the order of time are protobuf: watersky Pose, Frame, Gimbal and Range hold what was recorded,
/// exactly; foxglove FrameTransform (/tf: map, east, north, up, from base_link, forward, left, up,
/// from camera), LocationFix (/fix), CameraCalibration and CompressedImage (/camera/…) show it.
#include <filesystem>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/io/flight_folder.hpp"

namespace watersky {

struct WriteRecordingOptions {
  /// Images that are files (JPEG, PNG) are kept as they are; others are encoded thus.
  bool jpeg = false;  ///< otherwise PNG, which loses nothing; 16 bit images always are
  int jpeg_quality = 95;
  std::size_t chunk_bytes = std::size_t{1} << 17;  ///< what damage to the file takes at least
  bool replace = false;                            ///< what is there already
};

/// Returns the frames that could not be written (an image that cannot be read) and why. The file
/// appears whole or not at all; Exists when it is there and is not to be replaced.
[[nodiscard]] Result<std::vector<LeftOut>> write_mcap_flight(
    const Flight& flight, const std::filesystem::path& file,
    const WriteRecordingOptions& options = {}, const Progress& progress = {});

/// A flight as a ROS 1 bag: /camera/image/compressed and /camera/camera_info, /tf and /tf_static
/// with the frames above, /fix (NavSatFix), /range. A bag holds less than a flight: names of
/// frames, sigmas, known points, readout and where the sea is are not in it, and a frame's time is
/// its time of capture. Frames without one are left out.
[[nodiscard]] Result<std::vector<LeftOut>> write_bag_flight(
    const Flight& flight, const std::filesystem::path& file,
    const WriteRecordingOptions& options = {}, const Progress& progress = {});

}  // namespace watersky
