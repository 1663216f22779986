// SPDX-License-Identifier: MIT
#pragma once
/// The options by which a verb takes a flight: what a person says about a recording that it does
/// not say itself, masks, and threads.
#include "cli.hpp"
#include "watersky/geodesy/geo_polygon.hpp"
#include "watersky/io/read_flight.hpp"

namespace watersky::cli {

struct FlightOptions {
  std::string flight, camera_file, mount, lever_arm, log, sea_level, anchors, ranges, name_pattern,
      video_start, image_topic, camera_frame, map_frame, datum;
  std::optional<double> focal_px;
  double video_frame_interval_s = ReadOptions{}.video_frame_interval_s;
  std::optional<double> delay_s;
  std::optional<double> camera_utc_offset_h;
  bool assume_nadir = false;
  std::vector<std::string> masks;
  int threads = 0;  ///< 0: as many as the machine has
};

/// FLIGHT and all that reading it may need.
void add_flight_options(CLI::App& verb, FlightOptions& options);
/// --mask, with its meaning for the verb.
void add_mask_option(CLI::App& verb, FlightOptions& options, const std::string& help);
void add_threads_option(CLI::App& verb, FlightOptions& options);

/// Usage naming the option that cannot be read.
[[nodiscard]] Result<ReadOptions> read_options(const FlightOptions& options);

/// Reads the flight. NotFound, with the choices, when it has no sea level.
[[nodiscard]] Result<Flight> read_flight_over_sea(const FlightOptions& options,
                                                  const Progress& progress);

/// What masks say: images are masks of the camera's picture, other files polygons of the world.
struct Masks {
  cv::Mat camera{};
  std::vector<GeoPolygon> excluded{};
};
[[nodiscard]] Result<Masks> read_masks(const std::vector<std::string>& files);

/// The number of threads to use; OpenCV is told it.
[[nodiscard]] int use_threads(int asked);

}  // namespace watersky::cli
