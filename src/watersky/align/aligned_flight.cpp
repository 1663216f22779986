// SPDX-License-Identifier: MIT
#include "watersky/align/alignment.hpp"
#include "watersky/align/detail/local_frame.hpp"

namespace watersky {

std::string_view name_of(AlignMethod method) {
  switch (method) {
    case AlignMethod::AsGiven: return "as given";
    case AlignMethod::ConstantDelay: return "constant delay";
    case AlignMethod::Full: return "full";
  }
  return "full";
}

Result<Flight> aligned(const Flight& flight, const Alignment& alignment) {
  Flight out = flight;
  out.frames.clear();
  out.left_out.insert(out.left_out.end(), alignment.left_out.begin(), alignment.left_out.end());
  out.mount = alignment.mount;
  out.delay_s.reset();
  out.shared_covariance_m2 = alignment.shared_covariance_m2;
  Eigen::Matrix3d matrix = flight.camera.camera_matrix();
  matrix(0, 0) *= alignment.focal_scale;
  matrix(1, 1) *= alignment.focal_scale;
  WATERSKY_TRY(out.camera,
               CameraModel::make(flight.camera.lens(), flight.camera.width_px(),
                                 flight.camera.height_px(), matrix, flight.camera.distortion()));
  std::vector<StampedPose> poses;
  std::vector<StampedRotation> gimbal;
  const double half_s = 0.5 * flight.readout_s;
  const Duration tick(1);
  for (const AlignedFrame& a : alignment.frames) {
    ImageFrame frame = flight.frames[a.index];
    Time captured = a.captured;
    // Poses must differ in time; two frames of one moment, or rows that reach into the next
    // frame, are put apart by nanoseconds.
    if (!poses.empty() && captured <= poses.back().time) captured = poses.back().time + tick;
    frame.captured_at = captured;
    frame.own_pose.reset();
    frame.own_gimbal.reset();
    const auto row = [&](double dt_s) {
      StampedPose pose = a.pose;
      pose.time = captured + seconds(dt_s);
      if (!poses.empty() && pose.time <= poses.back().time) return;
      pose.world_from_body = Rigid3<World, Body>(
          align::exp_rotation(a.turn_rate_rad_s * dt_s) * pose.world_from_body.rotation(),
          Point<World>{pose.world_from_body.origin().v + a.velocity_m_s * dt_s});
      if (a.gimbal) gimbal.push_back({pose.time, *a.gimbal});
      poses.push_back(std::move(pose));
    };
    if (half_s > 0) row(-half_s);
    row(0.0);
    if (half_s > 0) row(half_s);
    out.frames.push_back(std::move(frame));
  }
  WATERSKY_TRY(out.trajectory, Trajectory::make(std::move(poses)));
  if (flight.gimbal_reference) {
    WATERSKY_TRY(out.gimbal, RotationTrack::make(std::move(gimbal)));
  }
  return out;
}

}  // namespace watersky
