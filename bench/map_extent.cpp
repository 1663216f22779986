// SPDX-License-Identifier: MIT
/// What the size of a map costs: the time of an update, and memory.
///
/// Figures: map_extent.{small_ms, large_ms, ratio}: frames of 640x512 into cells of 1 m along the
/// same flight, on a map of 1 km² and on one of 10 000 km² whose tiles are all there (152,881 of
/// them; one block of each is made, so that the index and the heap are those of a real map and
/// the memory of this machine is enough). Both maps see the same frames in turn; wanted: at most
/// 1.05. map_memory.{bytes_per_seen_cell, …_025m}: a flight of 30 Hz and 20 m/s, four lines of 2
/// km, cells of 1 m and 0.25 m, everything that the map keeps counted; wanted: at most 5.
#include <string>

#include "bench.hpp"
#include "map_bench.hpp"
#include "watersky/map/ice_map.hpp"

using namespace watersky;

namespace {

constexpr double kHeight_m = 300.0;

/// The view of a camera 10° off nadir from a place.
GridView view_from(const CameraModel& camera, double cell_m, double north_m, double east_m,
                   double heading_deg) {
  const Rigid3<Sea, Camera> pose(
      camera_rotation({Angle::degrees(heading_deg), Angle::degrees(-80), Angle::degrees(3)}),
      Point<Sea>{{0, 0, -kHeight_m}});
  // The sea's frame moves with the camera, and the grid stays.
  return make_grid_view(SeaView::make(camera, pose).value(),
                        bench::sea_from_grid(cell_m, -north_m, -east_m))
      .value();
}

void add_look(MapTile::Block& block, Time time) {
  const std::uint8_t place = block.place_of(time);
  block.looks.fill(1);
  block.seen.fill(place);
  block.evidence.fill(700);
}

void extent() {
  const CameraModel camera = bench::pinhole(640, 512);
  const cv::Mat grey = bench::floes(640, 512);
  const EvidenceTable table = threshold_evidence(127, 0.7, 0.4, 0.5);
  IceMap small = IceMap::make({.cell_m = 1.0}).value();
  IceMap large = IceMap::make({.cell_m = 1.0}).value();
  // 391 tiles of 256 m are 100 km; block 0 of a tile is not the one that is flown over.
  constexpr int kHalf = 195;
  for (int row = -kHalf; row <= kHalf; ++row)
    for (int column = -kHalf; column <= kHalf; ++column) {
      MapTile tile;
      add_look(tile.make_block(0), Time(seconds(1)));
      large.set_tile({column, row}, std::move(tile), 1);
    }
  bench::print_figure("map_extent.tiles", static_cast<double>(large.tiles().size()), "1");
  std::vector<double> on_small, on_large;
  std::int64_t frame = 0;
  for (int lap = 0; lap < 4; ++lap)
    for (int i = 0; i < 250; ++i) {
      // A square kilometre, flown in circles.
      const double t = 0.05 * i;
      const GridView view = view_from(camera, 1.0, 300 * std::sin(t), 300 * std::cos(t), 40.0 * t);
      const Time time(seconds(100) + Duration(33'000'000 * ++frame));
      const auto add = [&](IceMap& map, std::vector<double>& times) {
        const double s = bench::cpu_seconds_of(
            [&] { (void)map.update(view, Evidence::of_levels(grey, table), time); });
        if (lap > 0) times.push_back(s);  // the first lap makes the blocks
      };
      // Who comes second finds the image in the cache: in turn.
      if (i % 2 == 0) {
        add(small, on_small);
        add(large, on_large);
      } else {
        add(large, on_large);
        add(small, on_small);
      }
    }
  bench::print_figure("map_extent.small_ms", 1e3 * bench::median(on_small), "ms");
  bench::print_figure("map_extent.large_ms", 1e3 * bench::median(on_large), "ms");
  bench::print_figure("map_extent.ratio", bench::median(on_large) / bench::median(on_small), "1");
}

void memory(double cell_m, const char* name) {
  const CameraModel camera = bench::pinhole(640, 512);
  const cv::Mat grey = bench::floes(640, 512);
  const EvidenceTable table = threshold_evidence(127, 0.7, 0.4, 0.5);
  IceMap map = IceMap::make({.cell_m = cell_m}).value();
  double time_s = 0.0;
  constexpr double kStep_m = 20.0 / 30, kLine_m = 2000.0;
  for (int line = 0; line < 4; ++line)
    for (double along_m = 0; along_m < kLine_m; along_m += kStep_m) {
      time_s += 1.0 / 30;
      const double north_m = line % 2 == 0 ? along_m : kLine_m - along_m;
      (void)map.update(view_from(camera, cell_m, north_m, 220.0 * line, line % 2 == 0 ? 0 : 180),
                       Evidence::of_levels(grey, table), Time(seconds(time_s)));
    }
  std::size_t seen = 0;
  for (const auto& [index, tile] : map.tiles()) seen += tile.tile.seen_cells();
  bench::print_figure(name, static_cast<double>(map.bytes()) / static_cast<double>(seen), "B");
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  extent();
  memory(1.0, "map_memory.bytes_per_seen_cell");
  memory(0.25, "map_memory.bytes_per_seen_cell_025m");
}
