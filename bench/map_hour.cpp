// SPDX-License-Identifier: MIT
/// An hour of 30 Hz frames (simulated time) through the mapping of a flight, and what it takes in
/// memory: 108 000 frames of 160x128 whose camera circles over a square kilometre, segmented and
/// mapped as `watersky map --no-align` does it, images made when they are asked for.
///
///   map_hour [MINUTES]   60
///
/// Figures: map_hour.frames; map_hour.rss_mb.{quarter1, …, quarter4}: resident memory after each
/// quarter of the frames; map_hour.bytes_per_frame: by how much it grew from the end of the first
/// quarter, in which the map is made, to the end of the last, a frame (the account of each frame
/// that the report lists); map_hour.fps: frames a second of wall time.
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <string>
#include <thread>

#include "bench.hpp"
#include "map_bench.hpp"
#include "watersky/base/memory.hpp"
#include "watersky/mapping/mapping.hpp"

using namespace watersky;

namespace {

constexpr double kRate_hz = 30.0, kHeight_m = 150.0, kSpeed_m_s = 20.0;

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

Result<Flight> circling_flight(std::size_t frames) {
  Flight flight("map_hour", Datum(Geodetic{Angle::degrees(78.2), Angle::degrees(15.6), 30.0}),
                bench::pinhole(160, 128));
  flight.mount.rotation = camera_rotation({{}, Angle::degrees(-90), {}});
  flight.sea_level = SeaLevel{[](const Geodetic&) { return Result<double>(30.0); }, "30 m", 0.0};
  const Time start(seconds(1.8e9));
  std::vector<StampedPose> poses;
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 16; ++i) pictures.push_back(bench::floes(160, 128));
  for (std::size_t i = 0; i < frames; ++i) {
    const double t_s = static_cast<double>(i) / kRate_hz;
    // Circles of growing and shrinking radius: all of the square is seen within minutes.
    const double radius_m = 100.0 + 350.0 * std::abs(std::sin(t_s / 300.0));
    const double turn = kSpeed_m_s * t_s / 300.0;
    const Time time = start + seconds(t_s);
    StampedPose pose;
    pose.time = time;
    const Eigen::Quaterniond heading(Eigen::AngleAxisd(turn + 1.5707963, Eigen::Vector3d::UnitZ()));
    pose.world_from_body = {
        heading, Point<World>{{radius_m * std::cos(turn), radius_m * std::sin(turn), -kHeight_m}}};
    poses.push_back(pose);
    ImageFrame frame;
    frame.name = "frame" + std::to_string(i);
    frame.captured_at = time;
    frame.load = [picture = pictures[i % pictures.size()],
                  i](const ImageRequest&) -> Result<cv::Mat> {
      cv::Mat image = picture.clone();
      // No two pictures are the same, or they would be taken for one.
      image.at<std::uint8_t>(static_cast<int>(i / 160 % 128), static_cast<int>(i % 160)) ^= 1;
      return image;
    };
    flight.frames.push_back(std::move(frame));
  }
  WATERSKY_TRY(flight.trajectory, Trajectory::make(std::move(poses)));
  return flight;
}

}  // namespace

int main(int argc, char** argv) {
  const double minutes = argc > 1 ? std::atof(argv[1]) : 60.0;
  if (!(minutes >= 1)) {
    std::fprintf(stderr, "map_hour: MINUTES is a number from 1\n");
    return 2;
  }
  keep_freed_memory();  // as the program does
  cv::setNumThreads(1);
  const auto frames = static_cast<std::size_t>(60 * minutes * kRate_hz);
  const auto flight = circling_flight(frames);
  if (!flight) {
    std::fprintf(stderr, "map_hour: %s\n", flight.error().message.c_str());
    return 1;
  }
  MappingOptions options;
  options.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::size_t quarter = 1;
  double first_mb = 0.0, last_mb = 0.0;
  const auto watch = [&](std::string_view stage, std::size_t done, std::size_t all) {
    if (stage != "mapping" || done * 4 < quarter * all || quarter > 4) return;
    last_mb = resident_mb();
    if (quarter == 1) first_mb = last_mb;
    bench::print_figure(("map_hour.rss_mb.quarter" + std::to_string(quarter++)).c_str(), last_mb,
                        "MB");
  };
  bench::print_figure("map_hour.frames", static_cast<double>(frames), "1");
  Status done;
  const double wall_s = bench::seconds_of([&] {
    const auto run = map_flight(*flight, options, watch);
    if (!run) done = run.error();
  });
  if (!done) {
    std::fprintf(stderr, "map_hour: %s\n", done.error().message.c_str());
    return 1;
  }
  bench::print_figure("map_hour.bytes_per_frame",
                      1e6 * (last_mb - first_mb) / (0.75 * static_cast<double>(frames)), "B");
  bench::print_figure("map_hour.fps", static_cast<double>(frames) / wall_s, "1/s");
}
