// SPDX-License-Identifier: MIT
#include "watersky/io/dataflash_log.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "watersky/geo/rotation.hpp"
#include "watersky/io/detail/log_samples.hpp"
#include "watersky/wire/dataflash.hpp"

namespace watersky {

namespace {

using dataflash::Format;
using dataflash::Record;

/// A sample at a time since boot [s].
template <class T>
using Timed = std::vector<std::pair<double, T>>;

struct Place {
  double latitude_deg, longitude_deg, height_geoid_m;
};

/// All between two starts of the autopilot.
struct Run {
  /// By record and, where there are several, estimator core or instance.
  std::map<std::pair<std::string, int>, Timed<Eigen::Quaterniond>> attitudes;
  std::map<std::pair<std::string, int>, Timed<Place>> places;
  std::map<std::pair<std::string, int>, Timed<Eigen::Vector3d>> offsets;  ///< NED from the origin
  std::map<int, std::size_t> primary_core;  ///< how often each was in use
  std::vector<double> home_heights_m;
  std::optional<Place> origin, home;
  Timed<Time> gps_times;
  std::map<int, Timed<int>> cameras;  ///< image indices
  std::size_t triggers = 0;
  struct Mount {
    Eigen::Quaterniond rotation;
    bool yaw_from_body = false;
  };
  std::map<int, Timed<Mount>> mounts;
  std::map<int, Timed<double>> ranges;
  std::size_t samples = 0;
};

/// Whether a record has all of these as numbers.
bool has_numbers(const Format& format, std::initializer_list<std::string_view> names) {
  return std::all_of(names.begin(), names.end(), [&](std::string_view name) {
    const std::size_t i = format.index(name);
    return i < format.fields.size() &&
           std::string_view("nNZa").find(format.fields[i].type) == std::string_view::npos;
  });
}

/// A small whole number, whatever type its log gives it.
int whole(const Record& record, std::string_view name) {
  const double x = record.number(name);
  return std::abs(x) < 1e9 ? static_cast<int>(x) : -1;
}

/// Which of several: the first of these fields that there is.
int which(const Record& record, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names)
    if (has_numbers(*record.format, {name})) return whole(record, name);
  return 0;
}

bool plausible(const Place& p) {
  return std::abs(p.latitude_deg) <= 90 && std::abs(p.longitude_deg) <= 180 &&
         std::isfinite(p.height_geoid_m) && (p.latitude_deg != 0 || p.longitude_deg != 0);
}

void add_angles(Run& run, double s, const Record& r) {
  const double roll = r.number("Roll"), pitch = r.number("Pitch"), yaw = r.number("Yaw");
  if (std::isfinite(roll) && std::isfinite(pitch) && std::isfinite(yaw))
    run.attitudes[{r.format->name, 0}].emplace_back(
        s, rotation_from({Angle::degrees(yaw), Angle::degrees(pitch), Angle::degrees(roll)}));
}

void add_quaternion(Run& run, double s, const Record& r) {
  const Eigen::Quaterniond q(r.number("Q1"), r.number("Q2"), r.number("Q3"), r.number("Q4"));
  if (q.coeffs().allFinite() && q.norm() > 0.5)
    run.attitudes[{r.format->name, which(r, {"C"})}].emplace_back(s, q.normalized());
}

void add_place(Run& run, double s, const Record& r, int instance) {
  const Place place{r.number("Lat"), r.number("Lng"), r.number("Alt")};
  if (plausible(place)) run.places[{r.format->name, instance}].emplace_back(s, place);
}

void add_mount(Run& run, double s, const Record& r) {
  const double roll = r.number("Roll"), pitch = r.number("Pitch");
  const double earth = r.number("YawE"), body = r.number("YawB");
  const bool from_body = !std::isfinite(earth);
  const double yaw = from_body ? body : earth;
  if (!std::isfinite(roll) || !std::isfinite(pitch) || !std::isfinite(yaw)) return;
  run.mounts[which(r, {"I"})].emplace_back(
      s,
      Run::Mount{rotation_from({Angle::degrees(yaw), Angle::degrees(pitch), Angle::degrees(roll)}),
                 from_body});
}

void add_range(Run& run, double s, const Record& r) {
  constexpr int kLooksDown = 25;  // MAV_SENSOR_ROTATION_PITCH_270
  constexpr int kGood = 4;        // RangeFinder::Status
  if (whole(r, "Orient") != kLooksDown) return;
  if (has_numbers(*r.format, {"Stat"}) && whole(r, "Stat") != kGood) return;
  const double range_m = r.number("Dist");
  if (std::isfinite(range_m) && range_m > 0)
    run.ranges[which(r, {"Instance", "I"})].emplace_back(s, range_m);
}

void take(Run& run, double s, const Record& r) {
  const std::string& name = r.format->name;
  const auto has = [&](std::initializer_list<std::string_view> names) {
    return has_numbers(*r.format, names);
  };
  ++run.samples;
  if (name == "ATT" && has({"Roll", "Pitch", "Yaw"})) {
    add_angles(run, s, r);
  } else if ((name == "XKQ" || name == "NKQ" || name == "AHR2") && has({"Q1", "Q2", "Q3", "Q4"})) {
    add_quaternion(run, s, r);
    if (name == "AHR2" && has({"Lat", "Lng", "Alt"})) add_place(run, s, r, 0);
  } else if (name == "POS" && has({"Lat", "Lng", "Alt"})) {
    add_place(run, s, r, 0);
    if (has({"RelHomeAlt"})) run.home_heights_m.push_back(r.number("Alt") - r.number("RelHomeAlt"));
  } else if (name == "GPS" && has({"Status", "GMS", "GWk", "Lat", "Lng", "Alt"})) {
    constexpr double kFix3D = 3;
    if (r.number("Status") < kFix3D) return;
    add_place(run, s, r, which(r, {"I"}));
    const double week = r.number("GWk"), ms = r.number("GMS");
    // Weeks from 2000 to 2100; a week has 604 800 000 ms.
    if (week > 1042 && week < 6262 && ms >= 0 && ms < 604'800'000)
      run.gps_times.emplace_back(
          s, utc_from_gps(static_cast<int>(week), static_cast<std::int64_t>(ms)));
  } else if ((name == "XKF1" || name == "NKF1") && has({"PN", "PE", "PD"})) {
    const Eigen::Vector3d ned(r.number("PN"), r.number("PE"), r.number("PD"));
    if (ned.allFinite() && ned.norm() < 1e6)
      run.offsets[{name, which(r, {"C"})}].emplace_back(s, ned);
  } else if ((name == "XKF4" || name == "NKF4") && has({"PI"})) {
    ++run.primary_core[whole(r, "PI")];
  } else if (name == "ORGN" && has({"Type", "Lat", "Lng", "Alt"})) {
    constexpr double kHome = 1;
    const Place place{r.number("Lat"), r.number("Lng"), r.number("Alt")};
    if (plausible(place)) (r.number("Type") == kHome ? run.home : run.origin) = place;
  } else if (name == "CAM" && has({"Img"})) {
    run.cameras[which(r, {"I"})].emplace_back(s, whole(r, "Img"));
  } else if (name == "TRIG") {
    ++run.triggers;
  } else if (name == "MNT" && has({"Roll", "Pitch", "YawB", "YawE"})) {
    add_mount(run, s, r);
  } else if (name == "RFND" && has({"Dist", "Orient"})) {
    add_range(run, s, r);
  }
}

/// ArduPilot's own way from metres to degrees, so that it takes back what it did: a sphere, and
/// the parallel half way.
Place displaced(const Place& origin, const Eigen::Vector3d& ned_m) {
  constexpr double kMetresPerDegree = 111318.84502145034;
  const double north_deg = ned_m.x() / kMetresPerDegree;
  const double half_way = Angle::degrees(origin.latitude_deg + 0.5 * north_deg).radians();
  return {
      origin.latitude_deg + north_deg,
      origin.longitude_deg + ned_m.y() / (kMetresPerDegree * std::max(0.01, std::cos(half_way))),
      origin.height_geoid_m - ned_m.z()};
}

template <class T>
double span_s(const Timed<T>& samples) {
  return samples.size() < 2 ? 0.0 : samples.back().first - samples.front().first;
}

/// The instance of a record with most samples, or of an estimator the core in use.
template <class Map>
const typename Map::mapped_type* best_of(const Map& all, const std::string& record,
                                         std::optional<int> core) {
  const typename Map::mapped_type* best = nullptr;
  for (const auto& [key, samples] : all) {
    if (key.first != record) continue;
    if (core && key.second == *core) return &samples;
    if (!best || samples.size() > best->size()) best = &samples;
  }
  return best;
}

/// The first of `order` that covers nearly as much time as any; what there is besides in `others`.
template <class T>
std::optional<std::pair<std::string, Timed<T>>> choose(
    const std::vector<std::pair<std::string, Timed<T>>>& order, std::string& others) {
  double longest_s = 0;
  for (const auto& candidate : order) longest_s = std::max(longest_s, span_s(candidate.second));
  std::optional<std::pair<std::string, Timed<T>>> chosen;
  for (const auto& candidate : order) {
    if (candidate.second.size() < 2) continue;
    if (!chosen && span_s(candidate.second) >= 0.9 * longest_s)
      chosen = candidate;
    else
      others += (others.empty() ? "" : ", ") + candidate.first;
  }
  return chosen;
}

template <class T>
std::string chosen_note(const std::string& log, const char* what,
                        const std::pair<std::string, Timed<T>>& chosen, const std::string& others) {
  return log + ": " + what + " is from the " + std::to_string(chosen.second.size()) + " " +
         chosen.first + " records" +
         (others.empty() ? std::string() : " (also there: " + others + ")");
}

/// Takes boot time to UTC.
struct BootToUtc {
  Time start{};
  LowerLine line;  ///< boot time less UTC since start

  static BootToUtc fit(const Timed<Time>& gps_times) {
    BootToUtc out;
    if (gps_times.empty()) return out;
    out.start = gps_times.front().second - seconds(gps_times.front().first);
    std::vector<std::pair<double, double>> points;
    // A fix is logged after its moment, never before.
    for (const auto& [boot_s, utc] : gps_times)
      points.emplace_back(boot_s, boot_s - to_seconds(utc - out.start));
    out.line = detail::fit_clock(points);
    return out;
  }
  [[nodiscard]] Time operator()(double boot_s) const {
    return start + seconds(boot_s - line.at(boot_s));
  }
};

void take_cameras(const Run& run, const BootToUtc& utc, const std::string& name,
                  AutopilotLog& log) {
  log.feedback_name = "CAM records";
  const Timed<int>* most = nullptr;
  for (const auto& [instance, images] : run.cameras)
    if (!most || images.size() > most->size()) most = &images;
  if (!most) return;
  for (const auto& [s, index] : *most) log.feedback.push_back({utc(s), index});
  if (run.cameras.size() > 1)
    log.notes.push_back(name + ": of " + std::to_string(run.cameras.size()) +
                        " cameras the one with most CAM records was taken");
  if (run.triggers == 0)
    log.notes.push_back(name +
                        ": CAM records tell when the camera was told to shoot, not when it did "
                        "(there are no TRIG records, as with a feedback pin)");
}

Status take_gimbal(const Run& run, const BootToUtc& utc, AutopilotLog& log) {
  const Timed<Run::Mount>* most = nullptr;
  for (const auto& [instance, mounts] : run.mounts)
    if (!most || mounts.size() > most->size()) most = &mounts;
  if (!most) return {};
  std::vector<StampedRotation> attitudes;
  for (const AttitudeSample& a : log.attitudes) attitudes.push_back({a.time, a.ned_from_body});
  WATERSKY_TRY(const RotationTrack body, RotationTrack::make(std::move(attitudes)));
  for (const auto& [s, mount] : *most) {
    Eigen::Quaterniond q = mount.rotation;
    if (mount.yaw_from_body) {
      const auto attitude = body.at(utc(s), std::chrono::seconds(1));
      if (!attitude) continue;
      q = heading(yaw_pitch_roll(*attitude).yaw) * q;
    }
    log.gimbal.push_back({utc(s), q});
  }
  detail::sort_by_time(log.gimbal);
  return {};
}

}  // namespace

Result<AutopilotLog> parse_dataflash(std::span<const std::uint8_t> bytes, const std::string& name) {
  dataflash::Reader reader(bytes);
  detail::ClockRuns clock;
  std::vector<Run> runs;
  while (const auto record = reader.next()) {
    if (!has_numbers(*record->format, {"TimeUS"})) continue;
    const double boot_s = record->number("TimeUS") * 1e-6;
    constexpr double kLongest_s = 1e8;  // three years; what is beyond no clock here can count
    if (!(boot_s >= 0 && boot_s < kLongest_s)) continue;
    const auto run = clock.add(boot_s);
    if (!run) continue;
    runs.resize(std::max(runs.size(), *run + 1));
    take(runs[*run], boot_s, *record);
  }
  if (reader.formats().empty()) return dataflash::no_format_error(bytes).at(name);
  if (runs.empty())
    return Error{ErrorCode::NotFound, name + ": holds no record with a TimeUS, so no flight"};

  const Run& run = *std::max_element(
      runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.samples < b.samples; });
  AutopilotLog log;
  if (runs.size() > 1)
    log.notes.push_back(name + ": the autopilot was restarted " + std::to_string(runs.size() - 1) +
                        " times; of the runs the longest was taken");
  if (clock.strays() > 0)
    log.notes.push_back(name + ": " + std::to_string(clock.strays()) +
                        " records with a time far from their neighbours' were left out");
  detail::note_damage(log.notes, name, "DataFlash records", reader.skipped_bytes(), reader.gaps(),
                      reader.first_gap_at(), reader.truncated_bytes());

  std::optional<int> core;
  for (const auto& [index, n] : run.primary_core)
    if (!core || n > run.primary_core.at(*core)) core = index;
  std::vector<std::pair<std::string, Timed<Eigen::Quaterniond>>> attitudes;
  for (const char* record : {"ATT", "XKQ", "NKQ", "AHR2"})
    if (const auto* samples = best_of(run.attitudes, record, core))
      attitudes.emplace_back(record, *samples);
  std::vector<std::pair<std::string, Timed<Place>>> places;
  const auto add_places = [&](const char* record) {
    if (const auto* samples = best_of(run.places, record, std::nullopt))
      places.emplace_back(record, *samples);
  };
  add_places("POS");
  for (const char* record : {"XKF1", "NKF1"}) {
    const auto* offsets = best_of(run.offsets, record, core);
    if (!offsets || !run.origin) continue;
    places.emplace_back(record, Timed<Place>());
    for (const auto& [s, ned] : *offsets)
      if (const Place p = displaced(*run.origin, ned); plausible(p))
        places.back().second.emplace_back(s, p);
  }
  add_places("AHR2");
  add_places("GPS");

  std::string other_attitudes, other_places;
  const auto attitude = choose(attitudes, other_attitudes);
  const auto place = choose(places, other_places);
  if (!attitude || !place)
    return Error{ErrorCode::NotFound,
                 name + ": holds no " +
                     (attitude ? "position (POS, XKF1 or NKF1 with ORGN, AHR2 or GPS with a fix)"
                               : "attitude (ATT, XKQ, NKQ or AHR2)") +
                     "; was it logged? (LOG_BITMASK)"};
  log.notes.push_back(chosen_note(name, "attitude", *attitude, other_attitudes));
  log.notes.push_back(chosen_note(name, "position", *place, other_places));

  const BootToUtc utc = BootToUtc::fit(run.gps_times);
  if (run.gps_times.empty())
    log.notes.push_back(name +
                        ": GPS never told the time: times count from the autopilot's start, and "
                        "only its CAM records can time images");
  for (const auto& [s, q] : attitude->second) log.attitudes.push_back({utc(s), q});
  for (const auto& [s, p] : place->second)
    log.positions.push_back({utc(s), Angle::degrees(p.latitude_deg),
                             Angle::degrees(p.longitude_deg), p.height_geoid_m});
  detail::sort_by_time(log.attitudes);
  detail::sort_by_time(log.positions);
  if (!run.home_heights_m.empty())
    log.home_height_geoid_m = detail::median(run.home_heights_m);
  else if (run.home)
    log.home_height_geoid_m = run.home->height_geoid_m;

  take_cameras(run, utc, name, log);
  WATERSKY_CHECK(take_gimbal(run, utc, log));
  const Timed<double>* ranges = nullptr;
  for (const auto& [instance, samples] : run.ranges)
    if (!ranges || samples.size() > ranges->size()) ranges = &samples;
  if (ranges)
    for (const auto& [s, range_m] : *ranges) log.ranges.push_back({utc(s), range_m, 0.0});
  detail::sort_by_time(log.ranges);
  return log;
}

}  // namespace watersky
