// SPDX-License-Identifier: MIT
#pragma once
/// What a flight recorded, in the order of time, as recordings hold it.
#include <functional>
#include <string>

#include "watersky/flight/flight.hpp"
#include "watersky/io/detail/frame_tree.hpp"
#include "watersky/io/recording_write.hpp"

namespace watersky::detail {

inline constexpr const char* kMapFrame = "map";
inline constexpr const char* kBodyFrame = "base_link";
inline constexpr const char* kGimbalFrame = "gimbal";
inline constexpr const char* kCameraFrame = "camera";

/// What a timeline calls, each where it stands in time; frames with no time follow what is before
/// them.
struct TimelineUse {
  std::function<Status(const StampedPose&)> pose;
  std::function<Status(const StampedRotation&)> gimbal;
  std::function<Status(const RangeSample&)> range;
  std::function<Status(std::size_t frame, Time)> frame;
};
[[nodiscard]] Status for_timeline(const Flight& flight, const TimelineUse& use);

/// map (east, north, up at the datum) from base_link (forward, left, up).
[[nodiscard]] RigidMotion map_from_base(const Flight& flight, const Rigid3<World, Body>& pose);
/// The camera on base_link or, where a gimbal is recorded, on the gimbal.
[[nodiscard]] RigidMotion platform_from_camera(const Flight& flight);
/// The gimbal (forward, left, up) on base_link, of `own` or of the trajectory's pose at that time;
/// nullopt where its attitude is against north and there is none.
[[nodiscard]] std::optional<RigidMotion> base_from_gimbal(
    const Flight& flight, const StampedRotation& gimbal,
    const std::optional<StampedPose>& own = std::nullopt);

/// OpenCV's coefficients under ROS's name: "plumb_bob" with five, "rational_polynomial" with eight,
/// `fisheye_name` with four.
struct NamedDistortion {
  std::string model;
  std::vector<double> d;
};
[[nodiscard]] NamedDistortion distortion_of(const CameraModel& camera, const char* fisheye_name);

/// A frame's image as it stands in the recording.
[[nodiscard]] Result<EncodedImage> image_bytes(const ImageFrame& frame,
                                               const WriteRecordingOptions& options);

}  // namespace watersky::detail
