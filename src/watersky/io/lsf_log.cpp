// SPDX-License-Identifier: MIT
#include "watersky/io/lsf_log.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "watersky/geo/rotation.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/detail/log_samples.hpp"
#include "watersky/wire/lsf.hpp"

namespace watersky {

namespace {

using imc::View;

/// The number of a message in this log's schema, and the places of fields in it; nothing where
/// the schema has no such message or field.
template <std::size_t n>
class Fields {
 public:
  Fields(const imc::Schema& schema, std::string_view message,
         const std::array<std::string_view, n>& names)
      : info_(schema.find(message)) {
    if (!info_) return;
    for (std::size_t i = 0; i < n; ++i) {
      at_[i] = info_->index(names[i]);
      const bool number =
          at_[i] < info_->fields.size() && info_->fields[at_[i]].type <= imc::FieldType::F64;
      if (!number) {
        info_ = nullptr;
        return;
      }
    }
  }
  [[nodiscard]] bool is(const imc::Packet& packet) const { return info_ && packet.info == info_; }
  [[nodiscard]] std::array<double, n> of(const View& view) const {
    std::array<double, n> out;
    for (std::size_t i = 0; i < n; ++i) out[i] = view.number(at_[i]);
    return out;
  }
  [[nodiscard]] bool known() const { return info_ != nullptr; }

 private:
  const imc::MessageInfo* info_;
  std::array<std::size_t, n> at_{};
};

struct State {
  Time time;
  double latitude_rad, longitude_rad, height_m, north_m, east_m, down_m;
  Eigen::Quaterniond ned_from_body;
};

/// What one system sent between two times that its clock was set back.
struct Run {
  std::vector<State> states;
  std::vector<std::pair<double, double>>
      gps_times;  ///< of the log, how much it is ahead of GPS [s]
  std::vector<RangeSample> ranges;
};

struct Source {
  detail::ClockRuns clock;
  std::vector<Run> runs;
  std::size_t lost_states = 0;  ///< before DUNE knew where it is
  std::size_t other_distances = 0;
  std::optional<double> home_height_m;
  bool flies_ardupilot = false;
};

/// UTC of a GpsFix [s since 1970], where it is valid.
std::optional<double> gps_utc_s(const std::array<double, 5>& fix) {
  constexpr unsigned kValidDate = 1, kValidTime = 2;
  const auto [validity, year, month, day, time_s] = fix;
  const auto bits = static_cast<unsigned>(validity);
  if ((bits & kValidDate) == 0 || (bits & kValidTime) == 0) return std::nullopt;
  using namespace std::chrono;
  const year_month_day date{std::chrono::year(static_cast<int>(year)),
                            std::chrono::month(static_cast<unsigned>(month)),
                            std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok() || year < 1990 || year > 2100 || !(time_s >= 0 && time_s <= 86'400))
    return std::nullopt;
  return to_seconds(Time(sys_days(date))) + time_s;
}

/// A device's forward axis lies along the body's down.
bool looks_down(const imc::Message& device) {
  constexpr double kDown_rad = -1.5707963267948966, kNear_rad = 0.2;
  return std::abs(device.number("theta") - kDown_rad) < kNear_rad;
}

class Reading {
 public:
  Reading(const imc::Schema& schema, std::string name)
      : name_(std::move(name)),
        schema_(schema),
        state_(schema, "EstimatedState",
               {"lat", "lon", "height", "x", "y", "z", "phi", "theta", "psi"}),
        fix_(schema, "GpsFix", {"validity", "utc_year", "utc_month", "utc_day", "utc_time"}),
        home_(schema, "HomePosition", {"lat", "lon", "height"}),
        distance_(schema, "Distance", {"validity", "value"}),
        device_(schema, "DeviceState", {"theta"}),
        apm_status_(schema.find("ApmStatus")) {}

  [[nodiscard]] bool knows_state() const { return state_.known(); }

  void take(const imc::LsfRecord& record);

  std::map<std::uint16_t, Source> sources;
  std::size_t packets = 0;
  std::size_t undecoded = 0;
  std::string first_fault;

 private:
  void take_state(Source& source, Run& run, Time time, const View& view);
  void take_distance(Source& source, Run& run, Time time, const imc::Packet& packet);

  std::string name_;
  const imc::Schema& schema_;
  Fields<9> state_;
  Fields<5> fix_;
  Fields<3> home_;
  Fields<2> distance_;
  Fields<1> device_;
  const imc::MessageInfo* apm_status_;
};

void Reading::take(const imc::LsfRecord& record) {
  ++packets;
  const imc::Packet& packet = record.packet;
  if (!packet.info) return;
  Source& source = sources[packet.header.source];
  if (packet.info == apm_status_) source.flies_ardupilot = true;
  const bool state = state_.is(packet), fix = fix_.is(packet), home = home_.is(packet),
             distance = distance_.is(packet);
  if (!state && !fix && !home && !distance) return;

  const auto time = time_from_seconds(packet.header.timestamp_s);
  if (!time) return;
  const auto at = source.clock.add(packet.header.timestamp_s);
  if (!at) return;
  const auto view = View::make(packet, schema_);
  if (!view) {
    if (undecoded++ == 0)
      first_fault = "byte " + std::to_string(record.offset) + ": " + view.error().message;
    return;
  }
  source.runs.resize(std::max(source.runs.size(), *at + 1));
  Run& run = source.runs[*at];
  if (state) take_state(source, run, *time, *view);
  if (distance) take_distance(source, run, *time, packet);
  if (home) source.home_height_m = home_.of(*view)[2];
  if (fix)
    if (const auto utc_s = gps_utc_s(fix_.of(*view)))
      run.gps_times.emplace_back(packet.header.timestamp_s, packet.header.timestamp_s - *utc_s);
}

void Reading::take_state(Source& source, Run& run, Time time, const View& view) {
  const auto [lat, lon, height, x, y, z, phi, theta, psi] = state_.of(view);
  for (const double v : {lat, lon, height, x, y, z, phi, theta, psi})
    if (!std::isfinite(v)) return;
  constexpr double kNowhere_rad = 1e-3, kFar_m = 1e6, kRounding_rad = 1e-9;
  if (std::abs(lat) > std::numbers::pi / 2 + kRounding_rad ||
      std::abs(lon) > std::numbers::pi + kRounding_rad)
    return;
  if (std::abs(x) > kFar_m || std::abs(y) > kFar_m || std::abs(z) > kFar_m ||
      std::abs(height) > kFar_m)
    return;
  if (std::hypot(lat, lon) < kNowhere_rad) {
    ++source.lost_states;
    return;
  }
  run.states.push_back(
      {time, lat, lon, height, x, y, z,
       rotation_from({Angle::radians(psi), Angle::radians(theta), Angle::radians(phi)})});
}

void Reading::take_distance(Source& source, Run& run, Time time, const imc::Packet& packet) {
  const auto message = imc::Message::decode(packet, schema_);
  if (!message || message->number("validity") != 1 || !device_.known()) return;
  const double range_m = message->number("value");
  const std::size_t location = message->info().index("location");
  const bool located = location < message->info().fields.size() &&
                       message->info().fields[location].type == imc::FieldType::List &&
                       message->info().fields[location].message_type == "DeviceState";
  bool down = false;
  if (located)
    for (const imc::Message& device : message->list("location"))
      down |= !device.is_none() && looks_down(device);
  if (!down)
    ++source.other_distances;
  else if (std::isfinite(range_m) && range_m > 0)
    run.ranges.push_back({time, range_m, 0.0});
}

/// Where the vehicle is: the reference displaced along its tangent plane, as DUNE does it, and
/// down by z.
Result<PositionSample> position_of(const State& s) {
  Geodetic g{Angle::radians(s.latitude_rad), Angle::radians(s.longitude_rad), s.height_m};
  if (s.north_m != 0 || s.east_m != 0)
    g = Datum(g).geodetic(Point<World>{{s.north_m, s.east_m, 0.0}});
  WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(g.latitude, g.longitude));
  return PositionSample{s.time, g.latitude, g.longitude, s.height_m - s.down_m - geoid_m};
}

std::string address(std::uint16_t id) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%04x", id);
  return text;
}

std::string with_decimals(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.2f", x);
  return text;
}

}  // namespace

Result<AutopilotLog> parse_lsf(std::span<const std::uint8_t> bytes, const imc::Schema& schema,
                               const std::string& name) {
  Reading reading(schema, name);
  if (!reading.knows_state())
    return Error{
        ErrorCode::Unsupported,
        name + ": its schema has no EstimatedState as IMC 5 has it; is its IMC.xml its own?"};
  imc::LsfReader reader(bytes, schema);
  while (const auto record = reader.next()) reading.take(*record);
  if (reading.packets == 0)
    return Error{ErrorCode::InvalidInput,
                 name + ": byte 0: holds no IMC packet; is it an LSF log of DUNE?"};

  AutopilotLog log;
  Source* vehicle = nullptr;
  Run* run = nullptr;
  std::size_t vehicles = 0;
  for (auto& [id, source] : reading.sources) {
    bool has_states = false;
    for (Run& candidate : source.runs) {
      if (candidate.states.empty()) continue;
      has_states = true;
      if (run && candidate.states.size() <= run->states.size()) continue;
      run = &candidate;
      vehicle = &source;
      log.system = id;
    }
    vehicles += has_states ? 1 : 0;
  }
  detail::note_damage(log.notes, name, "IMC packets", reader.skipped_bytes(), reader.gaps(),
                      reader.first_gap_at(), reader.truncated_bytes());
  if (reading.undecoded > 0)
    log.notes.push_back(name + ": " + std::to_string(reading.undecoded) +
                        " messages could not be decoded, the first at " + reading.first_fault);
  if (!run)
    return Error{ErrorCode::NotFound,
                 name + ": no system sent an EstimatedState with a position" +
                     (reading.first_fault.empty() ? "" : "; " + reading.first_fault)};
  if (vehicles > 1)
    log.notes.push_back(name + ": of " + std::to_string(vehicles) +
                        " vehicles the one with most poses was taken (" +
                        address(static_cast<std::uint16_t>(log.system)) + ")");
  if (vehicle->clock.runs() > 1)
    log.notes.push_back(name + ": DUNE's clock was set back " +
                        std::to_string(vehicle->clock.runs() - 1) +
                        " times; of what lies between the longest part was taken");
  if (vehicle->lost_states > 0)
    log.notes.push_back(name + ": " + std::to_string(vehicle->lost_states) +
                        " states from before DUNE knew where it is were left out");
  if (vehicle->other_distances > 0)
    log.notes.push_back(name + ": " + std::to_string(vehicle->other_distances) +
                        " Distances of devices not known to look down were not used");
  if (vehicle->flies_ardupilot)
    log.notes.push_back(name +
                        ": heights are taken as above the ellipsoid, as EstimatedState says; with "
                        "ArduPilot below it DUNE writes heights above mean sea level there unless "
                        "\"Convert MSL to WGS84 height\" is set");

  // Where GPS itself is late by some tenths, a clock that NTP keeps is the better one.
  constexpr double kClockWrong_s = 0.5;
  LowerLine ahead;  // of GPS; zero where it is not corrected
  if (run->gps_times.size() > 1) {
    const LowerLine measured = detail::fit_clock(run->gps_times);
    const double offset_s = measured.at(run->gps_times.front().first);
    if (std::abs(offset_s) >= kClockWrong_s) {
      ahead = measured;
      log.notes.push_back(name + ": DUNE's clock was " + with_decimals(std::abs(offset_s)) + " s " +
                          (offset_s > 0 ? "ahead of" : "behind") +
                          " GPS time, which was corrected");
    }
  }
  const auto utc = [&](Time t) { return t - seconds(ahead.at(to_seconds(t))); };
  for (State& s : run->states) {
    s.time = utc(s.time);
    WATERSKY_TRY(const PositionSample position, position_of(s));
    log.attitudes.push_back({s.time, s.ned_from_body});
    log.positions.push_back(position);
  }
  for (const RangeSample& r : run->ranges)
    log.ranges.push_back({utc(r.time), r.range_m, r.sigma_m});
  detail::sort_by_time(log.attitudes);
  detail::sort_by_time(log.positions);
  detail::sort_by_time(log.ranges);
  if (vehicle->home_height_m && std::isfinite(*vehicle->home_height_m)) {
    const PositionSample& first = log.positions.front();
    WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(first.latitude, first.longitude));
    log.home_height_geoid_m = *vehicle->home_height_m - geoid_m;
  }
  return log;
}

}  // namespace watersky
