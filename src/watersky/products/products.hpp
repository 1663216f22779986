// SPDX-License-Identifier: MIT
#pragma once
/// What comes out of a run, as files: probability.tif, looks.tif, last_seen.tif, mosaic.tif,
/// map.wsmap, ice.gpkg, icebergs.geojson, report.html and run.json, and if asked for smoothed.tif
/// and most_likely.tif. Names and contents are a contract.
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/field/smoothing.hpp"
#include "watersky/ice/concentration.hpp"
#include "watersky/ice/floe_statistics.hpp"
#include "watersky/ice/objects.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/products/alignment_run.hpp"
#include "watersky/store/stored_map.hpp"

namespace watersky {

/// A run as the writers need it: the map as rasters over the cells seen, and what follows from
/// them. All grid positions in `objects` are those of the rasters, (0, 0) the centre of the
/// north-west cell.
struct Products {
  explicit Products(Projection map_projection) : projection(std::move(map_projection)) {}

  std::string flight_name;
  Projection projection;
  std::array<double, 6> geotransform{};  ///< of the rasters, north up
  ice::Rasters rasters;
  /// P(ice) by the evidence as it lies, not softened by where the poses may be wrong: what shapes
  /// and sizes are measured on. Empty: rasters.probability is that.
  cv::Mat evidence_probability;
  cv::Mat mosaic_bgra;  ///< CV_8UC4 (fourth channel: seen), of the rasters' size; may be empty

  ice::ObjectParameters object_parameters;
  ice::Concentration concentration;
  std::vector<ice::IceObject> objects;
  ice::FloeStatistics floes;

  std::vector<UsedFrame> used;
  std::vector<LeftOut> left_out;
  std::size_t frames_total = 0;
  std::vector<std::string> notes;
  MappingOptions options;
  IcePolarity ice = IcePolarity::Brighter;
  std::string calibration;
  std::string mount;  ///< empty: not said
  std::string sea_level;
  Datum datum;
  bool times_are_utc = true;
  double mapping_wall_s = 0.0;
  /// What the flight's images said of it before it was mapped; nullptr: they were not asked.
  std::shared_ptr<const AlignmentRun> alignment;
  /// The smoothed map beside the raw one, of the rasters' size; nullptr: not asked for.
  std::shared_ptr<const field::Smoothed> smoothing;
  /// The map itself, for map.wsmap; nullptr: none is written.
  std::shared_ptr<const StoredMap> map;

  /// Of the grid, in the projection's metres.
  [[nodiscard]] double cell_m() const { return geotransform[1]; }
  /// Projection metres per metre on the ground at the middle of the map: areas and lengths are
  /// those on the ground.
  double scale = 1.0;
  [[nodiscard]] double ground_cell_m() const { return cell_m() / scale; }
  [[nodiscard]] Eigen::Vector2d easting_northing_m(const Eigen::Vector2d& grid) const {
    return {geotransform[0] + (grid.x() + 0.5) * geotransform[1],
            geotransform[3] + (grid.y() + 0.5) * geotransform[5]};
  }
};

/// The rasters of all cells seen, and the ice in them.
[[nodiscard]] Products products_of(const MapRun& run, const ice::ObjectParameters& parameters = {});

/// Adds the smoothed map to the products of the same run. The raw map, the objects and the figures
/// stay those of the evidence alone.
Status add_smoothing(Products& products, const MapRun& run,
                     const field::SmoothingParameters& parameters = {});

/// Fills `concentration`, `objects` and `floes` from the rasters.
void analyse(Products& products);

struct WriteOptions {
  bool overwrite = false;  ///< replace an earlier run of ours
  int threads = 1;
};

/// Whether write_products could start: Exists when OUT is there (and not an earlier run that
/// may be replaced), with the remedy. For asking before a long run.
Status check_output(const std::filesystem::path& out, const WriteOptions& options = {});

/// Writes everything into a folder beside `out` and renames it at the end: OUT is there and
/// whole, or not there. Io when the disk is full or refuses; then nothing is left, and an earlier
/// run stays as it was.
Status write_products(const Products& products, const std::filesystem::path& out,
                      const WriteOptions& options = {}, const Progress& progress = {});
Status write_products(const MapRun& run, const std::filesystem::path& out,
                      const WriteOptions& options = {}, const Progress& progress = {});

}  // namespace watersky
