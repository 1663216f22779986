// SPDX-License-Identifier: MIT
#include "watersky/flight/flight.hpp"

#include <cmath>

namespace watersky {

Result<Time> Flight::capture_time(const ImageFrame& frame) const {
  if (frame.captured_at) return *frame.captured_at;
  if (!frame.received_at)
    return Error{ErrorCode::OutOfRange, "it has neither a capture time nor an arrival time"};
  if (!delay_s)
    return Error{ErrorCode::OutOfRange,
                 "only its arrival time is known; give the delay (delay_s) or align the flight"};
  // A double holds the time to 0.2 µs: enough to see whether it fits, not enough to be it.
  const double captured_s = to_seconds(*frame.received_at) - *delay_s;
  if (!time_from_seconds(captured_s) || !time_from_seconds(*delay_s))
    return Error{ErrorCode::OutOfRange, "its arrival time less the delay (delay_s) is no time"};
  return *frame.received_at - seconds(*delay_s);
}

Result<CameraPose> Flight::camera_pose(const ImageFrame& frame, Duration max_gap) const {
  if (!sea_level || !sea_level->height_ellipsoid_m)
    return Error{ErrorCode::NotFound, "the height of the sea is not known"};

  std::optional<Time> time;
  if (!frame.own_pose || (gimbal_reference && !frame.own_gimbal)) {
    WATERSKY_TRY(time, capture_time(frame));
  } else {
    time = frame.own_pose->time;
  }
  StampedPose pose;
  if (frame.own_pose) {
    WATERSKY_TRY(const Trajectory checked, Trajectory::make({*frame.own_pose}));
    pose = checked.poses().front();
  } else {
    WATERSKY_TRY(pose, trajectory.at(*time, max_gap));
  }

  const Rigid3<World, Body>& world_from_body = pose.world_from_body;
  Eigen::Quaterniond world_from_platform = world_from_body.rotation();
  if (gimbal_reference) {
    Eigen::Quaterniond gimbal_rotation;
    if (frame.own_gimbal) {
      WATERSKY_TRY(const RotationTrack checked, RotationTrack::make({{*time, *frame.own_gimbal}}));
      gimbal_rotation = checked.rotations().front().rotation;
    } else {
      WATERSKY_TRY(gimbal_rotation, gimbal.at(*time, max_gap));
    }
    world_from_platform =
        (*gimbal_reference == GimbalReference::Body
             ? world_from_body.rotation()
             : datum.world_from_ned_rotation(datum.geodetic(world_from_body.origin()))) *
        gimbal_rotation;
  }
  const Rigid3<World, Camera> world_from_camera(
      world_from_platform * mount.rotation,
      Point<World>{world_from_body.origin().v + world_from_platform * mount.lever_arm_m});

  const Geodetic camera_position = datum.geodetic(world_from_camera.origin());
  Geodetic sea_below = camera_position;
  WATERSKY_TRY(sea_below.height_ellipsoid_m, sea_level->height_ellipsoid_m(camera_position));
  if (!std::isfinite(sea_below.height_ellipsoid_m))
    return Error{ErrorCode::NotFound, "the height of the sea under it is not a number"};
  const Rigid3<Sea, World> sea_from_world =
      ecef_from_sea(sea_below).inverse() * datum.ecef_from_world();
  return CameraPose{
      *time,     world_from_camera, camera_position, sea_below, sea_from_world * world_from_camera,
      pose.sigma};
}

}  // namespace watersky
