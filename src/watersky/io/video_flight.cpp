// SPDX-License-Identifier: MIT
#include "watersky/io/video_flight.hpp"

#include <cmath>

#include "watersky/io/csv.hpp"
#include "watersky/io/detail/logged.hpp"
#include "watersky/io/detail/photos.hpp"
#include "watersky/io/name_time.hpp"
#include "watersky/io/video.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

Result<Time> start_of(const VideoInfo& info, const ReadOptions& options,
                      std::vector<std::string>& notes) {
  if (options.video_start) {
    notes.push_back("the video's start is the given " + to_iso8601(*options.video_start));
    return *options.video_start;
  }
  const std::string stem = info.path.stem().string();
  if (options.name_pattern) {
    WATERSKY_CHECK(check_name_pattern(*options.name_pattern));
    const auto time = time_from_name(stem, *options.name_pattern);
    if (!time)
      return Error{ErrorCode::Usage, "the name pattern \"" + *options.name_pattern +
                                         "\" does not fit " + info.path.filename().string()};
    notes.push_back("the video's start is " + to_iso8601(*time) + ", by the given name pattern");
    return *time;
  }
  if (const auto time = utc_from_name(stem)) {
    notes.push_back("the video's start is " + to_iso8601(*time) + ", from its name");
    return *time;
  }
  if (info.creation_time) {
    notes.push_back("the video's start is " + to_iso8601(*info.creation_time) +
                    ", the container's creation_time: good to a second at best, and some cameras "
                    "write the end or their local "
                    "time there (give --video-start when it is known better)");
    return *info.creation_time;
  }
  return Error{ErrorCode::NotFound,
               info.path.string() +
                   ": does not say when it begins, and without that the log cannot place it; give "
                   "--video-start (UTC, such as 2018-08-05T01:00:44.80Z) or a name pattern"};
}

}  // namespace

Result<fs::path> log_of_video(const fs::path& video, const ReadOptions& options) {
  if (options.log) return *options.log;
  const fs::path folder = video.has_parent_path() ? video.parent_path() : fs::path(".");
  WATERSKY_TRY(const auto logs, detail::list_logs(folder));
  for (const fs::path& log : logs)
    if (log.stem() == video.stem()) return log;
  if (logs.empty())
    return Error{ErrorCode::NotFound,
                 video.string() +
                     ": a video does not say where it was filmed, and there is no log (" +
                     detail::kLogKinds + ") beside it; give the autopilot's log with --log FILE"};
  if (logs.size() > 1)
    return Error{ErrorCode::InvalidInput, video.string() + ": beside it are " +
                                              std::to_string(logs.size()) +
                                              " logs, none of its name; say which with --log FILE"};
  return logs.front();
}

Result<RecordedFlight> read_video_flight(const fs::path& video, const fs::path& log_file,
                                         const ReadOptions& options, const Progress& progress) {
  if (!(options.video_frame_interval_s >= 0 && std::isfinite(options.video_frame_interval_s)))
    return Error{ErrorCode::Usage,
                 "the interval between a video's frames must be 0 s (every frame) or more"};
  report(progress, "reading the video's index", 0, 1);
  WATERSKY_TRY(const VideoInfo info, probe_video(video));
  report(progress, "reading the video's index", 1, 1);
  std::vector<std::string> video_notes;
  const std::string name = video.filename().string();
  WATERSKY_TRY(Intrinsics intrinsics,
               detail::choose_intrinsics(video.parent_path(), name, info.width_px, info.height_px,
                                         options, video_notes));
  WATERSKY_TRY(const Time start, start_of(info, options, video_notes));
  WATERSKY_TRY(AutopilotLog log, detail::read_log(log_file, progress));

  std::vector<ImageFrame> frames = video_frames(info, options.video_frame_interval_s, start);
  video_notes.push_back(
      std::to_string(frames.size()) + " of the video's " +
      detail::counted(info.frames.size(), "frame") +
      (options.video_frame_interval_s > 0
           ? " are taken, one every " + format_number(options.video_frame_interval_s) + " s"
           : " are taken"));
  if (info.frames_promised > info.frames.size())
    video_notes.push_back(name + " promises " + detail::counted(info.frames_promised, "frame") +
                          " and holds " + std::to_string(info.frames.size()) + ": it is cut short");
  if (info.rotation_deg != 0)
    video_notes.push_back(
        name + " is to be shown turned by " + format_number(info.rotation_deg) +
        "°; its pixels are used as they are stored, so the mount must speak of those");
  std::vector<std::string> notes = log.notes;
  notes.insert(notes.end(), video_notes.begin(), video_notes.end());
  return detail::flight_by_log(video, log_file, std::move(log), std::move(intrinsics),
                               std::move(frames), options, std::move(notes));
}

}  // namespace watersky
