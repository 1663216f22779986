// SPDX-License-Identifier: MIT
/// What OpenCL is worth here (section 4.4 of the thesis): Algorithm 1 and the filters of the
/// methods edges and watershed on an OpenCL device against the processor, and
/// against the map's own update, which has nothing that OpenCV could run on a device. One core
/// each, alternating in one run; a device on the processor (PoCL) is held to one core as well
/// unless POCL_MAX_PTHREAD_COUNT says otherwise.
///
/// Figures: opencl.SIZE.{algorithm1,filters}.{cpu_ms, device_ms, ratio_cpu, max_difference},
/// opencl.SIZE.ours_ms, opencl.SIZE.{transfer_ms, ratio_transfer_ours}: only taking the frame to
/// the device and its footprint back, against our whole update.
///
/// Status 1 when the device disagrees with the processor by more than rounding explains, 0 and
/// a word on standard error where there is no device.
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "bench.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/map/algorithm1.hpp"
#include "watersky/map/ice_map.hpp"
#include "watersky/vision/opencl.hpp"

using namespace watersky;

namespace {

constexpr int kRuns = 15, kCells = 2000;
constexpr double kCell_m = 0.25, kHeight_m = 150.0, kSigma_px = 2.0, kPIce = 0.7, kPWater = 0.4;
/// Processor and device interpolate between 32 places a pixel and may round to neighbouring ones,
/// along each axis; a blurred edge is at most this steep.
const double kSteepest_1_px =
    (log_odds(kPIce) - log_odds(kPWater)) / (kSigma_px * std::sqrt(2 * CV_PI));
const double kUpdateBound = 2.0 / 32.0 * kSteepest_1_px;
constexpr double kFilterBound = 1e-5;

struct Scene {
  CameraModel camera;
  Rigid3<World, Map> world_from_map;
  Rigid3<World, Camera> in_world;
  Rigid3<Sea, Camera> in_sea;
  Eigen::Matrix3d sea_from_grid;
  cv::Mat segmented;
};

Scene scene(int width, int height) {
  Eigen::Matrix3d a, axes, sea_from_grid;
  a << 0.9 * width, 0, 0.5 * width - 0.5, 0, 0.9 * width, 0.5 * height - 0.5, 0, 0, 1;
  axes << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  sea_from_grid << 0, -kCell_m, 250 - 0.5 * kCell_m, kCell_m, 0, -250 + 0.5 * kCell_m, 0, 0, 1;
  const Eigen::Quaterniond rotation =
      camera_rotation({Angle::degrees(23), Angle::degrees(-80), Angle::degrees(5)});
  cv::Mat noise(height, width, CV_8U);
  cv::theRNG().state = 3;
  cv::randu(noise, 0, 256);
  cv::blur(noise, noise, {15, 15});
  return {CameraModel::make(LensModel::Pinhole, width, height, a).value(),
          Rigid3<World, Map>(Eigen::Quaterniond(axes), Point<World>{{250, -250, 0}}),
          Rigid3<World, Camera>(rotation, Point<World>{{0, 0, -kHeight_m}}),
          Rigid3<Sea, Camera>(rotation, Point<Sea>{{0, 0, -kHeight_m}}),
          sea_from_grid,
          noise > 127};
}

/// Algorithm1::update_map on the device, for a camera without distortion that sees no horizon on
/// the canvas. The map stays on the device.
class DeviceAlgorithm1 {
 public:
  DeviceAlgorithm1() : map_(kCells, kCells, CV_32F, cv::Scalar(0)) {}

  void update(const cv::Mat& segmented, const Eigen::Matrix3d& x) {
    const cv::Matx33d m(x(0, 0), x(0, 1), x(0, 2), x(1, 0), x(1, 1), x(1, 2), x(2, 0), x(2, 1),
                        x(2, 2));
    segmented.copyTo(ice_);
    evidence_.create(segmented.size(), CV_32F);
    evidence_.setTo(log_odds(kPWater));
    evidence_.setTo(log_odds(kPIce), ice_);
    // The size that Algorithm1's call chooses; left to choose it OpenCV does not use the device.
    constexpr int kSize = static_cast<int>(8 * kSigma_px + 1) | 1;
    cv::GaussianBlur(evidence_, blurred_, {kSize, kSize}, kSigma_px);
    cv::warpPerspective(blurred_, warped_, m, map_.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
    cv::add(map_, warped_, map_);
    cv::ocl::finish();
  }
  [[nodiscard]] const cv::UMat& map() const { return map_; }

 private:
  cv::UMat map_, ice_, evidence_, blurred_, warped_;
};

void print(const std::string& name, const std::vector<double>& cpu,
           const std::vector<double>& device, double max_difference) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < cpu.size(); ++i) ratios.push_back(device[i] / cpu[i]);
  bench::print_figure((name + ".cpu_ms").c_str(), 1e3 * bench::median(cpu), "ms");
  bench::print_figure((name + ".device_ms").c_str(), 1e3 * bench::median(device), "ms");
  bench::print_figure((name + ".ratio_cpu").c_str(), bench::median(ratios), "1");
  bench::print_figure((name + ".max_difference").c_str(), max_difference, "1");
}

/// Whether the device agreed.
bool run(int width, int height) {
  const std::string size = "opencl." + std::to_string(width) + "x" + std::to_string(height);
  const Scene s = scene(width, height);
  Algorithm1 oracle = Algorithm1::make({.width_cells = kCells,
                                        .height_cells = kCells,
                                        .dx_m = kCell_m,
                                        .dy_m = kCell_m,
                                        .p1 = kPIce,
                                        .p2 = kPWater,
                                        .sigma_px = kSigma_px},
                                       s.camera, s.world_from_map)
                          .value();
  DeviceAlgorithm1 device;
  IceMap map = IceMap::make({.cell_m = kCell_m}).value();
  const Eigen::Matrix3d image_from_map = oracle.perspective_transform(s.in_world);
  cv::Mat level, cpu_level, device_level, dx, dy, device_dx, device_dy, back;
  s.segmented.convertTo(level, CV_32F, 1.0 / 255.0);
  cv::UMat there;

  // Programs are compiled at their first use, which is not a frame's cost.
  device.update(s.segmented, image_from_map);
  (void)oracle.update_map(s.segmented, s.in_world);
  const double update_difference =
      cv::norm(device.map().getMat(cv::ACCESS_READ), oracle.map(), cv::NORM_INF);
  const auto filters = [&](bool opencl, cv::Mat& out, cv::Mat& along_x, cv::Mat& along_y) {
    (void)use_opencl(opencl);
    level.copyTo(out);
    smooth_and_derive(out, 1.0, 0.125, along_x, along_y);
    (void)use_opencl(true);
  };
  filters(true, device_level, device_dx, device_dy);
  std::size_t cells = 0;
  std::vector<double> update_cpu, update_device, ours, filter_cpu, filter_device, transfer, share;
  for (int i = 0; i < kRuns; ++i) {
    update_cpu.push_back(
        bench::seconds_of([&] { (void)oracle.update_map(s.segmented, s.in_world); }));
    update_device.push_back(bench::seconds_of([&] { device.update(s.segmented, image_from_map); }));
    ours.push_back(bench::seconds_of([&] {
      const SeaView view = SeaView::make(s.camera, s.in_sea).value();
      cv::Mat evidence(height, width, CV_32F, cv::Scalar(log_odds(kPWater)));
      evidence.setTo(log_odds(kPIce), s.segmented);
      cells = map.update(make_grid_view(view, s.sea_from_grid).value(), evidence, Time{}).value();
    }));
    const int edge = static_cast<int>(std::sqrt(static_cast<double>(cells)));
    transfer.push_back(bench::seconds_of([&] {
      s.segmented.copyTo(there);
      device.map()(cv::Rect(0, 0, std::min(edge, kCells), std::min(edge, kCells))).copyTo(back);
    }));
    share.push_back(transfer.back() / ours.back());
    filter_cpu.push_back(bench::seconds_of([&] { filters(false, cpu_level, dx, dy); }));
    filter_device.push_back(
        bench::seconds_of([&] { filters(true, device_level, device_dx, device_dy); }));
  }
  const double filter_difference =
      std::max({cv::norm(cpu_level, device_level, cv::NORM_INF),
                cv::norm(dx, device_dx, cv::NORM_INF), cv::norm(dy, device_dy, cv::NORM_INF)});
  print(size + ".algorithm1", update_cpu, update_device, update_difference);
  print(size + ".filters", filter_cpu, filter_device, filter_difference);
  bench::print_figure((size + ".ours_ms").c_str(), 1e3 * bench::median(ours), "ms");
  bench::print_figure((size + ".transfer_ms").c_str(), 1e3 * bench::median(transfer), "ms");
  bench::print_figure((size + ".ratio_transfer_ours").c_str(), bench::median(share), "1");
  if (update_difference <= kUpdateBound && filter_difference <= kFilterBound) return true;
  std::fprintf(stderr, "opencl: the device disagrees: %g (bound %g) and %g (bound %g)\n",
               update_difference, kUpdateBound, filter_difference, kFilterBound);
  return false;
}

}  // namespace

int main() {
  ::setenv("POCL_MAX_PTHREAD_COUNT", "1", 0);
  cv::setNumThreads(1);
  if (const Status on = use_opencl(true); !on) {
    std::fprintf(stderr, "opencl: %s\n", on.error().message.c_str());
    return 0;
  }
  std::fprintf(stderr, "opencl: %s\n", cv::ocl::Device::getDefault().name().c_str());
  const bool small = run(640, 512), large = run(4000, 3000);
  return small && large ? 0 : 1;
}
