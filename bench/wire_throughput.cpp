// SPDX-License-Identifier: MIT
/// How fast recordings are decoded, one core, processor time, medians of five: MAVLink frames found
/// and checked (wire.mavlink.frames_mb_s), with every field of every message read
/// (wire.mavlink.decode_mb_s); IMC packets likewise (wire.imc.packets_mb_s, wire.imc.decode_mb_s,
/// and as messages with memory of their own wire.imc.messages_mb_s); signatures checked
/// (wire.mavlink.signatures_per_s); an hour's .tlog to a trajectory (wire.tlog.hour_s). Beside it
/// node-mavlink in the same run, its processor time (wire.node_mavlink.decode_mb_s, and how many
/// times as fast ours is, wire.mavlink.ratio_node_mavlink), where node and tests/node/node_modules
/// are.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "bench.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/io/autopilot_log.hpp"
#include "watersky/wire/imc.hpp"
#include "watersky/wire/mavlink_signing.hpp"
#include "watersky/wire/tlog.hpp"

using namespace watersky;
using bench::print_figure;
using Bytes = std::vector<std::uint8_t>;

namespace {

const Time kStart{std::chrono::sys_days{std::chrono::year{2026} / 6 / 1}};
double sink = 0;  // keeps what is read from being left out

double median_seconds(const std::function<void()>& body) {
  std::vector<double> seconds;
  for (int i = 0; i < 5; ++i) seconds.push_back(bench::cpu_seconds_of(body));
  return bench::median(seconds);
}
double mb_s(std::size_t bytes, double seconds) {
  return 1e-6 * static_cast<double>(bytes) / seconds;
}

/// What ArduPilot sends a ground station: messages, and how many a second.
struct Rate {
  const char* name;
  int hz;
};
constexpr Rate kTelemetry[] = {{"ATTITUDE", 20},         {"GLOBAL_POSITION_INT", 10},
                               {"VFR_HUD", 10},          {"RAW_IMU", 10},
                               {"GPS_RAW_INT", 5},       {"SERVO_OUTPUT_RAW", 5},
                               {"RC_CHANNELS", 5},       {"SYS_STATUS", 2},
                               {"HEARTBEAT", 1},         {"NAV_CONTROLLER_OUTPUT", 5},
                               {"VIBRATION", 2},         {"BATTERY_STATUS", 2},
                               {"SYSTEM_TIME", 1},       {"AHRS2", 10},
                               {"EKF_STATUS_REPORT", 2}, {"SCALED_PRESSURE", 5}};

/// One message of the flight at `boot_s`, of numbers that do not compress away.
mavlink::Message telemetry(const mavlink::MessageInfo& info, double boot_s) {
  mavlink::Message m(info);
  double value = boot_s;
  for (const auto& field : info.fields)
    if (field.type != mavlink::FieldType::Char) m.set(field.name, value = 1.1 * value + 1);
  if (info.field("time_boot_ms")) m.set("time_boot_ms", boot_s * 1e3);
  if (info.name == "ATTITUDE") m.set("roll", 0.1 * std::sin(boot_s)).set("pitch", 0).set("yaw", 1);
  if (info.name == "GLOBAL_POSITION_INT") {
    m.set("lat", 78.9e7 + 20 * boot_s).set("lon", 11.9e7).set("alt", 95e3);
    m.set("relative_alt", 80e3);
  }
  return m;
}

/// Calls `use` with each frame of `seconds` of telemetry, in order of time.
void fly(double seconds, const std::function<void(double, const Bytes&)>& use) {
  std::uint8_t sequence = 0;
  for (int tick = 0; tick < seconds * 20; ++tick)
    for (const auto& [name, hz] : kTelemetry) {
      if (tick % (20 / hz) != 0) continue;
      const double boot_s = 10 + tick / 20.0;
      use(boot_s,
          mavlink::encode(telemetry(*mavlink::find_message(name), boot_s), {1, 1, ++sequence})
              .value());
    }
}

double read_all(const mavlink::Message& m) {
  double sum = 0;
  for (const auto& field : m.info().fields)
    for (std::size_t i = 0; i < std::max<std::size_t>(1, field.count); ++i)
      sum += m.number(field, i);
  return sum;
}

template <class Use>
std::size_t each_frame(std::span<const std::uint8_t> bytes, Use&& use) {
  std::size_t n = 0;
  while (!bytes.empty()) {
    const mavlink::ParseStep step = mavlink::parse_frame(bytes);
    if (step.outcome != mavlink::ParseOutcome::Frame) std::abort();  // ours: all are whole
    use(step.frame);
    ++n;
    bytes = bytes.subspan(step.frame.bytes.size());
  }
  return n;
}

/// node-mavlink's time for the same bytes; 0 where it cannot be asked.
double node_seconds(const Bytes& frames) {
  const std::string folder = WATERSKY_NODE_FOLDER;
  if (std::string(WATERSKY_NODE).empty() || !std::filesystem::exists(folder + "/node_modules")) {
    std::fputs(
        "node or tests/node/node_modules is missing: not compared with node-mavlink "
        "(scripts/setup test)\n",
        stderr);
    return 0;
  }
  const test::TemporaryFolder scratch;
  const std::string file = (scratch.path() / "frames").string(),
                    out = (scratch.path() / "out").string();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(frames.data()),
             static_cast<std::streamsize>(frames.size()));
  const std::string command = "'" WATERSKY_NODE "' '" + folder + "/time_mavlink.mjs' '" + file +
                              "' >'" + out + "' </dev/null";
  double seconds = 0;
  if (std::system(command.c_str()) == 0)
    if (std::FILE* answer = std::fopen(out.c_str(), "r")) {
      if (std::fscanf(answer, "{\"seconds\":%lf", &seconds) != 1) seconds = 0;
      std::fclose(answer);
    }
  return seconds;
}

void mavlink_figures() {
  Bytes frames, log;
  fly(3600, [&](double boot_s, const Bytes& frame) {
    frames.insert(frames.end(), frame.begin(), frame.end());
    mavlink::append_tlog_record(log, kStart + seconds(boot_s + 0.02), frame);
  });
  std::size_t n = 0;
  const double found_s =
      median_seconds([&] { n = each_frame(frames, [](const mavlink::Frame&) {}); });
  const double decoded_s = median_seconds([&] {
    each_frame(frames, [](const mavlink::Frame& f) { sink += read_all(mavlink::Message(f)); });
  });
  print_figure("wire.mavlink.frame_bytes",
               static_cast<double>(frames.size()) / static_cast<double>(n), "bytes");
  print_figure("wire.mavlink.frames_mb_s", mb_s(frames.size(), found_s), "MB/s");
  print_figure("wire.mavlink.decode_mb_s", mb_s(frames.size(), decoded_s), "MB/s");

  const mavlink::SigningKey key = mavlink::signing_key("bench");
  mavlink::Signer signer(key, 0);
  Bytes signed_frames;
  std::size_t signatures = 0;
  fly(60, [&](double, const Bytes& frame) {
    const Bytes bytes = signer.sign(frame, kStart).value();
    signed_frames.insert(signed_frames.end(), bytes.begin(), bytes.end());
    ++signatures;
  });
  const double checked_s = median_seconds([&] {
    mavlink::SignatureChecker checker(key, kStart);
    each_frame(signed_frames, [&](const mavlink::Frame& f) {
      if (checker.check(f) != mavlink::SignatureVerdict::Good) std::abort();
    });
  });
  print_figure("wire.mavlink.signatures_per_s", static_cast<double>(signatures) / checked_s, "1/s");

  const double hour_s = median_seconds([&] {
    const AutopilotLog flight = parse_tlog(log, "bench.tlog").value();
    const PositionSample& p = flight.positions.front();
    const auto trajectory = make_trajectory(flight, Datum({p.latitude, p.longitude, 0.0})).value();
    sink += static_cast<double>(trajectory.poses().size());
  });
  print_figure("wire.tlog.hour_mb", 1e-6 * static_cast<double>(log.size()), "MB");
  print_figure("wire.tlog.hour_s", hour_s, "s");

  // A tenth of it is enough to time node-mavlink.
  const Bytes part(frames.begin(),
                   frames.begin() + static_cast<std::ptrdiff_t>(frames.size() / 10));
  if (const double node_s = node_seconds(part); node_s > 0) {
    print_figure("wire.node_mavlink.decode_mb_s", mb_s(part.size(), node_s), "MB/s");
    print_figure("wire.mavlink.ratio_node_mavlink",
                 mb_s(frames.size(), decoded_s) / mb_s(part.size(), node_s), "1");
  }
}

/// The mix of a vehicle's log: how many of each, of a hundred.
constexpr Rate kVehicle[] = {
    {"SimulatedState", 28},   {"CpuUsage", 16},        {"EntityState", 16},
    {"EstimatedState", 6},    {"IndicatedSpeed", 6},   {"TrueSpeed", 6},
    {"TransportBindings", 5}, {"PlanControlState", 2}, {"EstimatedStreamVelocity", 6},
    {"DesiredRoll", 3}};

void imc_figures() {
  const imc::Schema& schema = imc::Schema::builtin();
  Bytes packets;
  for (int second = 0; second < 2000; ++second)
    for (const auto& [name, count] : kVehicle)
      for (int i = 0; i < count; ++i) {
        imc::Message m(*schema.find(name));
        double value = second + 0.01 * i;
        for (const imc::FieldInfo& field : m.info().fields) {
          if (field.type == imc::FieldType::Text)
            m.set_bytes(field.name, "a text of some length");
          else
            m.set(field.name, value = 1.1 * value + 1);
        }
        const Bytes packet = imc::encode(m, {1.7e9 + second, 0x0C0C, 1, 0xFFFF, 255}).value();
        packets.insert(packets.end(), packet.begin(), packet.end());
      }
  std::size_t n = 0;
  const auto each_packet = [&](const auto& use) {
    std::span<const std::uint8_t> rest = packets;
    for (n = 0; !rest.empty(); ++n) {
      const imc::ParseStep step = imc::parse_packet(rest, schema);
      if (step.outcome != imc::ParseOutcome::Packet) std::abort();
      use(step.packet);
      rest = rest.subspan(step.packet.bytes.size());
    }
  };
  const double found_s = median_seconds([&] { each_packet([](const imc::Packet&) {}); });
  const double decoded_s = median_seconds([&] {
    each_packet([&](const imc::Packet& packet) {
      const auto view = imc::View::make(packet, schema);
      if (!view) std::abort();
      const auto& fields = packet.info->fields;
      for (std::size_t i = 0; i < fields.size(); ++i)
        sink += fields[i].type <= imc::FieldType::F64
                    ? view->number(i)
                    : static_cast<double>(view->text(fields[i].name).size());
    });
  });
  const double messages_s = median_seconds([&] {
    each_packet([&](const imc::Packet& packet) {
      sink += imc::Message::decode(packet, schema)->info().id;
    });
  });
  print_figure("wire.imc.packet_bytes",
               static_cast<double>(packets.size()) / static_cast<double>(n), "bytes");
  print_figure("wire.imc.packets_mb_s", mb_s(packets.size(), found_s), "MB/s");
  print_figure("wire.imc.decode_mb_s", mb_s(packets.size(), decoded_s), "MB/s");
  print_figure("wire.imc.messages_mb_s", mb_s(packets.size(), messages_s), "MB/s");
}

}  // namespace

int main() {
  mavlink_figures();
  imc_figures();
  return std::isnan(sink) ? 1 : 0;
}
