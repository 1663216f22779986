// SPDX-License-Identifier: MIT
#include "watersky/io/log_flight.hpp"

#include <algorithm>

#include "watersky/io/autopilot_log.hpp"
#include "watersky/io/detail/logged.hpp"
#include "watersky/io/detail/photos.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/name_time.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::PhotoFile;
using Times = std::vector<std::optional<Time>>;

Result<Times> times_from_names(const std::vector<PhotoFile>& photos, const std::string& pattern) {
  WATERSKY_CHECK(check_name_pattern(pattern));
  Times times;
  for (const PhotoFile& photo : photos)
    times.push_back(time_from_name(photo.path.stem().string(), pattern));
  if (std::none_of(times.begin(), times.end(), [](const auto& t) { return t.has_value(); }))
    return Error{ErrorCode::Usage, "the name pattern \"" + pattern +
                                       "\" fits no photograph; the first is named " +
                                       photos.front().path.filename().string()};
  return times;
}

/// The photographs' times by the log's camera feedback, when their count or the index range says
/// that they belong together.
std::optional<Times> times_from_feedback(const std::vector<CameraFeedback>& feedback,
                                         std::size_t photos) {
  if (feedback.empty()) return std::nullopt;
  Times times(photos);
  if (feedback.size() == photos) {
    for (std::size_t i = 0; i < photos; ++i) times[i] = feedback[i].time;
    return times;
  }
  // Telemetry drops messages: the indices tell which photographs have none.
  const int first = feedback.front().image_index;
  if (feedback.size() > photos ||
      feedback.back().image_index - first + 1 != static_cast<int>(photos))
    return std::nullopt;
  for (const CameraFeedback& f : feedback) {
    const int k = f.image_index - first;
    if (k < 0 || k >= static_cast<int>(photos)) return std::nullopt;
    times[static_cast<std::size_t>(k)] = f.time;
  }
  return times;
}

struct ImageTimes {
  Times times;
  std::string source;
  std::string missing;  ///< why a photograph has none
};

Result<ImageTimes> image_times(const std::vector<PhotoFile>& photos, const AutopilotLog& log,
                               const ReadOptions& options, std::vector<std::string>& notes) {
  if (options.name_pattern) {
    WATERSKY_TRY(Times times, times_from_names(photos, *options.name_pattern));
    return ImageTimes{std::move(times), "the given name pattern",
                      "its name does not fit the name pattern"};
  }
  if (auto times = times_from_feedback(log.feedback, photos.size()))
    return ImageTimes{std::move(*times), "the log's " + log.feedback_name,
                      "it is none of those that the log's " + log.feedback_name + " tell of"};
  if (!log.feedback.empty())
    notes.push_back("the log's " + std::to_string(log.feedback.size()) + " " + log.feedback_name +
                    " do not match the " + detail::counted(photos.size(), "photograph") +
                    " and were not used");

  Times times;
  for (const PhotoFile& photo : photos) times.push_back(utc_from_name(photo.path.stem().string()));
  if (std::all_of(times.begin(), times.end(), [](const auto& t) { return t.has_value(); }))
    return ImageTimes{std::move(times), "their names (UTC)", ""};

  times.clear();
  bool local = false;
  for (const PhotoFile& photo : photos) {
    const PhotoMetadata& m = photo.metadata;
    auto time = m.utc();
    if (!time && m.taken_local) {
      local = true;
      if (options.camera_utc_offset_h)
        time = *m.taken_local - seconds(*options.camera_utc_offset_h * 3600);
    }
    times.push_back(time);
  }
  const std::string remedy =
      local ? "its EXIF clock names no time zone (give what it shows more than UTC)"
            : "it records no time, neither in EXIF nor in its name (give a name pattern)";
  if (std::none_of(times.begin(), times.end(), [](const auto& t) { return t.has_value(); }))
    return Error{ErrorCode::NotFound,
                 photos.front().path.string() + ": " + remedy +
                     "; so do all the photographs, and without times the log cannot place them"};
  return ImageTimes{std::move(times), "EXIF", remedy};
}

}  // namespace

Result<RecordedFlight> read_log_flight(const fs::path& folder, const fs::path& log_file,
                                       const ReadOptions& options, const Progress& progress) {
  WATERSKY_TRY(AutopilotLog log, detail::read_log(log_file, progress));
  WATERSKY_TRY(detail::PhotoSet set, detail::read_photo_set(folder, progress));
  std::vector<std::string> notes = log.notes;
  WATERSKY_TRY(Intrinsics intrinsics,
               detail::choose_intrinsics(folder, set.photos.front(), options, notes));
  WATERSKY_TRY(const ImageTimes images, image_times(set.photos, log, options, notes));
  notes.push_back("image times are from " + images.source);

  const ImageSize size{intrinsics.camera.width_px(), intrinsics.camera.height_px()};
  std::vector<ImageFrame> frames;
  for (std::size_t i = 0; i < set.photos.size(); ++i) {
    const std::string name = set.photos[i].path.filename().string();
    if (!images.times[i]) {
      set.left_out.push_back({name, images.missing});
      continue;
    }
    ImageFrame frame;
    frame.name = name;
    frame.load = image_loader(set.photos[i].path, size);
    frame.file = set.photos[i].path;
    frame.captured_at = images.times[i];
    frames.push_back(std::move(frame));
  }
  WATERSKY_TRY(RecordedFlight recorded,
               detail::flight_by_log(folder, log_file, std::move(log), std::move(intrinsics),
                                     std::move(frames), options, std::move(notes)));
  recorded.flight.left_out = std::move(set.left_out);
  return recorded;
}

}  // namespace watersky
