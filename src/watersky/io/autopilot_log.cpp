// SPDX-License-Identifier: MIT
#include "watersky/io/autopilot_log.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "watersky/geo/rotation.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/detail/log_samples.hpp"
#include "watersky/wire/tlog.hpp"

namespace watersky {

namespace {

using detail::median;
using detail::sort_by_time;
using mavlink::Message;

enum Id : std::uint32_t {
  kSystemTime = 2,
  kAttitude = 30,
  kAttitudeQuaternion = 31,
  kGlobalPositionInt = 33,
  kMountStatus = 158,
  kDistanceSensor = 132,
  kCameraFeedback = 180,
  kMountOrientation = 265,
  kGimbalDeviceAttitudeStatus = 285,
};

/// A time since boot, and since which one.
struct BootTime {
  std::size_t boot = 0;
  double s = 0.0;
};

/// Takes one sender's boot time to the log's clock.
class BootClock {
 public:
  BootTime add(double boot_s, Time stamp) {
    if (!start_) start_ = stamp;
    const double delay = to_seconds(stamp - *start_) - boot_s;
    // Messages overtake each other by little; a reboot goes back by much.
    constexpr double kReboot_s = 10.0;
    if (boots_.empty() || boot_s < boots_.back().latest_s - kReboot_s) boots_.emplace_back();
    Boot& boot = boots_.back();
    boot.latest_s = std::max(boot.latest_s, boot_s);
    boot.points.emplace_back(boot_s, delay);
    return {boots_.size() - 1, boot_s};
  }

  void fit() {
    for (Boot& boot : boots_) boot.line = detail::fit_clock(boot.points);
  }

  [[nodiscard]] Time utc(const BootTime& t) const {
    return *start_ + seconds(t.s + boots_[t.boot].line.at(t.s));
  }
  [[nodiscard]] std::size_t boots() const { return boots_.size(); }
  /// The inverse, within the boot.
  [[nodiscard]] double boot_s(std::size_t boot, Time utc) const {
    const LowerLine& line = boots_[boot].line;
    const double log_s = to_seconds(utc - *start_);
    return log_s - line.at(log_s - line.offset);
  }

 private:
  struct Boot {
    std::vector<std::pair<double, double>> points;
    double latest_s = 0.0;
    LowerLine line;
  };
  std::optional<Time> start_;
  std::vector<Boot> boots_;
};

struct RawFeedback {
  Time received_at;
  std::size_t boot = 0;
  std::uint64_t time_us = 0;
  int image_index = 0;
};

struct RawGimbal {
  BootTime time;
  Eigen::Quaterniond rotation;
  bool yaw_from_vehicle = false;
};

/// All that one system and component sent.
struct Source {
  BootClock clock;
  std::vector<std::pair<BootTime, Eigen::Quaterniond>> eulers, quaternions;
  std::vector<std::pair<BootTime, PositionSample>> positions;
  std::vector<double> home_heights_m;  ///< one a position
  std::vector<RawGimbal> gimbal_device, mount_orientation;
  std::vector<RawFeedback> feedback;
  std::vector<std::pair<BootTime, RangeSample>> ranges;
  std::vector<double> utc_minus_boot_s;  ///< by SYSTEM_TIME, once GPS had told the time
  std::size_t mount_status = 0;

  [[nodiscard]] std::size_t usable() const {
    return std::min(std::max(eulers.size(), quaternions.size()), positions.size());
  }
};

using Sources = std::map<std::pair<int, int>, Source>;

void take_gimbal_device(Source& source, const BootTime& time, const Message& m) {
  const Eigen::Quaterniond q(m.number("q", 0), m.number("q", 1), m.number("q", 2),
                             m.number("q", 3));
  if (!q.coeffs().allFinite() || q.norm() < 0.5) return;
  const auto flags = m.integer("flags");
  constexpr std::int64_t kYawInVehicle = 0x20, kYawInEarth = 0x40, kYawLock = 0x10;
  const bool vehicle =
      (flags & kYawInVehicle) != 0 || ((flags & kYawInEarth) == 0 && (flags & kYawLock) == 0);
  source.gimbal_device.push_back({time, q.normalized(), vehicle});
}

void take_mount_orientation(Source& source, const BootTime& time, const Message& m) {
  const double roll = m.number("roll"), pitch = m.number("pitch");
  const double absolute = m.number("yaw_absolute"), relative = m.number("yaw");
  // Senders without the extension leave yaw_absolute at zero.
  const bool vehicle = absolute == 0.0 || !std::isfinite(absolute);
  const double yaw = vehicle ? relative : absolute;
  if (!std::isfinite(roll) || !std::isfinite(pitch) || !std::isfinite(yaw)) return;
  source.mount_orientation.push_back(
      {time, rotation_from({Angle::degrees(yaw), Angle::degrees(pitch), Angle::degrees(roll)}),
       vehicle});
}

/// Of a range finder that looks down, what lies within its reach.
void take_range(Source& source, const BootTime& time, const Message& m) {
  constexpr std::int64_t kLooksDown = 25;  // MAV_SENSOR_ROTATION_PITCH_270
  constexpr std::int64_t kInvalid = 1;     // of signal_quality; 0 is not known
  constexpr std::int64_t kUnknown = 255;   // of covariance
  if (m.integer("orientation") != kLooksDown || m.integer("signal_quality") == kInvalid) return;
  const auto range_cm = m.integer("current_distance");
  if (range_cm <= m.integer("min_distance") || range_cm >= m.integer("max_distance")) return;
  const auto variance_cm2 = m.integer("covariance");
  const double sigma_cm =
      variance_cm2 == kUnknown ? 0.0 : std::sqrt(static_cast<double>(variance_cm2));
  source.ranges.emplace_back(
      time, RangeSample{{}, 0.01 * static_cast<double>(range_cm), 0.01 * sigma_cm});
}

void take(Source& source, const Message& m, Time stamp) {
  const auto id = m.info().id;
  if (id == kCameraFeedback) {
    const std::size_t boots = source.clock.boots();
    source.feedback.push_back({stamp, boots > 0 ? boots - 1 : 0,
                               static_cast<std::uint64_t>(m.integer("time_usec")),
                               static_cast<int>(m.integer("img_idx"))});
    return;
  }
  if (id == kMountStatus) ++source.mount_status;
  if (!m.info().field("time_boot_ms")) return;
  const BootTime time = source.clock.add(m.number("time_boot_ms") * 1e-3, stamp);
  switch (id) {
    case kSystemTime:
      if (m.integer("time_unix_usec") > 0)
        source.utc_minus_boot_s.push_back(m.number("time_unix_usec") * 1e-6 - time.s);
      break;
    case kAttitude: {
      const double r = m.number("roll"), p = m.number("pitch"), y = m.number("yaw");
      if (std::isfinite(r) && std::isfinite(p) && std::isfinite(y))
        source.eulers.emplace_back(
            time, rotation_from({Angle::radians(y), Angle::radians(p), Angle::radians(r)}));
      break;
    }
    case kAttitudeQuaternion: {
      const Eigen::Quaterniond q(m.number("q1"), m.number("q2"), m.number("q3"), m.number("q4"));
      if (q.coeffs().allFinite() && q.norm() > 0.5)
        source.quaternions.emplace_back(time, q.normalized());
      break;
    }
    case kGlobalPositionInt: {
      const auto lat = m.integer("lat"), lon = m.integer("lon");
      // Before the first fix both are zero.
      if ((lat == 0 && lon == 0) || std::abs(lat) > 900'000'000 || std::abs(lon) > 1'800'000'000)
        break;
      source.positions.emplace_back(time,
                                    PositionSample{{},
                                                   Angle::degrees(static_cast<double>(lat) * 1e-7),
                                                   Angle::degrees(static_cast<double>(lon) * 1e-7),
                                                   m.number("alt") * 1e-3});
      source.home_heights_m.push_back((m.number("alt") - m.number("relative_alt")) * 1e-3);
      break;
    }
    case kGimbalDeviceAttitudeStatus: take_gimbal_device(source, time, m); break;
    case kDistanceSensor: take_range(source, time, m); break;
    case kMountOrientation: take_mount_orientation(source, time, m); break;
    default: break;
  }
}

/// time_usec is UTC when the autopilot made the record on command, the low 32 bits of boot time
/// in µs when a pin told it; see the message's notes in the wire module's facts.
Time feedback_time(const RawFeedback& f, const Source& source) {
  constexpr double kUtc_us = 1e15, kWrap_s = 4294.967296;
  if (source.clock.boots() == 0) return f.received_at;
  const double time_s = static_cast<double>(f.time_us) * 1e-6;
  if (static_cast<double>(f.time_us) >= kUtc_us) {
    if (source.utc_minus_boot_s.empty()) return f.received_at;
    const double boot_s = time_s - median(source.utc_minus_boot_s);
    return source.clock.utc({f.boot, boot_s});
  }
  const double near_s = source.clock.boot_s(f.boot, f.received_at);
  return source.clock.utc({f.boot, time_s + kWrap_s * std::round((near_s - time_s) / kWrap_s)});
}

std::string sender(const std::pair<int, int>& id) {
  return "system " + std::to_string(id.first) + ", component " + std::to_string(id.second);
}

}  // namespace

LowerLine fit_lower_line(std::span<const std::pair<double, double>> xy, double min_span,
                         double max_slope) {
  const double x_first = xy.front().first, x_last = xy.back().first;
  LowerLine flat{0.5 * (x_first + x_last), xy.front().second, 0.0};
  double mean_x = 0;
  for (const auto& [x, y] : xy) {
    flat.offset = std::min(flat.offset, y);
    mean_x += (x - x_first) / static_cast<double>(xy.size());
  }
  mean_x += x_first;
  if (x_last - x_first < min_span) return flat;

  // Of all lines below the points, the one whose mean distance is least is the edge of their
  // lower hull over the mean x.
  std::vector<std::pair<double, double>> hull;
  for (const auto& p : xy) {
    while (hull.size() >= 2) {
      const auto& a = hull[hull.size() - 2];
      const auto& b = hull.back();
      if ((b.first - a.first) * (p.second - a.second) > (b.second - a.second) * (p.first - a.first))
        break;
      hull.pop_back();
    }
    hull.push_back(p);
  }
  for (std::size_t i = 0; i + 1 < hull.size(); ++i) {
    const auto& [ax, ay] = hull[i];
    const auto& [bx, by] = hull[i + 1];
    if (bx < mean_x || bx == ax) continue;
    const double slope = (by - ay) / (bx - ax);
    if (std::abs(slope) > max_slope) return flat;
    return {ax, ay, slope};
  }
  return flat;
}

Result<AutopilotLog> parse_tlog(std::span<const std::uint8_t> bytes, const std::string& name) {
  Sources sources;
  mavlink::TlogReader reader(bytes);
  std::size_t records = 0;
  while (const auto record = reader.next()) {
    ++records;
    if (!record->frame.info) continue;
    const Message m(record->frame);
    take(sources[{m.system(), m.component()}], m, record->received_at);
  }
  if (records == 0)
    return Error{ErrorCode::InvalidInput, name + ": holds no MAVLink message; is it a .tlog?"};

  AutopilotLog log;
  Source* vehicle = nullptr;
  std::size_t vehicles = 0;
  for (auto& [id, source] : sources) {
    if (source.usable() == 0) continue;
    ++vehicles;
    if (vehicle && source.usable() <= vehicle->usable()) continue;
    vehicle = &source;
    std::tie(log.system, log.component) = id;
  }
  if (!vehicle)
    return Error{ErrorCode::NotFound, name +
                                          ": no system sent both attitude (ATTITUDE or "
                                          "ATTITUDE_QUATERNION) and GLOBAL_POSITION_INT"};
  if (vehicles > 1)
    log.notes.push_back(name + ": of " + std::to_string(vehicles) +
                        " vehicles the one with most poses was taken (" +
                        sender({log.system, log.component}) + ")");
  if (reader.skipped_bytes() > 0)
    log.notes.push_back(name + ": " + std::to_string(reader.skipped_bytes()) + " bytes in " +
                        std::to_string(reader.gaps()) + " places are no MAVLink and were skipped");
  if (reader.truncated_bytes() > 0) log.notes.push_back(name + ": ends in the middle of a message");

  for (auto& [id, source] : sources) source.clock.fit();
  const BootClock& clock = vehicle->clock;
  if (clock.boots() > 1)
    log.notes.push_back(name + ": the autopilot was restarted " +
                        std::to_string(clock.boots() - 1) + " times");

  for (const auto& [time, q] : vehicle->quaternions.size() > vehicle->eulers.size()
                                   ? vehicle->quaternions
                                   : vehicle->eulers)
    log.attitudes.push_back({clock.utc(time), q});
  for (auto& [time, sample] : vehicle->positions) {
    sample.time = clock.utc(time);
    log.positions.push_back(sample);
  }
  log.home_height_geoid_m = median(vehicle->home_heights_m);
  sort_by_time(log.attitudes);
  sort_by_time(log.positions);

  // A camera or gimbal may be a component of its own, with its own clock.
  for (auto& [id, source] : sources) {
    if (id.first != log.system) continue;
    if (log.feedback.empty())
      for (const RawFeedback& f : source.feedback)
        if (log.feedback.empty() || log.feedback.back().image_index != f.image_index)
          log.feedback.push_back({feedback_time(f, source), f.image_index});
    if (source.ranges.size() > log.ranges.size()) {
      log.ranges.clear();
      for (auto& [time, sample] : source.ranges) {
        sample.time = source.clock.utc(time);
        log.ranges.push_back(sample);
      }
      sort_by_time(log.ranges);
    }
    const auto& raw =
        source.gimbal_device.empty() ? source.mount_orientation : source.gimbal_device;
    if (raw.size() <= log.gimbal.size()) continue;
    RotationTrack body;
    std::vector<StampedRotation> body_samples;
    for (const AttitudeSample& a : log.attitudes) body_samples.push_back({a.time, a.ned_from_body});
    WATERSKY_TRY(body, RotationTrack::make(std::move(body_samples)));
    log.gimbal.clear();
    for (const RawGimbal& g : raw) {
      const Time time = source.clock.utc(g.time);
      Eigen::Quaterniond q = g.rotation;
      if (g.yaw_from_vehicle) {
        const auto attitude = body.at(time, std::chrono::seconds(1));
        if (!attitude) continue;
        q = heading(yaw_pitch_roll(*attitude).yaw) * q;
      }
      log.gimbal.push_back({time, q});
    }
    sort_by_time(log.gimbal);
  }
  if (vehicle->mount_status > 0 && log.gimbal.empty())
    log.notes.push_back(name +
                        ": MOUNT_STATUS does not say against what its angles are and was not used");
  return log;
}

Result<Trajectory> make_trajectory(const AutopilotLog& log, const Datum& datum) {
  constexpr std::chrono::seconds kMaxGap{2};
  struct Place {
    Time time;
    Eigen::Vector3d p_world;
    Eigen::Quaterniond world_from_ned;
  };
  std::vector<Place> places;
  for (const PositionSample& p : log.positions) {
    WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(p.latitude, p.longitude));
    const Geodetic g{p.latitude, p.longitude, p.height_geoid_m + geoid_m};
    places.push_back({p.time, datum.world(g).v, datum.world_from_ned_rotation(g)});
  }
  std::vector<StampedPose> poses;
  std::size_t i = 0;
  for (const AttitudeSample& a : log.attitudes) {
    while (i + 1 < places.size() && places[i + 1].time <= a.time) ++i;
    if (places.empty() || places[i].time > a.time) continue;
    Eigen::Vector3d p = places[i].p_world;
    if (places[i].time < a.time) {
      if (i + 1 == places.size() || places[i + 1].time - places[i].time > kMaxGap) continue;
      const double f =
          to_seconds(a.time - places[i].time) / to_seconds(places[i + 1].time - places[i].time);
      p += f * (places[i + 1].p_world - p);
    }
    poses.push_back(
        {a.time, {places[i].world_from_ned * a.ned_from_body, Point<World>{p}}, std::nullopt});
  }
  return Trajectory::make(std::move(poses));
}

}  // namespace watersky
