// SPDX-License-Identifier: MIT
#include "watersky/align/detail/navigation.hpp"

#include <algorithm>
#include <limits>

#include "watersky/align/detail/median.hpp"

namespace watersky::align {

namespace {

template <class Sample>
std::size_t before(const std::vector<Sample>& samples, double t_s) {
  const auto after = std::upper_bound(samples.begin(), samples.end(), t_s,
                                      [](double t, const Sample& s) { return t < s.t_s; });
  const auto i = static_cast<std::size_t>(after - samples.begin());
  return i == 0 ? 0 : i - 1;
}

template <class Sample>
double fraction(const std::vector<Sample>& samples, std::size_t i, double t_s) {
  if (i + 1 >= samples.size()) return 0.0;
  return std::clamp((t_s - samples[i].t_s) / (samples[i + 1].t_s - samples[i].t_s), 0.0, 1.0);
}

template <class Sample>
bool bracketed(const std::vector<Sample>& samples, double t_s, double max_gap_s) {
  if (samples.empty() || t_s < samples.front().t_s || t_s > samples.back().t_s) return false;
  const std::size_t i = before(samples, t_s);
  return samples[i].t_s == t_s || i + 1 == samples.size() ||
         samples[i + 1].t_s - samples[i].t_s <= max_gap_s;
}

/// local_from_reference for a body with this attitude in Local.
Eigen::Quaterniond reference_of(const Flight& flight, const LocalFrame& frame,
                                const Eigen::Quaterniond& local_from_body, const Geodetic& place) {
  return flight.gimbal_reference == GimbalReference::NorthEastDown ? frame.local_from_ned(place)
                                                                   : local_from_body;
}

}  // namespace

Result<Navigation> Navigation::make(const Flight& flight, const LocalFrame& frame,
                                    double max_gap_s) {
  Navigation navigation;
  navigation.max_gap_s_ = max_gap_s;
  const auto& poses = flight.trajectory.poses();
  if (poses.empty()) {
    for (const ImageFrame& f : flight.frames)
      if (f.own_pose) {
        navigation.epoch_ = f.own_pose->time;
        break;
      }
    return navigation;
  }
  navigation.epoch_ = poses.front().time;
  std::array<std::vector<double>, 6> sigmas;
  navigation.poses_.reserve(poses.size());
  for (const StampedPose& pose : poses) {
    WATERSKY_TRY(const Pose local, navigation.local_pose(flight, frame, pose));
    navigation.poses_.push_back(local);
    if (pose.sigma)
      for (int k = 0; k < 3; ++k) {
        sigmas[static_cast<std::size_t>(k)].push_back(pose.sigma->position_north_east_down_m[k]);
        sigmas[static_cast<std::size_t>(k) + 3].push_back(pose.sigma->roll_pitch_yaw_rad[k]);
      }
  }
  for (int k = 0; k < 3; ++k) {
    navigation.typical_sigma_.position_north_east_down_m[k] =
        median(sigmas[static_cast<std::size_t>(k)]);
    navigation.typical_sigma_.roll_pitch_yaw_rad[k] =
        median(sigmas[static_cast<std::size_t>(k) + 3]);
  }
  if (flight.gimbal_reference)
    for (const StampedRotation& r : flight.gimbal.rotations())
      navigation.gimbal_.push_back({navigation.since_epoch_s(r.time), r.rotation});
  navigation.see_steps();
  return navigation;
}

Result<Navigation::Pose> Navigation::local_pose(const Flight& flight, const LocalFrame& frame,
                                                const StampedPose& pose) const {
  WATERSKY_TRY(const LocalPose local, frame.local(pose.world_from_body));
  const Geodetic place = flight.datum.geodetic(pose.world_from_body.origin());
  return Pose{since_epoch_s(pose.time), local.position_m,
              reference_of(flight, frame, local.rotation, place)};
}

void Navigation::see_steps() {
  std::vector<double> steps;
  for (std::size_t i = 1; i < poses_.size(); ++i)
    steps.push_back(poses_[i].t_s - poses_[i - 1].t_s);
  // Over less than a step the interpolated motion has corners; over much more it is smoothed.
  half_step_s_ = std::clamp(median(std::move(steps)), 0.005, 0.25);
}

Status Navigation::add(const Flight& flight, const LocalFrame& frame, const StampedPose& pose) {
  WATERSKY_TRY(const Pose local, local_pose(flight, frame, pose));
  if (!poses_.empty() && local.t_s <= poses_.back().t_s)
    return Error{ErrorCode::OutOfRange, "a pose is not later than the one before it"};
  poses_.push_back(local);
  if (pose.sigma) typical_sigma_ = *pose.sigma;
  // Steps do not change in flight: once there are enough they are known.
  constexpr std::size_t kEnough = 50;
  if (poses_.size() <= kEnough) see_steps();
  return {};
}

Status Navigation::add(const StampedRotation& gimbal) {
  const double t_s = since_epoch_s(gimbal.time);
  if (!gimbal_.empty() && t_s <= gimbal_.back().t_s)
    return Error{ErrorCode::OutOfRange, "a gimbal attitude is not later than the one before it"};
  gimbal_.push_back({t_s, gimbal.rotation});
  return {};
}

void Navigation::forget_before(double t_s) {
  const auto cut = [&](auto& samples) {
    if (samples.empty()) return;
    samples.erase(samples.begin(),
                  samples.begin() + static_cast<std::ptrdiff_t>(before(samples, t_s)));
  };
  cut(poses_);
  cut(gimbal_);
}

double Navigation::until_s() const {
  if (poses_.empty()) return -std::numeric_limits<double>::infinity();
  return gimbal_.empty() ? poses_.back().t_s : std::min(poses_.back().t_s, gimbal_.back().t_s);
}

bool Navigation::covers(double t_s) const {
  return bracketed(poses_, t_s, max_gap_s_) &&
         (gimbal_.empty() || bracketed(gimbal_, t_s, max_gap_s_));
}

Navigation::Pose Navigation::pose_at(double t_s) const {
  if (poses_.empty()) return {t_s, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()};
  const std::size_t i = before(poses_, t_s);
  const double f = fraction(poses_, i, t_s);
  if (f == 0.0) return {t_s, poses_[i].position_m, poses_[i].reference};
  return {t_s, (1 - f) * poses_[i].position_m + f * poses_[i + 1].position_m,
          poses_[i].reference.slerp(f, poses_[i + 1].reference)};
}

Eigen::Quaterniond Navigation::gimbal_at(double t_s) const {
  if (gimbal_.empty()) return Eigen::Quaterniond::Identity();
  const std::size_t i = before(gimbal_, t_s);
  const double f = fraction(gimbal_, i, t_s);
  return f == 0.0 ? gimbal_[i].rotation : gimbal_[i].rotation.slerp(f, gimbal_[i + 1].rotation);
}

NavigationSample Navigation::at(double t_s, double gimbal_latency_s) const {
  const Pose now = pose_at(t_s), earlier = pose_at(t_s - half_step_s_),
             later = pose_at(t_s + half_step_s_);
  NavigationSample s;
  s.position_m = now.position_m;
  s.reference = now.reference;
  const double span_s = 2 * half_step_s_;
  s.velocity_m_s = (later.position_m - earlier.position_m) / span_s;
  s.reference_rate_rad_s = log_rotation(later.reference * earlier.reference.conjugate()) / span_s;
  if (!gimbal_.empty()) {
    const double g_s = t_s - gimbal_latency_s;
    s.gimbal = gimbal_at(g_s);
    s.gimbal_rate_rad_s =
        log_rotation(gimbal_at(g_s + half_step_s_) * gimbal_at(g_s - half_step_s_).conjugate()) /
        span_s;
  }
  return s;
}

Result<NavigationSample> Navigation::still(const Flight& flight, const LocalFrame& frame,
                                           const StampedPose& pose,
                                           const std::optional<Eigen::Quaterniond>& gimbal) {
  WATERSKY_TRY(const LocalPose local, frame.local(pose.world_from_body));
  NavigationSample s;
  s.position_m = local.position_m;
  s.reference = reference_of(flight, frame, local.rotation,
                             flight.datum.geodetic(pose.world_from_body.origin()));
  if (gimbal) s.gimbal = *gimbal;
  return s;
}

}  // namespace watersky::align
