// SPDX-License-Identifier: MIT
#include "watersky/align/detail/adjustment.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/align/detail/adjustment_problem.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky::align {

namespace {

/// The piece of a broken line over rising `times` that holds `t`, and how far along it.
std::pair<int, double> piece_of(const std::vector<double>& times, double t) {
  if (times.size() < 2) return {0, 0.0};
  const auto after = std::upper_bound(times.begin(), times.end(), t);
  const auto i = std::clamp<std::ptrdiff_t>(after - times.begin() - 1, 0,
                                            static_cast<std::ptrdiff_t>(times.size()) - 2);
  const auto k = static_cast<std::size_t>(i);
  return {static_cast<int>(i), std::clamp((t - times[k]) / (times[k + 1] - times[k]), 0.0, 1.0)};
}

}  // namespace

ModelCamera ModelCamera::at_row(double row, double readout_s) const {
  if (row == 0.0 || readout_s == 0.0) return *this;
  const double dt = row * readout_s;
  return {exp_rotation(rate_rad_s * dt) * rotation, position_m + dt * velocity_m_s, velocity_m_s,
          rate_rad_s};
}

void Adjustment::reset() {
  state.knots.assign(knot_times_s.size(), {});
  state.delay_s.assign(delay_knot_times_s.size(), delay_start_s);
  state.jitter_s.assign(frames.size(), 0.0);
  state.extra.assign(frames.size(), {});
  state.globals.setZero();
}

std::pair<int, double> Adjustment::delay_place(double base_s) const {
  return piece_of(delay_knot_times_s, base_s);
}

std::pair<int, double> Adjustment::knot_place(double t_s) const {
  return piece_of(knot_times_s, t_s);
}

void Adjustment::evaluate(int index, const AdjustmentState& s, bool derivatives,
                          Evaluated& out) const {
  const auto i = static_cast<std::size_t>(index);
  const AdjustedFrame& frame = frames[i];
  const Globals::Vector& g = s.globals;
  const Blocks blocks = blocks_of(s);

  double delay_s = 0.0;
  std::pair<int, double> place{0, 0.0};
  const bool delayed = frame.delayed && !frame.own && !s.delay_s.empty();
  if (delayed) {
    place = delay_place(frame.base_s);
    const auto k = static_cast<std::size_t>(place.first);
    delay_s = s.delay_s[k] + s.jitter_s[i];
    if (place.second > 0.0) delay_s += place.second * (s.delay_s[k + 1] - s.delay_s[k]);
  }
  out.t_s = frame.base_s - delay_s;
  const NavigationSample nav =
      frame.own ? *frame.own : navigation_->at(out.t_s, g[Globals::kLatency]);

  Eigen::Matrix<double, 6, 1> error = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
      s.knots[static_cast<std::size_t>(frame.knot)].data());
  if (frame.weight > 0.0)
    error += frame.weight * (Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
                                 s.knots[static_cast<std::size_t>(frame.knot) + 1].data()) -
                             error);
  error += Eigen::Map<const Eigen::Matrix<double, 6, 1>>(s.extra[i].data());

  const Eigen::Vector3d turn = error.tail<3>();
  const Eigen::Vector3d encoder = g.segment<3>(Globals::kEncoder);
  const Eigen::Vector3d boresight = g.segment<3>(Globals::kMount);
  const Eigen::Quaterniond reference = exp_rotation(turn) * nav.reference;
  const Eigen::Quaterniond geared = reference * exp_rotation(encoder);
  const Eigen::Quaterniond platform = geared * nav.gimbal;
  const Eigen::Vector3d arm = platform * (mount_.lever_arm_m + g.segment<3>(Globals::kLever));
  ModelCamera& camera = out.camera;
  camera.rotation = platform * mount_.rotation * exp_rotation(boresight);
  camera.position_m = nav.position_m + error.head<3>() + arm;
  camera.position_m.z() -= g[Globals::kHeight];
  camera.position_m.head<2>() += g.segment<2>(Globals::kOffset);
  const Eigen::Vector3d gimbal_rate = geared * nav.gimbal_rate_rad_s;
  camera.rate_rad_s = exp_rotation(turn) * nav.reference_rate_rad_s + gimbal_rate;
  camera.velocity_m_s = nav.velocity_m_s + camera.rate_rad_s.cross(arm);
  out.count = 0;
  if (!derivatives) return;

  const auto slot = [&](int block, int size) -> auto& {
    Slot& made = out.slots[static_cast<std::size_t>(out.count++)];
    made.block = block;
    made.size = size;
    made.by.setZero(6, size);
    return made.by;
  };
  const Eigen::Matrix3d turns_arm = -skew(arm);  // δp of a left rotation of the platform
  Matrix6 by_error = Matrix6::Identity();
  by_error.bottomRightCorner<3, 3>() = left_jacobian(turn);
  by_error.topRightCorner<3, 3>() = turns_arm * left_jacobian(turn);
  slot(frame.knot, 6) = (1.0 - frame.weight) * by_error;
  if (frame.weight > 0.0) slot(frame.knot + 1, 6) = frame.weight * by_error;
  if (delayed) {
    Eigen::Matrix<double, 6, 1> by_delay;
    by_delay << -camera.velocity_m_s, -camera.rate_rad_s;
    slot(blocks.delay(place.first), 1) = (1.0 - place.second) * by_delay;
    if (place.second > 0.0) slot(blocks.delay(place.first + 1), 1) = place.second * by_delay;
    if (priors.jitter_s > 0.0) slot(blocks.jitter(index), 1) = by_delay;
  }
  auto& by_globals = slot(blocks.globals(), Globals::kSize);
  by_globals.block<3, 3>(3, Globals::kMount) =
      camera.rotation.toRotationMatrix() * left_jacobian(boresight).transpose();
  by_globals.block<3, 3>(0, Globals::kLever) = platform.toRotationMatrix();
  by_globals(2, Globals::kHeight) = -1.0;
  by_globals.block<2, 2>(0, Globals::kOffset).setIdentity();
  const Eigen::Matrix3d encoder_turn = reference.toRotationMatrix() * left_jacobian(encoder);
  by_globals.block<3, 3>(3, Globals::kEncoder) = encoder_turn;
  by_globals.block<3, 3>(0, Globals::kEncoder) = turns_arm * encoder_turn;
  by_globals.block<3, 1>(3, Globals::kLatency) = -gimbal_rate;
  by_globals.block<3, 1>(0, Globals::kLatency) = -gimbal_rate.cross(arm);
}

std::size_t Adjustment::tie_count() const {
  std::size_t count = 0;
  for (const TieGroup& group : groups) count += group.ties.size();
  return count;
}

double Adjustment::delay_of(int index) const {
  const auto i = static_cast<std::size_t>(index);
  return frames[i].base_s - time_s(index, state);
}

double Adjustment::time_s(int index, const AdjustmentState& s) const {
  const auto i = static_cast<std::size_t>(index);
  const AdjustedFrame& frame = frames[i];
  if (!frame.delayed || frame.own || s.delay_s.empty()) return frame.base_s;
  const auto [k, f] = delay_place(frame.base_s);
  const auto at = static_cast<std::size_t>(k);
  double delay_s = s.delay_s[at] + s.jitter_s[i];
  if (f > 0.0) delay_s += f * (s.delay_s[at + 1] - s.delay_s[at]);
  return frame.base_s - delay_s;
}

ModelCamera Adjustment::camera(int frame, const AdjustmentState& s) const {
  Evaluated e;
  evaluate(frame, s, false, e);
  return e.camera;
}

ModelPlatform Adjustment::platform(int index) const {
  const auto i = static_cast<std::size_t>(index);
  const AdjustedFrame& frame = frames[i];
  ModelPlatform out;
  out.t_s = time_s(index, state);
  const NavigationSample nav =
      frame.own ? *frame.own : navigation_->at(out.t_s, state.globals[Globals::kLatency]);
  Eigen::Matrix<double, 6, 1> error = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
      state.knots[static_cast<std::size_t>(frame.knot)].data());
  if (frame.weight > 0.0)
    error += frame.weight * (Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
                                 state.knots[static_cast<std::size_t>(frame.knot) + 1].data()) -
                             error);
  error += Eigen::Map<const Eigen::Matrix<double, 6, 1>>(state.extra[i].data());
  out.reference = exp_rotation(error.tail<3>()) * nav.reference;
  out.gimbal = exp_rotation(state.globals.segment<3>(Globals::kEncoder)) * nav.gimbal;
  out.position_m = nav.position_m + error.head<3>();
  out.position_m.z() -= state.globals[Globals::kHeight];
  out.position_m.head<2>() += state.globals.segment<2>(Globals::kOffset);
  return out;
}

Cameras Adjustment::cameras(const AdjustmentState& s) const {
  Cameras out;
  out.camera.reserve(frames.size());
  out.time_s.reserve(frames.size());
  out.focal_scale = s.globals[Globals::kFocal];
  out.drift_m_s = s.globals.segment<2>(Globals::kDrift);
  Evaluated e;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    evaluate(static_cast<int>(i), s, false, e);
    out.camera.push_back(e.camera);
    out.time_s.push_back(e.t_s);
  }
  return out;
}

std::optional<Adjustment::SeenPoint> Adjustment::see_known(const KnownPoint& point,
                                                           const AdjustmentState& s) const {
  const auto seen = see_known_point(camera(point.frame, s).at_row(point.row, readout_s_), point,
                                    s.globals[Globals::kFocal], time_s(point.frame, s));
  if (!seen) return std::nullopt;
  return SeenPoint{focal_px_ * seen->residual, focal_px_ * seen->by_point,
                   focal_px_ * seen->by_camera};
}

double Adjustment::height_error_m(double t_s, const AdjustmentState& s) const {
  const auto [k, f] = knot_place(t_s);
  double down_m = s.knots[static_cast<std::size_t>(k)][2];
  if (f > 0.0) down_m += f * (s.knots[static_cast<std::size_t>(k) + 1][2] - down_m);
  return s.globals[Globals::kHeight] - down_m;
}

std::optional<Eigen::Vector2d> Adjustment::residual_px(const TieGroup& group, const Tie& tie,
                                                       const Cameras& cameras) const {
  const auto h = static_cast<std::size_t>(group.host), f = static_cast<std::size_t>(group.frame);
  const auto seen =
      sent(cameras.camera[h].at_row(tie.host_row, readout_s_),
           cameras.camera[f].at_row(tie.frame_row, readout_s_), tie.host, cameras.focal_scale,
           cameras.drift_m_s * (cameras.time_s[f] - cameras.time_s[h]));
  if (!seen) return std::nullopt;
  return Eigen::Vector2d(focal_px_ * ((1.0 + cameras.focal_scale) * *seen - tie.frame));
}

std::optional<double> Adjustment::disagreement_m(const TieGroup& group, const Tie& tie,
                                                 const Cameras& cameras) const {
  const auto h = static_cast<std::size_t>(group.host), f = static_cast<std::size_t>(group.frame);
  const auto a = sea_under(cameras.camera[h].at_row(tie.host_row, readout_s_),
                           with_focal(tie.host, cameras.focal_scale));
  const auto b = sea_under(cameras.camera[f].at_row(tie.frame_row, readout_s_),
                           with_focal(tie.frame, cameras.focal_scale));
  if (!a || !b) return std::nullopt;
  return (*b - *a - (cameras.time_s[f] - cameras.time_s[h]) * cameras.drift_m_s).norm();
}

NavigationSample Adjustment::recorded(int index) const {
  const AdjustedFrame& frame = frames[static_cast<std::size_t>(index)];
  return frame.own ? *frame.own
                   : navigation_->at(time_s(index, state), state.globals[Globals::kLatency]);
}

void Excitation::add(const Adjustment& adjustment, int frame) {
  const NavigationSample nav = adjustment.recorded(frame);
  const Eigen::Quaterniond platform = nav.reference * nav.gimbal;
  if (!first_) first_ = platform;
  const auto& knot =
      adjustment.state
          .knots[static_cast<std::size_t>(adjustment.frames[static_cast<std::size_t>(frame)].knot)];
  const auto count = [](Sums& s, const Eigen::Vector3d& turn) {
    s.n += 1.0;
    s.sum += turn;
    s.square += turn.squaredNorm();
  };
  count(recorded_, log_rotation(platform * first_->conjugate()));
  count(errors_, Eigen::Vector3d(knot[3], knot[4], knot[5]));
}

Excitation excitation_of(const Adjustment& adjustment) {
  Excitation out;
  for (std::size_t i = 0; i < adjustment.frames.size(); ++i)
    if (adjustment.frames[i].weight == 0.0) out.add(adjustment, static_cast<int>(i));
  return out;
}

void hold_for_want_of_turns(Adjustment& adjustment, double delay_s) {
  constexpr double kHeldDelay_s = 1e-5;
  adjustment.priors.globals.segment<3>(Globals::kMount).setZero();
  adjustment.priors.globals.segment<3>(Globals::kLever).setZero();
  adjustment.priors.delay_s = adjustment.priors.delay_walk_s = kHeldDelay_s;
  adjustment.priors.delay_rate = 0.0;
  adjustment.delay_start_s = delay_s;
  adjustment.reset();
}

}  // namespace watersky::align
