// SPDX-License-Identifier: MIT
#include "watersky/products/map_products.hpp"
#include "watersky/products/products.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace watersky {

Products products_of(const MapRun& run, const ice::ObjectParameters& parameters) {
  const CellBox box = run.map.seen();
  Products p(run.reference.projection);
  p.flight_name = run.flight_name;
  p.geotransform = run.reference.geotransform(box);
  if (!run.uncertainty.empty()) p.evidence_probability = run.map.probability(box);
  p.rasters = {located_probability(run, box), run.map.looks(box), run.map.last_seen_s(box)};
  if (!run.mosaic.empty()) p.mosaic_bgra = run.mosaic.bgra(box);
  p.object_parameters = parameters;
  p.used = run.used;
  p.left_out = run.left_out;
  p.frames_total = run.frames_total;
  p.notes = run.notes;
  p.options = run.options;
  p.ice = run.ice;
  p.calibration = run.calibration;
  p.mount = run.mount;
  p.sea_level = run.sea_level;
  p.datum = run.datum;
  p.times_are_utc = run.times_are_utc;
  p.mapping_wall_s = run.wall_s;
  const Eigen::Vector2d middle = run.reference.easting_northing_m(
      box.first_column + 0.5 * box.columns, box.first_row + 0.5 * box.rows);
  if (const auto place = run.reference.projection.inverse(middle); place)
    if (const auto projected = run.reference.projection.at(*place); projected)
      p.scale = std::sqrt(std::abs(projected->grid_from_north_east.determinant()));
  p.map = std::make_shared<const StoredMap>(stored_map(run));
  analyse(p);
  return p;
}

Status add_smoothing(Products& products, const MapRun& run,
                     const field::SmoothingParameters& parameters) {
  // From the map's own log-odds: those of a P(ice) near 1 have lost digits.
  cv::Mat log_odds = run.map.log_odds(run.map.seen());
  log_odds.setTo(std::numeric_limits<float>::quiet_NaN(), products.rasters.looks == 0);
  WATERSKY_TRY(field::Smoothed smoothed, field::smooth(log_odds, parameters));
  products.smoothing = std::make_shared<const field::Smoothed>(std::move(smoothed));
  return {};
}

Status write_products(const MapRun& run, const std::filesystem::path& out,
                      const WriteOptions& options, const Progress& progress) {
  WATERSKY_CHECK(check_output(out, options));
  return write_products(products_of(run), out, options, progress);
}

}  // namespace watersky
