// SPDX-License-Identifier: MIT
#pragma once
/// What photographs and a video with an autopilot's log have in common.
#include "watersky/io/autopilot_log.hpp"
#include "watersky/io/camera_table.hpp"
#include "watersky/io/photo_flight.hpp"
#include "watersky/wire/imc_schema.hpp"

namespace watersky::detail {

/// The autopilots' logs that we read, for messages.
inline constexpr const char* kLogKinds = ".tlog, .bin (DataFlash), .lsf or .lsf.gz (DUNE)";

/// Whether the name is that of an autopilot's log. The case of its letters does not matter.
[[nodiscard]] bool is_log_file(const std::filesystem::path& file);

/// The autopilots' logs in a folder, by name. A .bin counts only when it begins as DataFlash does.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_logs(
    const std::filesystem::path& folder);

/// A DUNE log as it is read: its packets unpacked, the schema they are of, and what is to be said
/// about both.
struct LsfFile {
  std::vector<std::uint8_t> bytes;
  std::optional<imc::Schema> own_schema;  ///< of the IMC.xml beside it
  std::vector<std::string> notes;

  [[nodiscard]] const imc::Schema& schema() const {
    return own_schema ? *own_schema : imc::Schema::builtin();
  }
};
[[nodiscard]] Result<LsfFile> read_lsf_file(const std::filesystem::path& file);

/// Unsupported unless it is one of kLogKinds. Of an LSF the IMC.xml or IMC.xml.gz beside it is the
/// schema, where there is one.
[[nodiscard]] Result<AutopilotLog> read_log(const std::filesystem::path& log_file,
                                            const Progress& progress);

/// Frames, timed in captured_at, with the log's poses, gimbal and take-off. With
/// ReadOptions::delay_s their times become arrivals. The flight has the name of `recording`.
[[nodiscard]] Result<RecordedFlight> flight_by_log(const std::filesystem::path& recording,
                                                   const std::filesystem::path& log_file,
                                                   AutopilotLog log, Intrinsics intrinsics,
                                                   std::vector<ImageFrame> frames,
                                                   const ReadOptions& options,
                                                   std::vector<std::string> notes);

}  // namespace watersky::detail
