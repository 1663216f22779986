// SPDX-License-Identifier: MIT
/// One frame into the map: IceMap's footprint-only update against Algorithm 1 on the whole
/// canvas, one thread, side by side. Figures: map_update.SIZE.{algorithm1_ms, ours_ms,
/// ratio_algorithm1}.
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "bench.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/map/algorithm1.hpp"
#include "watersky/map/ice_map.hpp"

using namespace watersky;

namespace {

void run(int width, int height, double height_m) {
  constexpr int kCells = 2000;
  constexpr double kCell_m = 0.25;
  Eigen::Matrix3d a;
  a << 0.9 * width, 0, 0.5 * width - 0.5, 0, 0.9 * width, 0.5 * height - 0.5, 0, 0, 1;
  const CameraModel camera = CameraModel::make(LensModel::Pinhole, width, height, a).value();
  Eigen::Matrix3d axes;
  axes << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Rigid3<World, Map> world_from_map(Eigen::Quaterniond(axes), Point<World>{{250, -250, 0}});
  Eigen::Matrix3d sea_from_grid;
  sea_from_grid << 0, -kCell_m, 250 - 0.5 * kCell_m, kCell_m, 0, -250 + 0.5 * kCell_m, 0, 0, 1;
  const Eigen::Quaterniond rotation =
      camera_rotation({Angle::degrees(23), Angle::degrees(-80), Angle::degrees(5)});
  const Rigid3<World, Camera> in_world(rotation, Point<World>{{0, 0, -height_m}});
  const Rigid3<Sea, Camera> in_sea(rotation, Point<Sea>{{0, 0, -height_m}});

  cv::Mat noise(height, width, CV_8U), segmented;
  cv::randu(noise, 0, 256);
  cv::blur(noise, noise, {15, 15});
  segmented = noise > 127;

  Algorithm1 oracle =
      Algorithm1::make(
          {.width_cells = kCells, .height_cells = kCells, .dx_m = kCell_m, .dy_m = kCell_m}, camera,
          world_from_map)
          .value();
  IceMap map = IceMap::make({.cell_m = kCell_m}).value();
  std::vector<double> theirs, ours;
  for (int i = 0; i < 15; ++i) {
    theirs.push_back(bench::seconds_of([&] { (void)oracle.update_map(segmented, in_world); }));
    ours.push_back(bench::seconds_of([&] {
      const SeaView view = SeaView::make(camera, in_sea).value();
      const GridView grid = make_grid_view(view, sea_from_grid).value();
      cv::Mat evidence(height, width, CV_32F, cv::Scalar(log_odds(0.4)));
      evidence.setTo(log_odds(0.7), segmented);
      (void)map.update(grid, evidence, Time{});
    }));
  }
  const std::string name = "map_update." + std::to_string(width) + "x" + std::to_string(height);
  bench::print_figure((name + ".algorithm1_ms").c_str(), 1e3 * bench::median(theirs), "ms");
  bench::print_figure((name + ".ours_ms").c_str(), 1e3 * bench::median(ours), "ms");
  bench::print_figure((name + ".ratio_algorithm1").c_str(),
                      bench::median(ours) / bench::median(theirs), "1");
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  run(640, 512, 150.0);
  run(1920, 1080, 150.0);
  run(4000, 3000, 150.0);
}
