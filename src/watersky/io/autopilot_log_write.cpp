// SPDX-License-Identifier: MIT
#include "watersky/io/autopilot_log_write.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>

#include "watersky/geo/rotation.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/wire/dataflash_writer.hpp"
#include "watersky/wire/imc.hpp"
#include "watersky/wire/mavlink.hpp"
#include "watersky/wire/tlog.hpp"

namespace watersky {

namespace {

using Bytes = std::vector<std::uint8_t>;
using mavlink::Message;

constexpr int kLooksDown = 25;  // MAV_SENSOR_ROTATION_PITCH_270
/// The autopilot was started so long before its first sample.
constexpr std::chrono::seconds kBootBefore{10};
constexpr std::chrono::seconds kBetweenHeartbeats{1};

/// When everything in a log begins and ends; whole milliseconds.
struct Span {
  Time first, last;
};

Span span_of(const AutopilotLog& log) {
  Span out{log.attitudes.front().time, log.attitudes.back().time};
  const auto add = [&](const auto& samples) {
    for (const auto& s : samples) {
      out.first = std::min(out.first, s.time);
      out.last = std::max(out.last, s.time);
    }
  };
  add(log.positions);
  add(log.gimbal);
  add(log.feedback);
  add(log.ranges);
  return {std::chrono::floor<std::chrono::milliseconds>(out.first),
          std::chrono::ceil<std::chrono::milliseconds>(out.last)};
}

/// Where it took off, as far as is known.
double home_height_m(const AutopilotLog& log) {
  return log.home_height_geoid_m.value_or(log.positions.front().height_geoid_m);
}

/// The last of `samples` (by time) that is not after `time`, or the first.
template <class Sample>
const Sample& last_before(const std::vector<Sample>& samples, Time time) {
  auto after = std::upper_bound(samples.begin(), samples.end(), time,
                                [](Time t, const Sample& s) { return t < s.time; });
  return after == samples.begin() ? *after : *std::prev(after);
}

/// Between the positions around a time; beyond them the first or last.
PositionSample position_at(const std::vector<PositionSample>& positions, Time time) {
  const PositionSample& before = last_before(positions, time);
  const auto i = static_cast<std::size_t>(&before - positions.data());
  PositionSample out = before;
  out.time = time;
  if (i + 1 == positions.size() || time <= before.time) return out;
  const PositionSample& after = positions[i + 1];
  const double f = to_seconds(time - before.time) / to_seconds(after.time - before.time);
  // Across 180° the short way.
  const double turn_deg =
      std::remainder(after.longitude.degrees() - before.longitude.degrees(), 360.0);
  out.latitude = Angle::degrees(before.latitude.degrees() +
                                f * (after.latitude.degrees() - before.latitude.degrees()));
  out.longitude = Angle::degrees(std::remainder(before.longitude.degrees() + f * turn_deg, 360.0));
  out.height_geoid_m += f * (after.height_geoid_m - before.height_geoid_m);
  return out;
}

/// Records in the order of their times, whatever the order they are made in.
class TlogMaker {
 public:
  explicit TlogMaker(Time boot) : boot_(boot) {}

  [[nodiscard]] Message message(const char* name, Time time) const {
    Message m(*mavlink::find_message(name));
    if (m.info().field("time_boot_ms")) m.set_integer("time_boot_ms", boot_ms(time));
    return m;
  }
  [[nodiscard]] std::int64_t boot_ms(Time time) const {
    return std::chrono::round<std::chrono::milliseconds>(time - boot_).count();
  }
  [[nodiscard]] std::int64_t boot_us(Time time) const {
    return std::chrono::round<std::chrono::microseconds>(time - boot_).count();
  }
  /// Arrives when it was measured, to the millisecond that the message itself can say.
  void send(Time time, const Message& m) {
    records_.emplace(boot_ + std::chrono::milliseconds(boot_ms(time)), m);
  }
  [[nodiscard]] Result<Bytes> bytes() const {
    Bytes out;
    mavlink::Sender sender;
    for (const auto& [time, m] : records_) {
      WATERSKY_TRY(const Bytes frame, mavlink::encode(m, sender));
      ++sender.sequence;
      mavlink::append_tlog_record(out, time, frame);
    }
    return out;
  }

 private:
  Time boot_;
  std::multimap<Time, Message> records_;
};

Message range_message(const TlogMaker& maker, const RangeSample& r) {
  Message m = maker.message("DISTANCE_SENSOR", r.time);
  constexpr double kUnknownCovariance = 255;
  const double variance_cm2 = 1e4 * r.sigma_m * r.sigma_m;
  return m.set("min_distance", 1)
      .set("max_distance", std::numeric_limits<std::uint16_t>::max())
      .set("current_distance", 100 * r.range_m)
      .set("orientation", kLooksDown)
      .set("covariance", variance_cm2 > 0 ? std::clamp(variance_cm2, 1.0, kUnknownCovariance - 1)
                                          : kUnknownCovariance);
}

Result<Bytes> encode_tlog(const AutopilotLog& log) {
  const Span span = span_of(log);
  TlogMaker maker(span.first - kBootBefore);
  for (Time t = span.first; t <= span.last; t += kBetweenHeartbeats) {
    Message heartbeat = maker.message("HEARTBEAT", t);
    maker.send(t, heartbeat.set("type", 1).set("autopilot", 3).set("mavlink_version", 3));
    Message clock = maker.message("SYSTEM_TIME", t);
    maker.send(t, clock.set_integer(
                      "time_unix_usec",
                      std::chrono::floor<std::chrono::microseconds>(t.time_since_epoch()).count()));
  }
  for (const AttitudeSample& a : log.attitudes) {
    const YawPitchRoll angles = yaw_pitch_roll(a.ned_from_body);
    Message m = maker.message("ATTITUDE", a.time);
    maker.send(a.time, m.set("roll", angles.roll.radians())
                           .set("pitch", angles.pitch.radians())
                           .set("yaw", angles.yaw.radians()));
  }
  for (const PositionSample& p : log.positions) {
    Message m = maker.message("GLOBAL_POSITION_INT", p.time);
    constexpr double kUnknownHeading = 65535;
    maker.send(p.time, m.set("lat", 1e7 * p.latitude.degrees())
                           .set("lon", 1e7 * p.longitude.degrees())
                           .set("alt", 1e3 * p.height_geoid_m)
                           .set("relative_alt", 1e3 * (p.height_geoid_m - home_height_m(log)))
                           .set("hdg", kUnknownHeading));
  }
  for (const StampedRotation& g : log.gimbal) {
    Message m = maker.message("GIMBAL_DEVICE_ATTITUDE_STATUS", g.time);
    constexpr double kYawInEarth = 0x40;
    maker.send(g.time, m.set("q", g.rotation.w(), 0)
                           .set("q", g.rotation.x(), 1)
                           .set("q", g.rotation.y(), 2)
                           .set("q", g.rotation.z(), 3)
                           .set("flags", kYawInEarth));
  }
  for (const CameraFeedback& f : log.feedback) {
    // As with a feedback pin: the low 32 bits of microseconds since boot.
    const PositionSample p = position_at(log.positions, f.time);
    const YawPitchRoll angles = yaw_pitch_roll(last_before(log.attitudes, f.time).ned_from_body);
    Message m = maker.message("CAMERA_FEEDBACK", f.time);
    maker.send(f.time, m.set_integer("time_usec", maker.boot_us(f.time) & 0xFFFFFFFF)
                           .set("lat", 1e7 * p.latitude.degrees())
                           .set("lng", 1e7 * p.longitude.degrees())
                           .set("alt_msl", p.height_geoid_m)
                           .set("alt_rel", p.height_geoid_m - home_height_m(log))
                           .set("roll", angles.roll.degrees())
                           .set("pitch", angles.pitch.degrees())
                           .set("yaw", angles.yaw.degrees())
                           .set_integer("img_idx", f.image_index & 0xFFFF));
  }
  for (const RangeSample& r : log.ranges) maker.send(r.time, range_message(maker, r));
  return maker.bytes();
}

Result<Bytes> encode_dataflash(const AutopilotLog& log) {
  const Span span = span_of(log);
  const Time boot = span.first - kBootBefore;
  const auto boot_us = [&](Time t) {
    return static_cast<double>(std::chrono::round<std::chrono::microseconds>(t - boot).count());
  };
  dataflash::Writer out;
  const auto att =
      out.add_format("ATT", "QfffffBB", "TimeUS,Roll,Pitch,Yaw,ErrRP,ErrYaw,AEKF,Actv");
  const auto pos = out.add_format("POS", "QLLfff", "TimeUS,Lat,Lng,Alt,RelHomeAlt,RelOriginAlt");
  const auto gps = out.add_format("GPS", "QBBIHBLLf", "TimeUS,I,Status,GMS,GWk,NSats,Lat,Lng,Alt");
  const char* shots = "TimeUS,I,Img,GPSTime,GPSWeek,Lat,Lng,Alt,RelAlt,GPSAlt,R,P,Y";
  const auto trig = out.add_format("TRIG", "QBHIHLLeeeccC", shots);
  const auto cam = out.add_format("CAM", "QBHIHLLeeeccC", shots);
  const auto mnt =
      out.add_format("MNT", "QBfffffff", "TimeUS,I,DesRoll,Roll,DesPitch,Pitch,YawB,DesYawE,YawE");
  const auto rfnd = out.add_format("RFND", "QBfBBb", "TimeUS,Instance,Dist,Stat,Orient,Quality");

  std::multimap<Time, std::function<void()>> records;
  for (const AttitudeSample& a : log.attitudes)
    records.emplace(a.time, [&, angles = yaw_pitch_roll(a.ned_from_body)] {
      out.append(att, {boot_us(a.time), angles.roll.degrees(), angles.pitch.degrees(),
                       std::remainder(angles.yaw.degrees(), 360.0), 0, 0, 3, 0});
    });
  for (const PositionSample& p : log.positions)
    records.emplace(p.time, [&] {
      out.append(pos, {boot_us(p.time), p.latitude.degrees(), p.longitude.degrees(),
                       p.height_geoid_m, p.height_geoid_m - home_height_m(log), 0});
    });
  // Whole milliseconds, which is what GPS weeks count in.
  for (Time t = span.first; t <= span.last; t += std::chrono::milliseconds(200))
    records.emplace(t, [&, t] {
      const PositionSample p = position_at(log.positions, t);
      const GpsTime time = gps_from_utc(t);
      out.append(
          gps, {boot_us(t), 0, 4, static_cast<double>(time.week_ms), static_cast<double>(time.week),
                12, p.latitude.degrees(), p.longitude.degrees(), p.height_geoid_m});
    });
  for (const CameraFeedback& f : log.feedback)
    records.emplace(f.time, [&] {
      const PositionSample p = position_at(log.positions, f.time);
      const YawPitchRoll angles = yaw_pitch_roll(last_before(log.attitudes, f.time).ned_from_body);
      const GpsTime time = gps_from_utc(f.time);
      double yaw_deg = std::remainder(angles.yaw.degrees(), 360.0);
      if (yaw_deg < 0) yaw_deg += 360.0;
      for (const std::size_t record : {trig, cam})
        out.append(record, {boot_us(f.time), 0, static_cast<double>(f.image_index & 0xFFFF),
                            static_cast<double>(time.week_ms), static_cast<double>(time.week),
                            p.latitude.degrees(), p.longitude.degrees(), p.height_geoid_m,
                            p.height_geoid_m - home_height_m(log), p.height_geoid_m,
                            angles.roll.degrees(), angles.pitch.degrees(), yaw_deg});
    });
  for (const StampedRotation& g : log.gimbal)
    records.emplace(g.time, [&, angles = yaw_pitch_roll(g.rotation)] {
      constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
      out.append(mnt, {boot_us(g.time), 0, kNone, angles.roll.degrees(), kNone,
                       angles.pitch.degrees(), kNone, kNone, angles.yaw.degrees()});
    });
  for (const RangeSample& r : log.ranges)
    records.emplace(r.time, [&] {
      out.append(rfnd, {boot_us(r.time), 0, r.range_m, 4, kLooksDown, 100});
    });
  for (const auto& [time, append] : records) append();
  return out.bytes();
}

Result<Bytes> encode_lsf(const AutopilotLog& log) {
  const imc::Schema& schema = imc::Schema::builtin();
  imc::Header header;
  header.source = 0x0C00;  // an unmanned aircraft
  std::multimap<Time, imc::Message> records;
  for (const AttitudeSample& a : log.attitudes) {
    const PositionSample p = position_at(log.positions, a.time);
    WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(p.latitude, p.longitude));
    const YawPitchRoll angles = yaw_pitch_roll(a.ned_from_body);
    imc::Message m(*schema.find("EstimatedState"));
    records.emplace(a.time, m.set("lat", p.latitude.radians())
                                .set("lon", p.longitude.radians())
                                .set("height", p.height_geoid_m + geoid_m)
                                .set("phi", angles.roll.radians())
                                .set("theta", angles.pitch.radians())
                                .set("psi", angles.yaw.radians())
                                .set("depth", -1)
                                .set("alt", -1));
  }
  for (const RangeSample& r : log.ranges) {
    imc::Message device(*schema.find("DeviceState"));
    device.set("theta", -0.5 * std::numbers::pi);
    imc::Message m(*schema.find("Distance"));
    records.emplace(r.time, m.set("validity", 1).set("value", r.range_m).add("location", device));
  }
  Bytes out;
  for (const auto& [time, m] : records) {
    header.timestamp_s = to_seconds(time);
    WATERSKY_TRY(const Bytes packet, imc::encode(m, header));
    out.insert(out.end(), packet.begin(), packet.end());
  }
  return out;
}

}  // namespace

Result<AutopilotLog> autopilot_log_of(const Flight& flight) {
  AutopilotLog log;
  log.system = log.component = 1;
  std::map<Time, StampedPose> poses;
  for (const StampedPose& pose : flight.trajectory.poses()) poses.emplace(pose.time, pose);
  std::map<Time, Eigen::Quaterniond> gimbal;
  for (const StampedRotation& g : flight.gimbal.rotations()) gimbal.emplace(g.time, g.rotation);
  for (const ImageFrame& frame : flight.frames) {
    if (!frame.own_pose) continue;
    poses.emplace(frame.own_pose->time, *frame.own_pose);
    if (frame.own_gimbal) gimbal.emplace(frame.own_pose->time, *frame.own_gimbal);
  }
  if (poses.empty())
    return Error{ErrorCode::NotFound, flight.name + ": has no poses that a log could hold"};
  for (const auto& [time, pose] : poses) {
    const Geodetic place = flight.datum.geodetic(pose.world_from_body.origin());
    WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(place.latitude, place.longitude));
    log.positions.push_back(
        {time, place.latitude, place.longitude, place.height_ellipsoid_m - geoid_m});
    log.attitudes.push_back({time, flight.datum.world_from_ned_rotation(place).conjugate() *
                                       pose.world_from_body.rotation()});
  }
  std::vector<StampedRotation> attitudes;
  for (const AttitudeSample& a : log.attitudes) attitudes.push_back({a.time, a.ned_from_body});
  WATERSKY_TRY(const RotationTrack body, RotationTrack::make(std::move(attitudes)));
  for (const auto& [time, rotation] : gimbal) {
    if (flight.gimbal_reference != GimbalReference::Body) {
      log.gimbal.push_back({time, rotation});
    } else if (const auto attitude = body.at(time, std::chrono::seconds(1))) {
      log.gimbal.push_back({time, *attitude * rotation});
    }
  }
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const ImageFrame& frame = flight.frames[i];
    const auto time = frame.captured_at ? frame.captured_at : frame.received_at;
    if (time) log.feedback.push_back({*time, static_cast<int>(i)});
  }
  log.ranges = flight.ranges;
  return log;
}

Result<Bytes> encode_log(const AutopilotLog& log, LogFormat format) {
  if (log.attitudes.empty() || log.positions.empty())
    return Error{ErrorCode::NotFound, "a log without attitude or position cannot be written"};
  switch (format) {
    case LogFormat::Tlog: return encode_tlog(log);
    case LogFormat::DataFlash: return encode_dataflash(log);
    case LogFormat::Lsf: break;
  }
  return encode_lsf(log);
}

}  // namespace watersky
