// SPDX-License-Identifier: MIT
#include "watersky/io/simulation_folder.hpp"

#include <cmath>
#include <cstdio>

#include "watersky/geodesy/projection.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/io/geotiff.hpp"

namespace watersky {

namespace {

namespace fs = std::filesystem;

/// The rectangle of grid cells around the scene, and how the scene's positions fall into it.
struct TruthGrid {
  Projection projection;
  double west_m = 0.0, north_m = 0.0, cell_m = 0.0;
  cv::Size cells;

  /// (column, row), a cell being [c, c + 1); NaN off the projection.
  [[nodiscard]] Eigen::Vector2d operator()(const sim::Sea& sea,
                                           const Eigen::Vector2d& north_east_m) const {
    const Geodetic place = sea.geodetic(north_east_m);
    const auto en = projection.forward(place.latitude, place.longitude);
    if (!en) return Eigen::Vector2d::Constant(std::nan(""));
    return {(en->x() - west_m) / cell_m, (north_m - en->y()) / cell_m};
  }
};

Result<TruthGrid> grid_around(const sim::Sea& sea, double cell_m) {
  WATERSKY_TRY(Projection projection, Projection::for_place(sea.anchor()));
  TruthGrid grid{std::move(projection), 0.0, 0.0, 1.0, {}};
  const double n = sea.extent().north_m / 2, e = sea.extent().east_m / 2;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()),
                  high = -low;
  for (const double sn : {-1.0, 1.0})
    for (const double se : {-1.0, 1.0}) {
      const Eigen::Vector2d p = grid(sea, {sn * n, se * e});
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  if (!low.allFinite() || !high.allFinite())
    return Error{ErrorCode::OutOfRange, "the scene lies outside " + grid.projection.name()};
  // Rows grew southwards from 0, so -high.y is the southern northing.
  grid.cell_m = cell_m;
  grid.west_m = std::floor(low.x() / cell_m) * cell_m;
  grid.north_m = std::ceil(-low.y() / cell_m) * cell_m;
  grid.cells = {static_cast<int>(std::ceil((high.x() - grid.west_m) / cell_m)),
                static_cast<int>(std::ceil((grid.north_m + high.y()) / cell_m))};
  constexpr int kMaxEdge = 30000;
  if (grid.cells.width > kMaxEdge || grid.cells.height > kMaxEdge)
    return Error{
        ErrorCode::Usage,
        "truth.tif would have more than 30000 cells along an edge; use larger truth cells"};
  return grid;
}

Status write_truth(const sim::Truth& truth, const fs::path& folder, double cell_m) {
  const sim::Sea& sea = truth.sea;
  WATERSKY_TRY(const TruthGrid grid, grid_around(sea, cell_m));
  const cv::Mat share =
      sim::ice_fraction(sea, grid.cells, [&](const Eigen::Vector2d& p) { return grid(sea, p); });

  // Outside the scene's rectangle nobody knows: the share of a sea that is ice all over says where.
  sim::AreaCoverage scene(grid.cells);
  const double n = sea.extent().north_m / 2, e = sea.extent().east_m / 2;
  scene.add({grid(sea, {n, -e}), grid(sea, {n, e}), grid(sea, {-n, e}), grid(sea, {-n, -e})});
  const cv::Mat inside = scene.share();
  cv::Mat raster(grid.cells, CV_8U, cv::Scalar(255));
  for (int r = 0; r < raster.rows; ++r)
    for (int c = 0; c < raster.cols; ++c)
      if (std::abs(inside.at<float>(r, c)) > 0.999F)
        raster.at<uchar>(r, c) = share.at<float>(r, c) >= 0.5F ? 1 : 0;
  WATERSKY_CHECK(
      write_geotiff(folder / "truth.tif", raster,
                    {{grid.west_m, cell_m, 0, grid.north_m, 0, -cell_m}, grid.projection.wkt()},
                    {.description = "ice 1, water 0", .unit = "1", .metadata = {}}));

  std::string csv = "id,north_m,east_m,radius_m,max_length_m,isolated\n";
  for (const sim::IceObject& object : sea.objects()) {
    const Eigen::Vector3d p = truth.world(object.centre_north_east_m).v;
    char line[160];
    std::snprintf(line, sizeof line, "%d,%.4f,%.4f,%.4f,%.4f,%d\n", object.id, p.x(), p.y(),
                  object.equivalent_radius_m, object.max_length_m, object.isolated ? 1 : 0);
    csv += line;
  }
  return write_file(folder / "objects.csv", csv);
}

/// Says that a folder is ours to replace.
constexpr const char* kMarker = "simulation.txt";

}  // namespace

Status check_simulation_output(const fs::path& out, const WriteSimulationOptions& options) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(out, error))) return {};
  if (!options.overwrite)
    return Error{ErrorCode::Exists, out.string() +
                                        ": is already there; give another name, or --overwrite to "
                                        "replace an earlier simulation"};
  if (!fs::exists(out / kMarker, error))
    return Error{ErrorCode::Exists, out.string() +
                                        ": is already there and no earlier simulation, so it is "
                                        "not replaced; give another name"};
  return {};
}

Status write_simulation(const sim::Simulation& simulation, const fs::path& out,
                        const WriteSimulationOptions& options, const Progress& progress) {
  if (!(options.truth_cell_m > 0))
    return Error{ErrorCode::Usage, "a truth cell's edge must be longer than 0 m"};
  WATERSKY_CHECK(check_simulation_output(out, options));
  std::error_code error;
  WATERSKY_TRY(PartialFolder partial, PartialFolder::beside(out));
  fs::remove(partial.path(), error);  // write_flight_folder makes it
  WATERSKY_TRY(const std::vector<LeftOut> left_out,
               write_flight_folder(simulation.flight, partial.path(), {}, progress));
  if (!left_out.empty())
    return Error{ErrorCode::Io, out.string() + ": frame " + left_out.front().file +
                                    " could not be written: " + left_out.front().reason};
  fs::create_directory(partial.path() / "truth", error);
  if (error) return Error{ErrorCode::Io, out.string() + ": " + error.message()};
  WATERSKY_CHECK(write_truth(simulation.truth, partial.path() / "truth", options.truth_cell_m));
  WATERSKY_CHECK(
      write_file(partial.path() / kMarker,
                 "Made by watersky simulate; its --overwrite may replace this folder.\n"));
  return partial.publish();
}

}  // namespace watersky
