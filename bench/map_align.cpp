// SPDX-License-Identifier: MIT
/// What aligning a flight first costs `watersky map`: its wall time by default against --no-align,
/// all products included, one thread each, alternating in one run. The flight is the simulated
/// one of `watersky simulate`, with its defaults.
///
///   map_align [FLIGHT [OPTION…]]   another flight, with the options of map that it needs
#include <cstdlib>
#include <filesystem>
#include <string>

#include "bench.hpp"

namespace fs = std::filesystem;
using namespace watersky;

int main(int argc, char** argv) {
  const std::string program =
      fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "watersky";
  const fs::path folder =
      fs::temp_directory_path() /
      ("watersky_bench_" +
       std::to_string(std::chrono::steady_clock::now().time_since_epoch().count()));
  fs::create_directory(folder);
  const auto call = [&](const std::string& arguments) {
    const std::string command = "'" + program + "' " + arguments;
    if (std::system(command.c_str()) == 0) return true;
    std::fprintf(stderr, "map_align: failed: %s\n", command.c_str());
    return false;
  };
  const std::string flight = argc > 1 ? argv[1] : (folder / "flight").string();
  std::string options = " --threads 1 --quiet --overwrite";
  for (int i = 2; i < argc; ++i) options += " '" + std::string(argv[i]) + "'";
  bool ok = argc > 1 || call("simulate '" + flight + "' --quiet");

  const std::string map = "map '" + flight + "' -o '" + (folder / "map").string() + "'" + options;
  std::vector<double> with, without, ratio;
  for (int i = 0; ok && i < 5; ++i) {
    without.push_back(bench::seconds_of([&] { ok = call(map + " --no-align"); }));
    with.push_back(bench::seconds_of([&] { ok = ok && call(map); }));
    ratio.push_back(with.back() / without.back());
  }
  fs::remove_all(folder);
  if (!ok) return 1;
  bench::print_figure("map_align.with_s", bench::median(with), "s");
  bench::print_figure("map_align.without_s", bench::median(without), "s");
  bench::print_figure("map_align.ratio", bench::median(ratio), "1");
  return 0;
}
