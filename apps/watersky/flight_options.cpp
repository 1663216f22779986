// SPDX-License-Identifier: MIT
#include "flight_options.hpp"

#include <opencv2/core/utility.hpp>
#include <thread>

#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/polygons.hpp"
#include "watersky/vision/mask.hpp"

namespace watersky::cli {

void add_flight_options(CLI::App& verb, FlightOptions& o) {
  verb.add_option(
          "FLIGHT", o.flight,
          "a flight folder, a folder of geotagged photographs, photographs or a video with a "
          "log, an MCAP file or a ROS 1 bag")
      ->required();
  auto* camera =
      verb.add_option("--camera", o.camera_file, "OpenCV calibration file (YAML or XML)");
  verb.add_option(
          "--focal-px", o.focal_px,
          "focal length [px] of the full image; principal point in the middle, no distortion")
      ->check(CLI::PositiveNumber)
      ->check(finite())
      ->excludes(camera);
  verb.add_option(
      "--mount", o.mount,
      "ROLL,PITCH,YAW of the camera on the aircraft [deg]: pitch -90 looks straight "
      "down, image top forward; where a gimbal's attitude is recorded, of the camera on "
      "the gimbal");
  verb.add_option(
      "--lever-arm", o.lever_arm,
      "FORWARD,RIGHT,DOWN of the camera from where the poses are of [m], in the axes of "
      "the aircraft, or of the gimbal");
  verb.add_option("--log", o.log, "autopilot log with the poses (.tlog, .bin, .lsf, .lsf.gz)");
  verb.add_option("--sea-level", o.sea_level,
                  "height of the sea [m] above a reference: takeoff:M, geoid:M or ellipsoid:M "
                  "(takeoff:-40 is 40 m below take-off)");
  verb.add_option("--anchors", o.anchors,
                  "known points (surveyed, beacons, the ship) and the pixels where they are seen: "
                  "anchors.csv, or OpenDroneMap's gcp_list.txt; else those beside the images");
  verb.add_option("--range", o.ranges,
                  "what a range finder that looks down measured (range.csv: time_s,range_m); else "
                  "range.csv beside the images, or the log's DISTANCE_SENSOR messages");
  verb.add_option("--delay-s", o.delay_s,
                  "image arrival minus capture [s]; the times of photographs beside a log are then "
                  "those of their arrival")
      ->check(finite());
  verb.add_option("--camera-utc-offset-h", o.camera_utc_offset_h,
                  "what the camera's clock shows more than UTC [h], where photographs do not say "
                  "and a log must place them")
      ->check(finite());
  verb.add_option(
      "--name-pattern", o.name_pattern,
      "capture time in file names, e.g. YYYYMMDDhhmmsscc; common patterns are found by themselves");
  verb.add_option("--video-start", o.video_start,
                  "UTC of a video's first frame, as 2018-08-05T01:00:44.80Z or seconds since 1970; "
                  "else from its name or, to a "
                  "second, its creation_time");
  verb.add_option("--video-frame-interval-s", o.video_frame_interval_s,
                  "time [s] between the frames of a video that are used; 0: every frame")
      ->check(CLI::NonNegativeNumber)
      ->check(finite())
      ->capture_default_str();
  verb.add_option("--image-topic", o.image_topic,
                  "topic of the images in an MCAP file or bag that has several");
  verb.add_option("--camera-frame", o.camera_frame,
                  "the camera's frame in /tf; else that of the images");
  verb.add_option("--map-frame", o.map_frame,
                  "the frame in /tf that stands still (x east, y north, z up); else the top of the "
                  "camera's chain");
  verb.add_option(
      "--datum", o.datum,
      "LAT,LON,HEIGHT of the map frame's origin [deg, deg, m above the ellipsoid]; else "
      "as NavSatFix says");
  verb.add_flag("--assume-nadir", o.assume_nadir,
                "take photographs without attitude as looking straight down");
}

void add_mask_option(CLI::App& verb, FlightOptions& o, const std::string& help) {
  verb.add_option("--mask", o.masks, help);
}

void add_threads_option(CLI::App& verb, FlightOptions& o) {
  verb.add_option("--threads", o.threads,
                  "threads that decode, follow and segment; 0: as many as the machine has")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
}

Result<ReadOptions> read_options(const FlightOptions& o) {
  ReadOptions read;
  if (!o.camera_file.empty()) read.camera_file = o.camera_file;
  read.focal_px = o.focal_px;
  if (!o.mount.empty()) {
    WATERSKY_TRY(read.mount, parse_mount_option(o.mount));
  }
  if (!o.lever_arm.empty()) {
    WATERSKY_TRY(read.lever_arm_m, parse_lever_arm_option(o.lever_arm));
  }
  if (!o.log.empty()) read.log = o.log;
  if (!o.sea_level.empty()) {
    WATERSKY_TRY(read.sea_level, parse_sea_level_option(o.sea_level));
  }
  if (!o.anchors.empty()) read.anchors_file = o.anchors;
  if (!o.ranges.empty()) read.range_file = o.ranges;
  if (!o.name_pattern.empty()) read.name_pattern = o.name_pattern;
  if (!o.video_start.empty()) {
    WATERSKY_TRY(read.video_start, parse_video_start_option(o.video_start));
  }
  if (!o.image_topic.empty()) read.image_topic = o.image_topic;
  if (!o.camera_frame.empty()) read.camera_frame = o.camera_frame;
  if (!o.map_frame.empty()) read.map_frame = o.map_frame;
  if (!o.datum.empty()) {
    WATERSKY_TRY(read.datum, parse_datum_option(o.datum));
  }
  read.video_frame_interval_s = o.video_frame_interval_s;
  read.delay_s = o.delay_s;
  read.camera_utc_offset_h = o.camera_utc_offset_h;
  read.assume_nadir = o.assume_nadir;
  return read;
}

Result<Flight> read_flight_over_sea(const FlightOptions& o, const Progress& progress) {
  WATERSKY_TRY(const ReadOptions read, read_options(o));
  WATERSKY_TRY(Flight flight, read_flight(o.flight, read, progress));
  if (!flight.sea_level) return Error{ErrorCode::NotFound, o.flight + ": " + explain_sea_level()};
  return flight;
}

Result<Masks> read_masks(const std::vector<std::string>& files) {
  Masks masks;
  for (const std::string& file : files) {
    if (is_polygon_file(file)) {
      WATERSKY_TRY(const auto polygons, read_polygons(file));
      masks.excluded.insert(masks.excluded.end(), polygons.begin(), polygons.end());
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
    if (!masks.camera.empty() && masks.camera.size() != valid->size())
      return Error{ErrorCode::InvalidInput, file + ": is not of the size of the mask before it"};
    masks.camera = both_valid(masks.camera, *valid);
  }
  return masks;
}

int use_threads(int asked) {
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int threads = asked > 0 ? asked : cores;
  cv::setNumThreads(std::min(threads, cores));
  return threads;
}

}  // namespace watersky::cli
