// SPDX-License-Identifier: MIT
#include "watersky/align/detail/estimates.hpp"

#include <numbers>

namespace watersky::align {

std::vector<Estimate> estimates_of(const Flight& flight, const Adjustment& adjustment,
                                   const Globals::Vector& before,
                                   const Adjustment::Knowledge* known) {
  std::vector<Estimate> out;
  const Globals::Vector& g = adjustment.state.globals;
  const auto add = [&](const char* name, const char* unit, double scale, double given, int k) {
    if (before[k] <= 0) return;
    Estimate e;
    e.name = name;
    e.unit = unit;
    e.given = given;
    e.observed = known && adjustment.priors.globals[k] > 0 &&
                 known->globals_sigma[k] <= kObserved * before[k];
    e.value = e.observed ? given + scale * g[k] : given;
    e.sigma_before = scale * before[k];
    e.sigma = e.observed ? scale * known->globals_sigma[k] : e.sigma_before;
    out.push_back(e);
  };
  constexpr double kDegree = 180 / std::numbers::pi;
  add("mount_about_image_right_deg", "deg", kDegree, 0.0, Globals::kMount);
  add("mount_about_image_down_deg", "deg", kDegree, 0.0, Globals::kMount + 1);
  add("mount_about_optical_axis_deg", "deg", kDegree, 0.0, Globals::kMount + 2);
  const Eigen::Vector3d& lever = flight.mount.lever_arm_m;
  add("mount_x_m", "m", 1.0, lever.x(), Globals::kLever);
  add("mount_y_m", "m", 1.0, lever.y(), Globals::kLever + 1);
  add("mount_z_m", "m", 1.0, lever.z(), Globals::kLever + 2);
  add("focal_scale", "1", 1.0, 1.0, Globals::kFocal);
  add("height_offset_m", "m", 1.0, 0.0, Globals::kHeight);
  add("offset_north_m", "m", 1.0, 0.0, Globals::kOffset);
  add("offset_east_m", "m", 1.0, 0.0, Globals::kOffset + 1);
  add("gimbal_base_roll_deg", "deg", kDegree, 0.0, Globals::kEncoder);
  add("gimbal_base_pitch_deg", "deg", kDegree, 0.0, Globals::kEncoder + 1);
  add("gimbal_base_yaw_deg", "deg", kDegree, 0.0, Globals::kEncoder + 2);
  add("gimbal_latency_s", "s", 1.0, 0.0, Globals::kLatency);
  add("ice_drift_north_m_s", "m/s", 1.0, 0.0, Globals::kDrift);
  add("ice_drift_east_m_s", "m/s", 1.0, 0.0, Globals::kDrift + 1);
  return out;
}

Mount corrected_mount(const Mount& given, const Adjustment& adjustment,
                      const Adjustment::Knowledge* known) {
  Mount out = given;
  const Globals::Vector& g = adjustment.state.globals;
  out.rotation = given.rotation * exp_rotation(g.segment<3>(Globals::kMount));
  out.lever_arm_m += g.segment<3>(Globals::kLever);
  if (known) {
    out.assumed = false;
    out.sigma_rad = known->globals_sigma.segment<3>(Globals::kMount).maxCoeff();
  }
  return out;
}

}  // namespace watersky::align
