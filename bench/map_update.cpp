// SPDX-License-Identifier: MIT
/// One frame into the map, one thread, side by side in one run; medians of processor time, and
/// their ratios.
///
/// ours: an 8-bit image and a threshold, into evidence, looks and times of the footprint's cells,
///   and where the pose leaves them (PositionUncertainty::add); the view worked out anew.
/// algorithm1: Algorithm 1 to the letter on a canvas of 2000 x 2000 cells, without blur.
/// opencv_footprint: the best that plain OpenCV does on the footprint only, in float: threshold,
///   box blur over a cell's pixels (at least 3 x 3), warp onto the footprint's rectangle, addition
///   and clamping there. No looks, no times. opencv_sharp: the same without the blur.
/// memory: the bytes that must move, evidence, looks and places of times of the cells touched read
///   and written and the image read, by the bandwidth of a STREAM triad in the same run.
///
/// Figures: map_update.SIZE.CELL.VIEW.{ours_ms, algorithm1_ms, opencv_footprint_ms,
/// opencv_sharp_ms, memory_ms, ratio_algorithm1, ratio_opencv_footprint, ratio_opencv_sharp,
/// ratio_memory}: ours by theirs. Wanted: at most 0.025, 0.125 (0.1 for 4000x3000), -, 4. And, as
/// ever, map_update.SIZE.{algorithm1_ms, ours_ms, ratio_algorithm1} of cells of 0.25 m, 10° off
/// nadir.
#include <cstdlib>
#include <cstring>
#include <string>

#include "bench.hpp"
#include "map_bench.hpp"
#include "watersky/map/algorithm1.hpp"
#include "watersky/map/ice_map.hpp"

using namespace watersky;

namespace {

constexpr int kCells = 2000;
constexpr double kHeight_m = 150.0;

/// Bytes a second of STREAM's triad, the best of a few, over arrays larger than most caches.
double stream_bytes_per_s() {
  const std::size_t n = std::size_t{8} << 20;
  std::vector<double> a(n, 1.0), b(n, 2.0), c(n, 3.0);
  double best = 0.0;
  for (int i = 0; i < 8; ++i) {
    const double s = bench::cpu_seconds_of([&] {
      for (std::size_t k = 0; k < n; ++k) a[k] = b[k] + 3.0 * c[k];
    });
    best = std::max(best, 3.0 * sizeof(double) * static_cast<double>(n) / s);
    b[static_cast<std::size_t>(i)] = a[n / 2];
  }
  return best;
}

/// Threshold, blur, warp and accumulation in float, on the rectangle of the footprint.
class OpenCvFootprint {
 public:
  OpenCvFootprint(const CameraModel& camera, const GridView& grid, int blur)
      : blur_(blur), map_(kCells, kCells, CV_32F, cv::Scalar(0)) {
    roi_ = cv::Rect(grid.box.first_column, grid.box.first_row, grid.box.columns, grid.box.rows) &
           cv::Rect(0, 0, kCells, kCells);
    Eigen::Matrix3d from_roi = Eigen::Matrix3d::Identity();
    from_roi(0, 2) = roi_.x;
    from_roi(1, 2) = roi_.y;
    const Eigen::Matrix3d x = camera.camera_matrix() * grid.camera_from_grid * from_roi;
    for (int i = 0; i < 9; ++i) image_from_roi_(i / 3, i % 3) = x(i / 3, i % 3);
  }
  void update(const cv::Mat& segmented) {
    const double below = log_odds(0.4), above = log_odds(0.7), limit = log_odds(0.999);
    segmented.convertTo(evidence_, CV_32F, (above - below) / 255, below);
    if (blur_ > 1) cv::blur(evidence_, evidence_, {blur_, blur_});
    cv::warpPerspective(evidence_, warped_, image_from_roi_, roi_.size(),
                        cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
    cv::Mat part = map_(roi_);
    part += warped_;
    cv::min(part, limit, part);
    cv::max(part, -limit, part);
  }

 private:
  int blur_;
  cv::Mat map_, evidence_, warped_;
  cv::Rect roi_;
  cv::Matx33d image_from_roi_;
};

struct Case {
  int width = 0, height = 0;
  double cell_m = 0.25;
  YawPitchRoll angles;
  std::string name;
  bool old_names = false;
};

void run(const Case& c, double bytes_per_s) {
  const CameraModel camera = bench::pinhole(c.width, c.height);
  const double half_m = 0.5 * kCells * c.cell_m;
  Eigen::Matrix3d axes;
  axes << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Rigid3<World, Map> world_from_map(Eigen::Quaterniond(axes),
                                          Point<World>{{half_m, -half_m, 0}});
  const Eigen::Matrix3d sea_from_grid = bench::sea_from_grid(c.cell_m, half_m, -half_m);
  const Eigen::Quaterniond rotation = camera_rotation(c.angles);
  const Rigid3<World, Camera> in_world(rotation, Point<World>{{0, 0, -kHeight_m}});
  const Rigid3<Sea, Camera> in_sea(rotation, Point<Sea>{{0, 0, -kHeight_m}});
  const cv::Mat grey = bench::floes(c.width, c.height);
  const EvidenceTable table = threshold_evidence(127, 0.7, 0.4, 0.5);

  const GridView grid =
      make_grid_view(SeaView::make(camera, in_sea).value(), sea_from_grid).value();
  Algorithm1 oracle =
      Algorithm1::make(
          {.width_cells = kCells, .height_cells = kCells, .dx_m = c.cell_m, .dy_m = c.cell_m},
          camera, world_from_map)
          .value();
  const int blur = std::max(3, static_cast<int>(std::lround(grid.pixels_per_cell)));
  OpenCvFootprint footprint(camera, grid, blur), sharp(camera, grid, 1);
  IceMap map = IceMap::make({.cell_m = c.cell_m}).value();
  PositionUncertainty uncertainty;
  std::vector<double> theirs, opencv, opencv_sharp, ours;
  std::size_t cells = 0;
  std::int64_t frame = 0;
  const int rounds = c.width > 2000 ? 9 : 21;
  for (int i = 0; i < rounds; ++i) {
    cv::Mat segmented;
    theirs.push_back(bench::cpu_seconds_of([&] {
      segmented = grey > 127;
      (void)oracle.update_map(segmented, in_world);
    }));
    opencv.push_back(bench::cpu_seconds_of([&] {
      segmented = grey > 127;
      footprint.update(segmented);
    }));
    opencv_sharp.push_back(bench::cpu_seconds_of([&] {
      segmented = grey > 127;
      sharp.update(segmented);
    }));
    for (int k = 0; k < 9; ++k)
      ours.push_back(bench::cpu_seconds_of([&] {
        const GridView view =
            make_grid_view(SeaView::make(camera, in_sea).value(), sea_from_grid).value();
        cells = *map.update(view, Evidence::of_levels(grey, table), Time(Duration(++frame)));
        uncertainty.add(view, bench::place_covariance(in_sea, view));
      }));
  }
  const double bytes = 8.0 * static_cast<double>(cells) + static_cast<double>(grey.total());
  const double memory_s = bytes / bytes_per_s;
  const auto print = [](const std::string& name, double value, const char* unit) {
    bench::print_figure(name.c_str(), value, unit);
  };
  const double our_s = bench::median(ours), their_s = bench::median(theirs);
  const std::string size =
      "map_update." + std::to_string(c.width) + "x" + std::to_string(c.height) + ".";
  if (c.old_names) {
    print(size + "algorithm1_ms", 1e3 * their_s, "ms");
    print(size + "ours_ms", 1e3 * our_s, "ms");
    print(size + "ratio_algorithm1", our_s / their_s, "1");
    return;
  }
  const std::string name = size + c.name + ".";
  print(name + "cells", static_cast<double>(cells), "1");
  print(name + "ours_ms", 1e3 * our_s, "ms");
  print(name + "algorithm1_ms", 1e3 * their_s, "ms");
  print(name + "opencv_footprint_ms", 1e3 * bench::median(opencv), "ms");
  print(name + "opencv_sharp_ms", 1e3 * bench::median(opencv_sharp), "ms");
  print(name + "memory_ms", 1e3 * memory_s, "ms");
  print(name + "ratio_algorithm1", our_s / their_s, "1");
  print(name + "ratio_opencv_footprint", our_s / bench::median(opencv), "1");
  print(name + "ratio_opencv_sharp", our_s / bench::median(opencv_sharp), "1");
  print(name + "ratio_memory", our_s / memory_s, "1");
}

}  // namespace

int main() {
  cv::setNumThreads(1);
  const double bytes_per_s = stream_bytes_per_s();
  bench::print_figure("map_update.stream_gb_s", 1e-9 * bytes_per_s, "GB/s");
  const auto angles = [](double pitch_deg) {
    return YawPitchRoll{Angle::degrees(23), Angle::degrees(pitch_deg), Angle::degrees(5)};
  };
  for (const auto& [width, height] : {std::pair{640, 512}, {1920, 1080}, {4000, 3000}})
    run({width, height, 0.25, angles(-80), "", true}, bytes_per_s);
  for (const auto& [width, height] : {std::pair{640, 512}, {4000, 3000}})
    for (const auto& [cell_m, cell] : {std::pair{0.25, "025m"}, {0.5, "050m"}})
      for (const auto& [pitch_deg, view] : {std::pair{-90.0, "nadir"}, {-60.0, "oblique"}})
        run({width, height, cell_m, angles(pitch_deg), std::string(cell) + "." + view, false},
            bytes_per_s);
}
