// SPDX-License-Identifier: MIT
/// `watersky convert A B`: a flight in another form.
#include <map>

#include "cli.hpp"
#include "flight_options.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/io/log_flight_write.hpp"
#include "watersky/io/recording_write.hpp"

namespace watersky::cli {

namespace {

struct Options {
  FlightOptions flight;
  std::string out;
  std::string log;  ///< a key of kLogFormats; empty: no log is wanted
  bool jpeg = false;
  int jpeg_quality = WriteRecordingOptions{}.jpeg_quality;
  bool overwrite = false;
};

const std::map<std::string, LogFormat> kLogFormats{
    {"tlog", LogFormat::Tlog}, {"bin", LogFormat::DataFlash}, {"lsf", LogFormat::Lsf}};

/// A folder is replaced only where it is a flight folder, a file only by one of its kind.
Status check_output(const Options& o) {
  std::error_code ec;
  const std::filesystem::path out = o.out;
  if (!std::filesystem::exists(std::filesystem::symlink_status(out, ec))) return {};
  if (resolved(out) == resolved(o.flight.flight))
    return Error{ErrorCode::Usage, o.out + ": is what is to be converted; give another name"};
  if (!o.overwrite)
    return Error{ErrorCode::Exists, o.out +
                                        ": is already there; give another name, or "
                                        "--overwrite to replace an earlier conversion"};
  const bool folder = std::filesystem::is_directory(out, ec);
  const bool file_wanted =
      o.log.empty() && (lower_extension(out) == ".mcap" || lower_extension(out) == ".bag");
  const char* made_by_us = o.log.empty() ? "flight.yaml" : "camera.yaml";
  if (folder == file_wanted || (folder && !std::filesystem::exists(out / made_by_us, ec)))
    return Error{ErrorCode::Exists, o.out + ": is already there and no " +
                                        (file_wanted ? "file" : "flight folder") +
                                        ", so it is not replaced; give another name"};
  return {};
}

VerbResult run(const Options& o, const Common& common) {
  WATERSKY_CHECK(check_output(o));
  const Progress progress = progress_bar(common);
  WATERSKY_TRY(const ReadOptions read, read_options(o.flight));
  WATERSKY_TRY(const Flight flight, read_flight(o.flight.flight, read, progress));
  // There is no report that would tell them: damage would go unseen.
  for (const std::string& note : flight.notes) say(common, note);
  if (flight.frames.empty() && flight.trajectory.poses().empty())
    return Error{ErrorCode::NotFound,
                 o.flight.flight +
                     ": holds neither frames nor poses, so nothing was written; watersky inspect "
                     "tells what is in it"};

  const std::string extension = lower_extension(o.out);
  const WriteRecordingOptions write{
      .jpeg = o.jpeg, .jpeg_quality = o.jpeg_quality, .replace = o.overwrite};
  const char* kind = "flight_folder";
  std::vector<LeftOut> left_out;
  if (!o.log.empty()) {
    kind = "photographs_with_log";
    WATERSKY_TRY(WrittenLogFlight written,
                 write_log_flight(flight, o.out, kLogFormats.at(o.log), write, progress));
    left_out = std::move(written.left_out);
    std::string told;
    for (const std::string& option : written.options) told += " " + option;
    if (!told.empty()) warn(common, "a log does not say: give" + told + " when you map it");
  } else if (extension == ".mcap") {
    kind = "mcap";
    WATERSKY_TRY(left_out, write_mcap_flight(flight, o.out, write, progress));
  } else if (extension == ".bag") {
    kind = "rosbag";
    WATERSKY_TRY(left_out, write_bag_flight(flight, o.out, write, progress));
    warn(common,
         "watersky convert: a bag says neither where the sea is nor how uncertain poses "
         "are; give --sea-level when you map it");
  } else {
    WriteFlightOptions folder;
    folder.images = StoredImages::Keep;
    folder.keep_as_png = !o.jpeg;
    folder.jpeg_quality = o.jpeg_quality;
    folder.replace = o.overwrite;
    WATERSKY_TRY(left_out, write_flight_folder(flight, o.out, folder, progress));
  }
  nlohmann::json skipped = nlohmann::json::array();
  for (const LeftOut& l : left_out) {
    warn(common, l.file + ": left out, " + l.reason);
    skipped.push_back({{"file", l.file}, {"reason", l.reason}});
  }
  const std::size_t frames = flight.frames.size() - left_out.size();
  if (frames == 0 && !flight.frames.empty()) fail_in_part();
  say(common, "Converted " + std::to_string(frames) + " frames and " +
                  std::to_string(flight.trajectory.poses().size()) + " poses: " + o.out);
  return nlohmann::json{{"out", o.out},
                        {"kind", kind},
                        {"frames", frames},
                        {"poses", flight.trajectory.poses().size()},
                        {"left_out", std::move(skipped)},
                        {"notes", flight.notes}};
}

}  // namespace

void add_convert(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App& verb =
      add_verb(app, "convert",
               "Write a flight as a flight folder, an MCAP file (.mcap) or a ROS 1 bag (.bag)",
               [o](const Common& common) { return run(*o, common); });
  add_flight_options(verb, o->flight);
  verb.add_option(
          "OUT", o->out,
          "what to make: NAME.mcap loses nothing and Foxglove shows it; NAME.bag holds what "
          "ROS has messages for; any other name is a flight folder")
      ->required();
  verb.add_option("--as-log", o->log,
                  "OUT becomes a folder of photographs with an autopilot's log beside them: "
                  "MAVLink telemetry, ArduPilot's DataFlash, DUNE's LSF")
      ->check(CLI::IsMember(kLogFormats));
  verb.add_flag("--jpeg", o->jpeg,
                "images that are no files yet (of a video) as JPEG; else PNG, which loses nothing");
  verb.add_option("--jpeg-quality", o->jpeg_quality, "of those [1 to 100]")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  verb.add_flag("--overwrite", o->overwrite, "replace OUT if it is a flight of the same form");
}

}  // namespace watersky::cli
