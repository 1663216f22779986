// SPDX-License-Identifier: MIT
/// `watersky map FLIGHT -o OUT`: the main job.
#include <opencv2/core/utility.hpp>
#include <thread>

#include "cli.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/polygons.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/products/products.hpp"
#include "watersky/products/run_json.hpp"
#include "watersky/vision/mask.hpp"

namespace watersky::cli {

namespace {

struct Options {
  std::string flight, out, camera_file, mount, log, sea_level, projection, name_pattern,
      video_start;
  SegmentationChoice segmentation;
  std::optional<double> focal_px;
  double video_frame_interval_s = ReadOptions{}.video_frame_interval_s;
  std::vector<std::string> masks;
  std::optional<double> delay_s;
  std::optional<double> camera_utc_offset_h;
  bool assume_nadir = false;
  bool overwrite = false;
  bool no_align = false;
  int threads = 0;
  MappingParameters parameters;
};

Result<ReadOptions> read_options(const Options& o) {
  ReadOptions read;
  if (!o.camera_file.empty()) read.camera_file = o.camera_file;
  read.focal_px = o.focal_px;
  if (!o.mount.empty()) {
    WATERSKY_TRY(read.mount, parse_mount_option(o.mount));
  }
  if (!o.log.empty()) read.log = o.log;
  if (!o.sea_level.empty()) {
    WATERSKY_TRY(read.sea_level, parse_sea_level_option(o.sea_level));
  }
  if (!o.name_pattern.empty()) read.name_pattern = o.name_pattern;
  if (!o.video_start.empty()) {
    WATERSKY_TRY(read.video_start, parse_video_start_option(o.video_start));
  }
  read.video_frame_interval_s = o.video_frame_interval_s;
  read.delay_s = o.delay_s;
  read.camera_utc_offset_h = o.camera_utc_offset_h;
  read.assume_nadir = o.assume_nadir;
  return read;
}

/// Images are masks of the camera's picture, other files polygons of the world.
Status read_masks(const Options& o, MappingOptions& options) {
  for (const std::string& file : o.masks) {
    if (is_polygon_file(file)) {
      WATERSKY_TRY(const auto polygons, read_polygons(file));
      options.excluded.insert(options.excluded.end(), polygons.begin(), polygons.end());
      continue;
    }
    if (!is_image_file(file))
      return Error{ErrorCode::Usage, "--mask: " + file +
                                         ": give an image of the camera's size (PNG), or polygons "
                                         "(GeoJSON)"};
    WATERSKY_TRY(const auto bytes, read_bytes(file));
    WATERSKY_TRY(const cv::Mat image, decode_image(bytes, {}, file));
    auto valid = valid_from_mask(image, image.size());
    if (!valid) return valid.error().at(file);
    if (!options.camera_mask.empty() && options.camera_mask.size() != valid->size())
      return Error{ErrorCode::InvalidInput, file + ": is not of the size of the mask before it"};
    options.camera_mask = both_valid(options.camera_mask, *valid);
  }
  return {};
}

VerbResult run(const Options& o, const Common& common) {
  WATERSKY_CHECK(validate(o.parameters));
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int threads = o.threads > 0 ? o.threads : cores;
  cv::setNumThreads(std::min(threads, cores));
  if (!o.projection.empty())
    if (const auto projection = Projection::from_text(o.projection); !projection)
      return Error{ErrorCode::Usage, projection.error().message};
  WATERSKY_TRY(const Segmentation chosen, resolve(o.segmentation));
  // Before any work: a map that cannot be written is an hour lost.
  const WriteOptions write{.overwrite = o.overwrite, .threads = threads};
  WATERSKY_CHECK(check_output(o.out, write));
  WATERSKY_TRY(const ReadOptions read, read_options(o));
  const Progress progress = progress_bar(common);
  WATERSKY_TRY(const Flight flight, read_flight(o.flight, read, progress));
  if (!flight.sea_level) return Error{ErrorCode::NotFound, o.flight + ": " + explain_sea_level()};

  MappingOptions options;
  options.parameters = o.parameters;
  options.method = chosen.method;
  options.ice = chosen.ice;
  options.parameters.segmentation.model = chosen.model;
  options.parameters.segmentation.learned.ponds_are_ice = chosen.ponds_are_ice;
  if (!o.projection.empty()) options.projection = o.projection;
  options.threads = threads;
  WATERSKY_CHECK(read_masks(o, options));

  auto run = map_flight(flight, options, progress);
  if (!run) return run.error().at(o.flight);
  const Products products = products_of(*run);
  WATERSKY_CHECK(write_products(products, o.out, write, progress));

  for (const LeftOut& l : run->left_out) warn(common, "left out: " + l.file + ": " + l.reason);
  for (const UsedFrame& u : run->used) {
    char text[160];
    std::snprintf(text, sizeof text, "%s: %.1f m above the sea, %.3f m a pixel, %.0f %% ice",
                  u.file.c_str(), u.height_above_sea_m, u.gsd_m, 100 * u.ice_fraction);
    say_more(common, text);
  }
  for (const std::string& note : run->notes) say(common, note);
  say(common, "Mapped " + std::to_string(run->used.size()) + " of " +
                  std::to_string(run->frames_total) + " frames of " + run->flight_name + " (" +
                  run->reference.projection.name() + ").");
  say(common, "Report: " + o.out + "/report.html");
  say(common, "Map:    " + o.out + "/probability.tif, " + o.out + "/ice.gpkg");
  return run_json(products);
}

}  // namespace

void add_map(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App& verb = add_verb(app, "map", "Make a map of the ice from a flight",
                            [o](const Common& common) { return run(*o, common); });
  verb.add_option("FLIGHT", o->flight,
                  "a flight folder, a folder of geotagged photographs, or photographs or a video "
                  "with a log")
      ->required();
  verb.add_option("-o,--out", o->out, "folder to make with the map and its report")->required();
  auto* camera =
      verb.add_option("--camera", o->camera_file, "OpenCV calibration file (YAML or XML)");
  verb.add_option(
          "--focal-px", o->focal_px,
          "focal length [px] of the full image; principal point in the middle, no distortion")
      ->check(CLI::PositiveNumber)
      ->check(finite())
      ->excludes(camera);
  verb.add_option(
      "--mount", o->mount,
      "ROLL,PITCH,YAW of the camera on the aircraft [deg]: pitch -90 looks straight "
      "down, image top forward; where a gimbal's attitude is recorded, of the camera on "
      "the gimbal");
  verb.add_option("--log", o->log, "autopilot log with the poses (.tlog)");
  verb.add_option("--sea-level", o->sea_level,
                  "height of the sea [m] above a reference: takeoff:M, geoid:M or ellipsoid:M "
                  "(takeoff:-40 is 40 m below take-off)");
  verb.add_option("--delay-s", o->delay_s,
                  "image arrival minus capture [s]; the times of photographs beside a log are then "
                  "those of their arrival")
      ->check(finite());
  verb.add_option("--camera-utc-offset-h", o->camera_utc_offset_h,
                  "what the camera's clock shows more than UTC [h], where photographs do not say "
                  "and a log must place them")
      ->check(finite());
  verb.add_option(
      "--name-pattern", o->name_pattern,
      "capture time in file names, e.g. YYYYMMDDhhmmsscc; common patterns are found by themselves");
  verb.add_option("--video-start", o->video_start,
                  "UTC of a video's first frame, as 2018-08-05T01:00:44.80Z or seconds since 1970; "
                  "else from its name or, to a "
                  "second, its creation_time");
  verb.add_option("--video-frame-interval-s", o->video_frame_interval_s,
                  "time [s] between the frames of a video that are used; 0: every frame")
      ->check(CLI::NonNegativeNumber)
      ->check(finite())
      ->capture_default_str();
  verb.add_flag("--assume-nadir", o->assume_nadir,
                "take photographs without attitude as looking straight down");
  add_segmentation(verb, o->segmentation);
  verb.add_option("--projection", o->projection,
                  "map projection such as EPSG:3413; chosen from the flight if not given");
  verb.add_option("--mask", o->masks,
                  "what is neither water nor ice: images of the camera's size, 0 where its picture "
                  "is not to be used (aircraft, bow), and polygons of the world such as GeoJSON "
                  "(land, ship)");
  verb.add_flag("--no-align", o->no_align,
                "use time, mount and poses as they are given (this version always does: it has no "
                "alignment yet)");
  verb.add_option("--threads", o->threads,
                  "threads that decode and segment; 0: as many as the machine has")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  verb.add_flag("--overwrite", o->overwrite, "replace OUT if it is a map of ours");
  add_parameters(verb, o->parameters);
}

}  // namespace watersky::cli
