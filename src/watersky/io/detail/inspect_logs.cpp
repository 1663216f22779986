// SPDX-License-Identifier: MIT
#include "watersky/io/detail/inspect_logs.hpp"

#include <cstdio>

#include "watersky/io/dataflash_log.hpp"
#include "watersky/io/detail/logged.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/lsf_log.hpp"
#include "watersky/wire/dataflash.hpp"
#include "watersky/wire/lsf.hpp"
#include "watersky/wire/tlog.hpp"

namespace watersky::detail {

namespace fs = std::filesystem;

namespace {

/// Messages or records by name.
class Kinds {
 public:
  void add(const std::string& name, Time time) {
    Seen& s = seen_[name];
    s.first = s.n == 0 ? time : std::min(s.first, time);
    s.last = s.n == 0 ? time : std::max(s.last, time);
    ++s.n;
  }
  [[nodiscard]] bool empty() const { return seen_.empty(); }
  void tell(Inspection& out) const {
    for (const auto& [name, s] : seen_) {
      out.counts[name] = s.n;
      add_rate(out, name, s.n, s.first, s.last);
    }
  }

 private:
  struct Seen {
    std::size_t n = 0;
    Time first, last;
  };
  std::map<std::string, Seen> seen_;
};

/// Where and when a log's flight was, or why that cannot be told.
void tell_flight(Inspection& out, const Result<AutopilotLog>& log) {
  if (!log) {
    out.notes.push_back(log.error().message);
    return;
  }
  for (const PositionSample& p : log->positions) {
    add_place(out, p.latitude.degrees(), p.longitude.degrees());
    add_time(out, p.time);
  }
  for (const AttitudeSample& a : log->attitudes) add_time(out, a.time);
  out.notes.insert(out.notes.end(), log->notes.begin(), log->notes.end());
}

}  // namespace

Result<Inspection> inspect_tlog(const fs::path& file) {
  WATERSKY_TRY(const auto bytes, read_bytes(file));
  Inspection out;
  out.kind = "tlog";
  Kinds seen;
  std::map<std::string, std::size_t> systems;
  mavlink::TlogReader reader(bytes);
  while (const auto record = reader.next()) {
    const mavlink::Frame& f = record->frame;
    seen.add(f.info ? std::string(f.info->name) : "message_" + std::to_string(f.message_id),
             record->received_at);
    ++systems[std::to_string(f.system) + "/" + std::to_string(f.component)];
    add_time(out, record->received_at);
    constexpr std::uint32_t kGlobalPositionInt = 33;
    if (f.info && f.message_id == kGlobalPositionInt) {
      const mavlink::Message m(f);
      const double lat = m.number("lat") * 1e-7, lon = m.number("lon") * 1e-7;
      if (lat != 0 || lon != 0) add_place(out, lat, lon);
    }
  }
  if (seen.empty())
    return Error{ErrorCode::InvalidInput,
                 file.string() + ": holds no MAVLink message; is it a .tlog?"};
  seen.tell(out);
  for (const auto& [id, n] : systems)
    out.facts["system/component " + id] = std::to_string(n) + " messages";
  if (reader.skipped_bytes() > 0)
    out.notes.push_back(std::to_string(reader.skipped_bytes()) + " bytes in " +
                        std::to_string(reader.gaps()) + " places are no MAVLink");
  if (reader.truncated_bytes() > 0)
    out.notes.emplace_back("the log ends in the middle of a message");
  return out;
}

Result<Inspection> inspect_dataflash(const fs::path& file) {
  WATERSKY_TRY(const auto bytes, read_bytes(file));
  Inspection out;
  out.kind = "dataflash";
  Kinds seen;
  dataflash::Reader reader(bytes);
  while (const auto record = reader.next()) {
    const dataflash::Format& format = *record->format;
    // A record without a time counts all the same.
    Time time{};
    if (const std::size_t i = format.index("TimeUS");
        i < format.fields.size() && (format.fields[i].type == 'Q' || format.fields[i].type == 'I'))
      time += std::chrono::microseconds(std::min<std::uint64_t>(
          static_cast<std::uint64_t>(record->integer("TimeUS")), std::uint64_t{1} << 52));
    seen.add(format.name.empty() ? "type_" + std::to_string(format.type) : format.name, time);
    if (format.name == "VER" && format.has("FWS") &&
        std::string_view("nNZ").find(format.fields[format.index("FWS")].type) !=
            std::string_view::npos)
      out.facts["firmware"] = record->text("FWS");
  }
  if (reader.formats().empty()) return dataflash::no_format_error(bytes).at(file.string());
  seen.tell(out);
  tell_flight(out, parse_dataflash(bytes, file.filename().string()));
  return out;
}

Result<Inspection> inspect_lsf(const fs::path& file) {
  WATERSKY_TRY(const LsfFile lsf, read_lsf_file(file));
  Inspection out;
  out.kind = "lsf";
  Kinds seen;
  std::map<std::string, std::size_t> systems;
  imc::LsfReader reader(lsf.bytes, lsf.schema());
  while (const auto record = reader.next()) {
    const imc::Packet& packet = record->packet;
    const Time time = time_from_seconds(packet.header.timestamp_s).value_or(Time{});
    seen.add(packet.info ? packet.info->name : "message_" + std::to_string(packet.message_id),
             time);
    char id[16];
    std::snprintf(id, sizeof id, "0x%04x", packet.header.source);
    ++systems[id];
    add_time(out, time);
  }
  if (seen.empty())
    return Error{ErrorCode::InvalidInput,
                 file.string() + ": byte 0: holds no IMC packet; is it an LSF log of DUNE?"};
  seen.tell(out);
  for (const auto& [id, n] : systems) out.facts["system " + id] = std::to_string(n) + " packets";
  out.facts["schema"] = lsf.own_schema ? "the IMC.xml beside it" : "ours";
  out.notes = lsf.notes;
  tell_flight(out, parse_lsf(lsf.bytes, lsf.schema(), file.filename().string()));
  return out;
}

}  // namespace watersky::detail
