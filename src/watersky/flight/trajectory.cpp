// SPDX-License-Identifier: MIT
#include "watersky/flight/trajectory.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

namespace watersky {

namespace {

/// `later - earlier`, the longest there is when that does not fit: foreign times may lie centuries
/// apart.
Duration between(Time earlier, Time later) {
  Duration::rep count = 0;
  if (__builtin_sub_overflow(later.time_since_epoch().count(), earlier.time_since_epoch().count(),
                             &count))
    return Duration::max();
  return Duration(count);
}

bool is_rotation(const Eigen::Quaterniond& q) { return q.coeffs().allFinite() && q.norm() > 1e-6; }

std::string seconds_text(Duration d) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", to_seconds(d));
  return text;
}

Status require_increasing(const std::string& what, std::size_t index, Time before, Time now) {
  if (now > before) return {};
  return Error{ErrorCode::InvalidInput,
               what + " " + std::to_string(index + 1) +
                   (now == before ? " has the same time as the one before it; remove one of them"
                                  : " is " + seconds_text(between(now, before)) +
                                        " earlier than the one before it; sort them by time")};
}

/// Where a time lies among sorted samples: between `before` and `before + 1`, `fraction` of the
/// way. Exactly on a sample fraction is 0.
struct Bracket {
  std::size_t before = 0;
  double fraction = 0.0;
};

template <class Sample>
Result<Bracket> bracket(const std::vector<Sample>& samples, Time time, Duration max_gap,
                        const char* what) {
  const auto fail = [](std::string message) {
    return Error{ErrorCode::OutOfRange, std::move(message)};
  };
  const std::string noun(what);
  if (samples.empty()) return fail("there is no recorded " + noun);
  if (time < samples.front().time)
    return fail(seconds_text(between(time, samples.front().time)) + " before the first recorded " +
                noun);
  if (time > samples.back().time)
    return fail(seconds_text(between(samples.back().time, time)) + " after the last recorded " +
                noun);
  const auto after = std::upper_bound(samples.begin(), samples.end(), time,
                                      [](Time t, const Sample& s) { return t < s.time; });
  const std::size_t i = static_cast<std::size_t>(after - samples.begin()) - 1;
  if (samples[i].time == time || i + 1 == samples.size()) return Bracket{i, 0.0};
  const Duration gap = between(samples[i].time, samples[i + 1].time);
  if (gap > max_gap)
    return fail("in a gap of " + seconds_text(gap) + " without a recorded " + noun + " (at most " +
                seconds_text(max_gap) + " is bridged)");
  return Bracket{i, to_seconds(between(samples[i].time, time)) / to_seconds(gap)};
}

}  // namespace

Result<Trajectory> Trajectory::make(std::vector<StampedPose> poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto& pose = poses[i].world_from_body;
    if (!pose.origin().v.allFinite() || !pose.rotation().coeffs().allFinite())
      return Error{ErrorCode::InvalidInput,
                   "pose " + std::to_string(i + 1) + " is not a number; remove it"};
    if (!is_rotation(pose.rotation()))
      return Error{ErrorCode::InvalidInput,
                   "pose " + std::to_string(i + 1) + " has a quaternion of zeros; remove it"};
    if (i > 0) WATERSKY_CHECK(require_increasing("pose", i, poses[i - 1].time, poses[i].time));
  }
  Trajectory trajectory;
  trajectory.poses_ = std::move(poses);
  return trajectory;
}

Result<StampedPose> Trajectory::at(Time time, Duration max_gap) const {
  WATERSKY_TRY(const Bracket b, bracket(poses_, time, max_gap, "pose"));
  const StampedPose& a = poses_[b.before];
  if (b.fraction == 0.0) return a;
  const StampedPose& c = poses_[b.before + 1];
  StampedPose out{time,
                  {a.world_from_body.rotation().slerp(b.fraction, c.world_from_body.rotation()),
                   Point<World>{(1 - b.fraction) * a.world_from_body.origin().v +
                                b.fraction * c.world_from_body.origin().v}},
                  std::nullopt};
  if (a.covariance && c.covariance)
    out.covariance = a.covariance->trace() > c.covariance->trace() ? a.covariance : c.covariance;
  if (a.sigma && c.sigma)
    out.sigma =
        PoseSigma{a.sigma->position_north_east_down_m.cwiseMax(c.sigma->position_north_east_down_m),
                  a.sigma->roll_pitch_yaw_rad.cwiseMax(c.sigma->roll_pitch_yaw_rad)};
  return out;
}

Result<RotationTrack> RotationTrack::make(std::vector<StampedRotation> rotations) {
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    if (!rotations[i].rotation.coeffs().allFinite())
      return Error{ErrorCode::InvalidInput,
                   "attitude " + std::to_string(i + 1) + " is not a number; remove it"};
    if (!is_rotation(rotations[i].rotation))
      return Error{ErrorCode::InvalidInput,
                   "attitude " + std::to_string(i + 1) + " is a quaternion of zeros; remove it"};
    rotations[i].rotation.normalize();
    if (i > 0)
      WATERSKY_CHECK(require_increasing("attitude", i, rotations[i - 1].time, rotations[i].time));
  }
  RotationTrack track;
  track.rotations_ = std::move(rotations);
  return track;
}

Result<Eigen::Quaterniond> RotationTrack::at(Time time, Duration max_gap) const {
  WATERSKY_TRY(const Bracket b, bracket(rotations_, time, max_gap, "gimbal attitude"));
  const Eigen::Quaterniond& a = rotations_[b.before].rotation;
  return b.fraction == 0.0 ? a : a.slerp(b.fraction, rotations_[b.before + 1].rotation);
}

}  // namespace watersky
