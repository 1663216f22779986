// SPDX-License-Identifier: MIT
#include "watersky/io/read_flight.hpp"

#include "watersky/io/detail/logged.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/known_points_file.hpp"
#include "watersky/io/log_flight.hpp"
#include "watersky/io/message_flight.hpp"
#include "watersky/io/photo_flight.hpp"
#include "watersky/io/video.hpp"
#include "watersky/io/video_flight.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

/// --log, or the only log in the folder.
Result<std::optional<fs::path>> log_of(const fs::path& folder, const ReadOptions& options) {
  if (options.log) return options.log;
  WATERSKY_TRY(const auto logs, detail::list_logs(folder));
  if (logs.size() > 1)
    return Error{ErrorCode::InvalidInput, folder.string() + ": holds " +
                                              std::to_string(logs.size()) +
                                              " logs; say which with --log FILE"};
  return logs.empty() ? std::optional<fs::path>{} : std::optional(logs.front());
}

/// The video to read: the path itself, or the only one in a folder without photographs; nullopt
/// when there is none.
Result<std::optional<fs::path>> video_of(const fs::path& path) {
  std::error_code ec;
  if (!fs::is_directory(path, ec)) return is_video_file(path) ? std::optional(path) : std::nullopt;
  for (const fs::path& folder : {path, path / "images"}) {
    if (!fs::is_directory(folder, ec)) continue;
    WATERSKY_TRY(const auto images, list_images(folder));
    if (!images.empty()) return std::optional<fs::path>();
  }
  WATERSKY_TRY(const auto videos, list_videos(path));
  if (videos.size() > 1)
    return Error{ErrorCode::InvalidInput, path.string() + ": holds " +
                                              std::to_string(videos.size()) +
                                              " videos; a flight is one of them: give that file"};
  return videos.empty() ? std::optional<fs::path>() : std::optional(videos.front());
}

}  // namespace

Result<RecordingKind> recording_kind(const fs::path& path, const ReadOptions& options) {
  std::error_code ec;
  if (!fs::exists(path, ec))
    return Error{ErrorCode::NotFound, path.string() + ": there is no such file or folder"};
  const bool is_folder = fs::is_directory(path, ec);
  if (is_folder && fs::exists(path / "flight.yaml", ec)) return RecordingKind::FlightFolder;
  if (!is_folder && is_message_recording(path)) return RecordingKind::Messages;
  WATERSKY_TRY(const auto video, video_of(path));
  if (video) {
    WATERSKY_TRY([[maybe_unused]] const fs::path log, log_of_video(*video, options));
    return RecordingKind::VideoWithLog;
  }
  if (!is_folder) {
    if (detail::is_log_file(path))
      return Error{ErrorCode::Unsupported, path.string() +
                                               ": is a log without images; give the photographs' "
                                               "folder or the video, and the log with --log"};
    return Error{ErrorCode::Unsupported,
                 path.string() +
                     ": is neither a folder nor a recording; give a flight folder, a folder of "
                     "photographs, a video (.mp4, .mov, .mkv, .avi, .ts), an MCAP file (.mcap) or "
                     "a ROS 1 bag (.bag)"};
  }
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
    case RecordingKind::VideoWithLog: {
      WATERSKY_TRY(const auto video, video_of(path));
      WATERSKY_TRY(const fs::path log, log_of_video(*video, options));
      WATERSKY_TRY(recorded, read_video_flight(*video, log, options, progress));
      break;
    }
    case RecordingKind::Messages: {
      WATERSKY_TRY(recorded, read_message_flight(path, options, progress));
      break;
    }
  }
  if (kind == RecordingKind::Messages) {
    // Many recordings share a folder: what lies beside is not taken for this one's.
    WATERSKY_CHECK(
        read_known_points(path, options.anchors_file, options.range_file, recorded->flight));
  } else if (kind != RecordingKind::FlightFolder) {
    std::error_code ec;
    WATERSKY_CHECK(read_known_points(fs::is_directory(path, ec) ? path : path.parent_path(),
                                     options.anchors_file, options.range_file, recorded->flight));
  }
  if (options.lever_arm_m) recorded->flight.mount.lever_arm_m = *options.lever_arm_m;
  if (options.sea_level) {
    WATERSKY_TRY(recorded->flight.sea_level, make_sea_level(*options.sea_level, recorded->takeoff));
  }
  return std::move(recorded->flight);
}

}  // namespace watersky
