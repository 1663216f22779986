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

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Of position and rotation along Sea's axes; nullopt where nobody said anything of them.
std::optional<Matrix6> covariance_over_sea(const Flight& flight, const StampedPose& pose,
                                           const Rigid3<Sea, World>& sea_from_world) {
  const Eigen::Matrix3d turn = sea_from_world.rotation().toRotationMatrix();
  Matrix6 covariance = Matrix6::Zero();
  if (pose.covariance) {
    // An alignment's: what was left of the mount's uncertainty is in it.
    Matrix6 both = Matrix6::Zero();
    both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = turn;
    covariance = both * *pose.covariance * both.transpose();
  } else if (pose.sigma) {
    covariance.topLeftCorner<3, 3>() =
        pose.sigma->position_north_east_down_m.cwiseAbs2().asDiagonal();
    const Eigen::Matrix3d body = turn * pose.world_from_body.rotation().toRotationMatrix();
    covariance.bottomRightCorner<3, 3>() =
        body * pose.sigma->roll_pitch_yaw_rad.cwiseAbs2().asDiagonal() * body.transpose();
    covariance.bottomRightCorner<3, 3>() +=
        flight.mount.sigma_rad * flight.mount.sigma_rad * Eigen::Matrix3d::Identity();
  } else {
    return std::nullopt;
  }
  covariance(2, 2) += flight.sea_level->sigma_m * flight.sea_level->sigma_m;
  return covariance;
}

}  // namespace

Result<Rigid3<World, Camera>> Flight::camera_at(const StampedPose& pose,
                                                const std::optional<Eigen::Quaterniond>& own_gimbal,
                                                Duration max_gap) const {
  const Rigid3<World, Body>& world_from_body = pose.world_from_body;
  Eigen::Quaterniond world_from_platform = world_from_body.rotation();
  if (gimbal_reference) {
    Eigen::Quaterniond gimbal_rotation;
    if (own_gimbal) {
      WATERSKY_TRY(const RotationTrack checked, RotationTrack::make({{pose.time, *own_gimbal}}));
      gimbal_rotation = checked.rotations().front().rotation;
    } else {
      WATERSKY_TRY(gimbal_rotation, gimbal.at(pose.time, max_gap));
    }
    world_from_platform =
        (*gimbal_reference == GimbalReference::Body
             ? world_from_body.rotation()
             : datum.world_from_ned_rotation(datum.geodetic(world_from_body.origin()))) *
        gimbal_rotation;
  }
  return Rigid3<World, Camera>(
      world_from_platform * mount.rotation,
      Point<World>{world_from_body.origin().v + world_from_platform * mount.lever_arm_m});
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

  WATERSKY_TRY(const auto world_from_camera, camera_at(pose, frame.own_gimbal, max_gap));
  const Geodetic camera_position = datum.geodetic(world_from_camera.origin());
  Geodetic sea_below = camera_position;
  WATERSKY_TRY(sea_below.height_ellipsoid_m, sea_level->height_ellipsoid_m(camera_position));
  if (!std::isfinite(sea_below.height_ellipsoid_m))
    return Error{ErrorCode::NotFound, "the height of the sea under it is not a number"};
  const Rigid3<Sea, World> sea_from_world =
      ecef_from_sea(sea_below).inverse() * datum.ecef_from_world();
  CameraPose out{
      *time,     world_from_camera, camera_position, sea_below, sea_from_world * world_from_camera,
      pose.sigma};
  out.covariance = covariance_over_sea(*this, pose, sea_from_world);
  if (readout_s > 0 && !frame.own_pose) {
    // From poses half a readout before and after; at the ends of the recording from one of them.
    const auto around = [&](double dt_s) -> std::optional<Rigid3<World, Camera>> {
      const auto at = trajectory.at(*time + seconds(dt_s), max_gap);
      if (!at) return std::nullopt;
      const auto there = camera_at(*at, frame.own_gimbal, max_gap);
      return there ? std::optional(*there) : std::nullopt;
    };
    const auto before = around(-0.5 * readout_s), after = around(0.5 * readout_s);
    const Rigid3<World, Camera>&first = before ? *before : world_from_camera,
                        &last = after ? *after : world_from_camera;
    const double span_s = readout_s * ((before ? 0.5 : 0.0) + (after ? 0.5 : 0.0));
    if (span_s > 0) {
      const Eigen::AngleAxisd turn(last.rotation() * first.rotation().conjugate());
      out.shutter = {
          readout_s, sea_from_world.rotation() * (last.origin().v - first.origin().v) / span_s,
          sea_from_world.rotation() * Eigen::Vector3d(turn.axis() * turn.angle()) / span_s};
    }
  }
  return out;
}

}  // namespace watersky
