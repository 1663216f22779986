// SPDX-License-Identifier: MIT
#include "watersky/io/detail/logged.hpp"

#include <algorithm>
#include <fstream>

#include "watersky/geodesy/projection.hpp"
#include "watersky/io/dataflash_log.hpp"
#include "watersky/io/detail/photos.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/lsf_log.hpp"
#include "watersky/wire/gzip.hpp"

namespace watersky::detail {

namespace fs = std::filesystem;

namespace {

enum class LogKind { Tlog, Dataflash, Lsf };

std::optional<LogKind> log_kind(const fs::path& file) {
  const std::string extension = lower_extension(file);
  if (extension == ".tlog") return LogKind::Tlog;
  if (extension == ".bin") return LogKind::Dataflash;
  if (extension == ".lsf") return LogKind::Lsf;
  if (extension == ".gz" && lower_extension(file.stem()) == ".lsf") return LogKind::Lsf;
  return std::nullopt;
}

bool begins_as_dataflash(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return in.get() == 0xA3 && in.get() == 0x95;
}

/// Unpacked they are at most this long: a day of a busy DUNE is a tenth of it.
constexpr std::size_t kMaxLsfBytes = std::size_t{1} << 30;

Result<Gunzipped> read_unpacked(const fs::path& file, std::size_t max_bytes) {
  WATERSKY_TRY(auto bytes, read_bytes(file, max_bytes));
  if (!is_gzip(bytes)) return Gunzipped{std::move(bytes), true, 0};
  auto unpacked = gunzip(bytes, max_bytes);
  if (!unpacked) return unpacked.error().at(file.string());
  return unpacked;
}

Result<AutopilotLog> read_lsf(const fs::path& file) {
  WATERSKY_TRY(const LsfFile lsf, read_lsf_file(file));
  WATERSKY_TRY(AutopilotLog log, parse_lsf(lsf.bytes, lsf.schema(), file.filename().string()));
  log.notes.insert(log.notes.end(), lsf.notes.begin(), lsf.notes.end());
  return log;
}

}  // namespace

bool is_log_file(const fs::path& file) { return log_kind(file).has_value(); }

Result<std::vector<fs::path>> list_logs(const fs::path& folder) {
  WATERSKY_TRY(auto files, files_with_extension(folder, {".tlog", ".bin", ".lsf", ".gz"}));
  std::erase_if(files, [](const fs::path& file) {
    const auto kind = log_kind(file);
    return !kind || (kind == LogKind::Dataflash && !begins_as_dataflash(file));
  });
  return files;
}

Result<LsfFile> read_lsf_file(const fs::path& file) {
  LsfFile out;
  WATERSKY_TRY(Gunzipped log, read_unpacked(file, kMaxLsfBytes));
  out.bytes = std::move(log.bytes);
  const std::string name = file.filename().string();
  if (!log.whole)
    out.notes.push_back(name + ": its gzip ends or is damaged at byte " +
                        std::to_string(log.stopped_at) + "; what stands before that was read");
  for (const char* xml : {"IMC.xml", "IMC.xml.gz"}) {
    const fs::path schema_file = file.parent_path() / xml;
    std::error_code ec;
    if (!fs::is_regular_file(schema_file, ec)) continue;
    constexpr std::size_t kMaxXmlBytes = std::size_t{64} << 20;
    auto text = read_unpacked(schema_file, kMaxXmlBytes);
    auto schema = text ? imc::Schema::from_xml({reinterpret_cast<const char*>(text->bytes.data()),
                                                text->bytes.size()})
                       : Result<imc::Schema>(text.error());
    if (schema) {
      out.own_schema = std::move(*schema);
      break;
    }
    out.notes.push_back(name + ": read by the schema that we know, as the " + xml +
                        " beside it could not be: " + schema.error().message);
  }
  return out;
}

Result<AutopilotLog> read_log(const fs::path& log_file, const Progress& progress) {
  const auto kind = log_kind(log_file);
  if (!kind)
    return Error{ErrorCode::Unsupported,
                 log_file.string() + ": is no log that is read; give a " + kLogKinds};
  report(progress, "reading the log", 0, 1);
  const std::string name = log_file.filename().string();
  std::optional<AutopilotLog> log;
  if (*kind == LogKind::Lsf) {
    WATERSKY_TRY(log, read_lsf(log_file));
  } else {
    WATERSKY_TRY(const auto bytes, read_bytes(log_file));
    WATERSKY_TRY(log,
                 *kind == LogKind::Tlog ? parse_tlog(bytes, name) : parse_dataflash(bytes, name));
  }
  report(progress, "reading the log", 1, 1);
  return std::move(*log);
}

Result<RecordedFlight> flight_by_log(const fs::path& recording, const fs::path& log_file,
                                     AutopilotLog log, Intrinsics intrinsics,
                                     std::vector<ImageFrame> frames, const ReadOptions& options,
                                     std::vector<std::string> notes) {
  const PositionSample& first = log.positions.front();
  WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(first.latitude, first.longitude));
  const double datum_geoid_m = log.home_height_geoid_m.value_or(first.height_geoid_m);
  Flight flight(resolved(recording).filename().string(),
                Datum({first.latitude, first.longitude, datum_geoid_m + geoid_m}),
                std::move(intrinsics.camera));
  flight.calibration = intrinsics.source;
  flight.delay_s = options.delay_s;
  WATERSKY_TRY(flight.trajectory, make_trajectory(log, flight.datum));
  if (flight.trajectory.empty())
    return Error{
        ErrorCode::NotFound,
        log_file.string() + ": attitude and position never overlap in time, so there is no pose"};

  flight.ranges = std::move(log.ranges);

  if (!log.gimbal.empty()) {
    flight.gimbal_reference = GimbalReference::NorthEastDown;
    WATERSKY_TRY(flight.gimbal, RotationTrack::make(std::move(log.gimbal)));
    flight.mount.rotation = camera_rotation(options.mount.value_or(YawPitchRoll{}));
    if (options.mount) notes.emplace_back(kMountOnGimbalNote);
    notes.emplace_back("the log's gimbal attitude stands between body and camera");
  } else {
    flight.mount.rotation =
        camera_rotation(options.mount.value_or(YawPitchRoll{{}, Angle::degrees(-90), {}}));
    flight.mount.assumed = !options.mount;
    if (flight.mount.assumed) notes.emplace_back(kAssumedMountNote);
  }

  if (options.delay_s)
    for (ImageFrame& frame : frames) std::swap(frame.captured_at, frame.received_at);
  std::stable_sort(frames.begin(), frames.end(), [](const ImageFrame& a, const ImageFrame& b) {
    return std::max(a.captured_at, a.received_at) < std::max(b.captured_at, b.received_at);
  });
  flight.frames = std::move(frames);
  flight.notes = std::move(notes);
  std::optional<TakeOff> takeoff;
  if (log.home_height_geoid_m) takeoff = TakeOff{*log.home_height_geoid_m, true};
  return RecordedFlight{std::move(flight), takeoff};
}

}  // namespace watersky::detail
