// SPDX-License-Identifier: MIT
/// Frames a second and memory of the whole chain, for this machine: a simulated flight of 640x512
/// at 30 Hz (the beginning of the preset outdoor, with turns) is written as a flight folder, and
/// `watersky map` makes its map: decoding, segmentation, mapping, mosaic and all products, with
/// the flight as it was recorded, aligned as in flight, and aligned as a whole.
///
///   chain [SECONDS [THREADS [OPTION…]]]    20, all cores; options of map, e.g. --method otsu
///
/// Figures: chain.{no_align,causal,align}.{fps, cpu_ms, peak_mb}: frames over the wall time of
/// the program and processor time a frame (medians of three; the second does not mind what else
/// the machine does), and the most memory it held; chain.two_threads.ratio: wall time without
/// alignment on one thread over that on two, in turns (wanted: 1.7); chain.{decode_ms, segment_ms}:
/// of one frame, alone on one thread, by the default method (bench/map_update has the map's own
/// update).
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iterator>
#include <opencv2/core/utility.hpp>
#include <string>
#include <thread>

#include "bench.hpp"
#include "watersky/base/memory.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/io/simulation_folder.hpp"
#include "watersky/sim/simulate.hpp"
#include "watersky/vision/segmentation.hpp"

namespace fs = std::filesystem;
using namespace watersky;

namespace {

/// The preset's: its frames are stamped on arrival, and without alignment somebody must say
/// how late that is.
constexpr const char* kDelay_s = "0.25";

struct Call {
  bool ok = false;
  double wall_s = 0.0, cpu_s = 0.0, peak_mb = 0.0;
};

Call call(const fs::path& program, const std::vector<std::string>& arguments) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  Call result;
  result.wall_s = bench::seconds_of([&] {
    pid_t pid = -1;
    int status = 0;
    rusage used{};
    if (::posix_spawn(&pid, program.c_str(), nullptr, nullptr, argv.data(), environ) != 0) return;
    if (::wait4(pid, &status, 0, &used) != pid) return;
    result.ok = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    const auto seconds_in = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    result.cpu_s = seconds_in(used.ru_utime) + seconds_in(used.ru_stime);
    result.peak_mb = static_cast<double>(used.ru_maxrss) / 1024.0;
  });
  return result;
}

/// Decoding and segmentation by themselves.
Status stages(const fs::path& folder) {
  WATERSKY_TRY(const Flight flight, read_flight(folder));
  WATERSKY_TRY(const auto segmenter, make_segmenter(kDefaultSegmentationMethod));
  std::vector<cv::Mat> images;
  std::vector<double> decode, segment;
  for (std::size_t i = 0; i < flight.frames.size(); i += 20) {
    Result<cv::Mat> image = cv::Mat();
    decode.push_back(bench::seconds_of([&] { image = flight.frames[i].load({}); }));
    if (!image) return image.error();
    segmenter->observe(*image, {});
    images.push_back(*image);
  }
  for (const cv::Mat& image : images) {
    Result<cv::Mat> p_ice = cv::Mat();
    segment.push_back(bench::seconds_of([&] { p_ice = segmenter->segment(image, {}); }));
    if (!p_ice) return p_ice.error();
  }
  bench::print_figure("chain.decode_ms", 1e3 * bench::median(decode), "ms");
  bench::print_figure("chain.segment_ms", 1e3 * bench::median(segment), "ms");
  return {};
}

Status make_flight(double seconds_long, const fs::path& folder) {
  WATERSKY_TRY(sim::Scenario scenario, sim::scenario_preset("outdoor"));
  scenario.camera.frame_rate_hz = 30.0;
  scenario.camera.images_in_turns = true;
  WATERSKY_TRY(sim::Simulation simulation, sim::simulate(scenario));
  std::vector<ImageFrame>& frames = simulation.flight.frames;
  const Time first = *frames.front().received_at;
  std::erase_if(frames, [&](const ImageFrame& f) {
    return to_seconds(*f.received_at - first) > seconds_long;
  });
  return write_simulation(simulation, folder);
}

/// What `body` prints, from a process of its own: the kernel counts what this one holds as the
/// programs' that it starts.
Status apart(const std::function<Status()>& body) {
  std::fflush(stdout);
  const pid_t pid = ::fork();
  if (pid < 0) return Error{ErrorCode::Io, "no process could be started"};
  if (pid == 0) {
    const Status done = body();
    if (!done) std::fprintf(stderr, "chain: %s\n", done.error().message.c_str());
    std::fflush(stdout);
    ::_exit(done ? 0 : 1);
  }
  int status = 0;
  if (::waitpid(pid, &status, 0) != pid || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return Error{ErrorCode::InvalidInput, "the flight could not be made; why stands above"};
  return {};
}

Status run(double seconds_long, int threads, const std::vector<std::string>& options,
           const fs::path& folder) {
  const fs::path program =
      fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "watersky";
  const fs::path flight = folder / "flight", map = folder / "map";
  const auto prepare = [&] {
    const Status made = make_flight(seconds_long, flight);
    return made ? stages(flight) : made;
  };
  WATERSKY_CHECK(apart(prepare));
  const auto frames = static_cast<std::size_t>(
      std::distance(fs::directory_iterator(flight / "images"), fs::directory_iterator()));
  bench::print_figure("chain.frames", static_cast<double>(frames), "1");
  bench::print_figure("chain.threads", threads, "1");
  const std::pair<const char*, std::vector<std::string>> ways[] = {
      {"no_align", {"--no-align", "--delay-s", kDelay_s}}, {"causal", {"--causal"}}, {"align", {}}};
  for (const auto& [way, how] : ways) {
    std::vector<std::string> arguments{
        "map", flight, "-o", map, "--quiet", "--overwrite", "--threads", std::to_string(threads)};
    arguments.insert(arguments.end(), how.begin(), how.end());
    arguments.insert(arguments.end(), options.begin(), options.end());
    std::vector<double> fps, cpu_ms;
    double peak_mb = 0.0;
    for (int i = 0; i < 3; ++i) {
      const Call made = call(program, arguments);
      if (!made.ok)
        return Error{ErrorCode::InvalidInput,
                     program.string() + " map failed; its message stands above"};
      fps.push_back(static_cast<double>(frames) / made.wall_s);
      cpu_ms.push_back(1e3 * made.cpu_s / static_cast<double>(frames));
      peak_mb = std::max(peak_mb, made.peak_mb);
    }
    const std::string name = std::string("chain.") + way;
    bench::print_figure((name + ".fps").c_str(), bench::median(fps), "1/s");
    bench::print_figure((name + ".cpu_ms").c_str(), bench::median(cpu_ms), "ms");
    bench::print_figure((name + ".peak_mb").c_str(), peak_mb, "MB");
  }
  std::vector<double> one, two;
  for (int i = 0; i < 3; ++i)
    for (const auto& [count, times] : {std::pair{"1", &one}, std::pair{"2", &two}}) {
      std::vector<std::string> arguments{"map",     flight,        "-o",         map,
                                         "--quiet", "--overwrite", "--no-align", "--delay-s",
                                         kDelay_s,  "--threads",   count};
      arguments.insert(arguments.end(), options.begin(), options.end());
      const Call made = call(program, arguments);
      if (!made.ok) return Error{ErrorCode::InvalidInput, program.string() + " map failed"};
      times->push_back(made.wall_s);
    }
  bench::print_figure("chain.two_threads.ratio", bench::median(one) / bench::median(two), "1");
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds_long = argc > 1 ? std::atof(argv[1]) : 20.0;
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int threads = argc > 2 ? std::atoi(argv[2]) : cores;
  if (!(seconds_long >= 1) || threads < 1) {
    std::fprintf(stderr, "chain: SECONDS and THREADS are numbers from 1\n");
    return 2;
  }
  keep_freed_memory();  // as the program does
  cv::setNumThreads(1);
  const fs::path folder =
      fs::temp_directory_path() /
      ("watersky_bench_" +
       std::to_string(std::chrono::steady_clock::now().time_since_epoch().count()));
  fs::create_directory(folder);
  const Status done = run(seconds_long, threads,
                          std::vector<std::string>(argv + std::min(argc, 3), argv + argc), folder);
  fs::remove_all(folder);
  if (done) return 0;
  std::fprintf(stderr, "chain: %s\n", done.error().message.c_str());
  return 1;
}
