// SPDX-License-Identifier: MIT
#include "watersky/io/read_flight.hpp"

#include "watersky/io/files.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/io/log_flight.hpp"
#include "watersky/io/photo_flight.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

/// --log, or the only .tlog in the folder.
Result<std::optional<fs::path>> log_of(const fs::path& folder, const ReadOptions& options) {
  if (options.log) return options.log;
  WATERSKY_TRY(const auto logs, files_with_extension(folder, {".tlog"}));
  if (logs.size() > 1)
    return Error{ErrorCode::InvalidInput, folder.string() + ": holds " +
                                              std::to_string(logs.size()) +
                                              " logs; say which with --log FILE"};
  return logs.empty() ? std::optional<fs::path>{} : std::optional(logs.front());
}

}  // namespace

Result<RecordingKind> recording_kind(const fs::path& path, const ReadOptions& options) {
  std::error_code ec;
  if (!fs::exists(path, ec))
    return Error{ErrorCode::NotFound, path.string() + ": there is no such file or folder"};
  if (!fs::is_directory(path, ec)) {
    if (lower_extension(path) == ".tlog")
      return Error{
          ErrorCode::Unsupported,
          path.string() +
              ": is a log without images; give the folder of photographs and the log with --log"};
    return Error{
        ErrorCode::Unsupported,
        path.string() + ": is not a folder; give a flight folder or a folder of photographs"};
  }
  if (fs::exists(path / "flight.yaml", ec)) return RecordingKind::FlightFolder;
  WATERSKY_TRY(const auto log, log_of(path, options));
  return log ? RecordingKind::PhotographsWithLog : RecordingKind::Photographs;
}

Result<Flight> read_flight(const fs::path& path, const ReadOptions& options,
                           const Progress& progress) {
  WATERSKY_TRY(const RecordingKind kind, recording_kind(path, options));
  std::optional<RecordedFlight> recorded;
  switch (kind) {
    case RecordingKind::FlightFolder: {
      WATERSKY_TRY(Flight flight, read_flight_folder(path, options, progress));
      recorded.emplace(RecordedFlight{std::move(flight), std::nullopt});
      break;
    }
    case RecordingKind::PhotographsWithLog: {
      WATERSKY_TRY(const auto log, log_of(path, options));
      WATERSKY_TRY(recorded, read_log_flight(path, *log, options, progress));
      break;
    }
    case RecordingKind::Photographs: {
      WATERSKY_TRY(recorded, read_photo_flight(path, options, progress));
      break;
    }
  }
  if (options.sea_level) {
    WATERSKY_TRY(recorded->flight.sea_level, make_sea_level(*options.sea_level, recorded->takeoff));
  }
  return std::move(recorded->flight);
}

}  // namespace watersky
