// SPDX-License-Identifier: MIT
#pragma once
/// An MCAP file or a ROS 1 bag as a flight.
#include "watersky/io/photo_flight.hpp"

namespace watersky {

/// Whether the name ends in .mcap, .bag or .active (a bag whose recorder crashed).
[[nodiscard]] bool is_message_recording(const std::filesystem::path& file);

/// One pass over the file; pixels are decoded when they are asked for. An MCAP file that
/// write_mcap_flight() made is read as that flight.
///
/// Otherwise: images are those of ReadOptions::image_topic, or of the only topic that has some
/// (sensor_msgs Image and CompressedImage in ROS 1 and ROS 2, foxglove CompressedImage and
/// RawImage), at the stamps of their headers; with ReadOptions::delay_s those are arrivals. The
/// lens is ReadOptions::camera_file or focal_px, or the CameraInfo (foxglove CameraCalibration) on
/// the topic beside the images', or the only one.
///
/// Poses are the chain of /tf and /tf_static from ReadOptions::camera_frame (the images' frame_id)
/// to ReadOptions::map_frame (the chain's top), with odometry and PoseStamped as links of it where
/// /tf does not tell the same; the static links next to the camera are its mount. Where the camera
/// is no frame of the recording the only frame that moves is the body. Without any of these,
/// positions are NavSatFix's and attitudes Imu's. The map frame is east, north, up as REP 103 has
/// it; where it stands is ReadOptions::datum or what NavSatFix says.
///
/// NotFound, Unsupported or InvalidInput say which of these is missing, what there is, and the
/// option that helps. What is damaged in the file is left out and noted. The sea level is not set.
[[nodiscard]] Result<RecordedFlight> read_message_flight(const std::filesystem::path& file,
                                                         const ReadOptions& options,
                                                         const Progress& progress = {});

}  // namespace watersky
