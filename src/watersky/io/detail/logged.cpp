// SPDX-License-Identifier: MIT
#include "watersky/io/detail/logged.hpp"

#include <algorithm>

#include "watersky/geodesy/projection.hpp"
#include "watersky/io/detail/photos.hpp"
#include "watersky/io/files.hpp"

namespace watersky::detail {

namespace fs = std::filesystem;

Result<AutopilotLog> read_log(const fs::path& log_file, const Progress& progress) {
  if (lower_extension(log_file) != ".tlog")
    return Error{ErrorCode::Unsupported,
                 log_file.string() + ": is not a .tlog, the only kind of log that is read"};
  WATERSKY_TRY(const auto bytes, read_bytes(log_file));
  report(progress, "reading the log", 0, 1);
  WATERSKY_TRY(AutopilotLog log, parse_tlog(bytes, log_file.filename().string()));
  report(progress, "reading the log", 1, 1);
  return log;
}

Result<RecordedFlight> flight_by_log(const fs::path& recording, const fs::path& log_file,
                                     AutopilotLog log, Intrinsics intrinsics,
                                     std::vector<ImageFrame> frames, const ReadOptions& options,
                                     std::vector<std::string> notes) {
  const PositionSample& first = log.positions.front();
  WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(first.latitude, first.longitude));
  Flight flight(resolved(recording).filename().string(),
                Datum({first.latitude, first.longitude, log.home_height_geoid_m + geoid_m}),
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
  return RecordedFlight{std::move(flight), TakeOff{log.home_height_geoid_m, true}};
}

}  // namespace watersky::detail
