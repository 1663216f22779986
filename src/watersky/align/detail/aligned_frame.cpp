// SPDX-License-Identifier: MIT
#include "watersky/align/detail/aligned_frame.hpp"

namespace watersky::align {

Result<AlignedFrame> aligned_frame(const Adjustment& adjustment, int frame,
                                   const FrameWriting& how) {
  const bool ned = how.gimbal_reference == GimbalReference::NorthEastDown;
  ModelPlatform platform = adjustment.platform(frame);
  if (how.fold_mount) {
    const Globals::Vector& g = adjustment.state.globals;
    const Mount& mount = adjustment.mount();
    const Eigen::Quaterniond was = platform.reference * platform.gimbal;
    const Eigen::Quaterniond now = was * mount.rotation *
                                   exp_rotation(g.segment<3>(Globals::kMount)) *
                                   mount.rotation.conjugate();
    platform.position_m +=
        was * (mount.lever_arm_m + g.segment<3>(Globals::kLever)) - now * mount.lever_arm_m;
    if (how.gimbal_reference)
      platform.gimbal = platform.reference.conjugate() * now;
    else
      platform.reference = now;
  }
  WATERSKY_TRY(const Eigen::Quaterniond world_from_local,
               how.local->world_from_local_rotation(platform.position_m));
  LocalPose body{platform.reference, platform.position_m};
  if (ned && how.recorded)
    if (const auto recorded = how.local->local(*how.recorded)) body.rotation = recorded->rotation;
  AlignedFrame made;
  WATERSKY_TRY(made.pose.world_from_body, how.local->world(body));
  if (how.gimbal_reference) {
    // Against the reference as it is read back: north, east, down, or the corrected body.
    if (ned) {
      const auto place = how.local->geodetic(platform.position_m);
      if (place)
        made.gimbal =
            how.local->local_from_ned(*place).conjugate() * platform.reference * platform.gimbal;
    } else {
      made.gimbal = platform.gimbal;
    }
  }
  const ModelCamera camera = adjustment.camera(frame);
  made.velocity_m_s = world_from_local * camera.velocity_m_s;
  made.turn_rate_rad_s = world_from_local * camera.rate_rad_s;
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = world_from_local.toRotationMatrix();
  made.pose.covariance = turn * how.covariance * turn.transpose();
  Eigen::Matrix<double, 6, 6> whole = how.covariance;
  whole.topLeftCorner<2, 2>() += how.shared_m2;
  PoseSigma sigma;
  sigma.position_north_east_down_m = whole.diagonal().head<3>().cwiseSqrt();
  const Eigen::Matrix3d to_body = platform.reference.toRotationMatrix().transpose();
  sigma.roll_pitch_yaw_rad =
      (to_body * whole.bottomRightCorner<3, 3>() * to_body.transpose()).diagonal().cwiseSqrt();
  made.pose.sigma = sigma;
  return made;
}

}  // namespace watersky::align
