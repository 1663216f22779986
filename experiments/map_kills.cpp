// SPDX-License-Identifier: MIT
/// kill -9 while frames stream into a live map at 30 Hz: what is lost, and whether what is found is
/// a map that was. The page cache outlives a kill; what a power cut takes is the test power_cut's.
///
///   map_kills [KILLS [FOLDER]]     20 by default, in a folder under the temporary one; about a
///                                  second each
#include <cstdio>
#include <cstdlib>
#include <string>

#include "support/killed_flight.hpp"
#include "support/print_figure.hpp"
#include "support/temporary_folder.hpp"

int main(int argc, char** argv) {
  using namespace watersky;
  const int kills = argc > 1 ? std::atoi(argv[1]) : 20;
  if (kills < 1 || argc > 3) {
    std::fprintf(stderr, "usage: map_kills [KILLS [FOLDER]]    20 kills; about 0.8 s each\n");
    return 2;
  }
  const test::TemporaryFolder temporary;
  const std::filesystem::path folder =
      argc > 2 ? std::filesystem::path(argv[2]) : temporary.path() / "live";
  const test::KillFigures figures = test::kill_flights(folder, kills, 2.0, 1);
  study::print_figure("map_kills.kills", figures.kills);
  study::print_figure("map_kills.corrupt", figures.corrupt);
  study::print_figure("map_kills.most_lost_s", figures.most_lost_s, "s");
  study::print_figure("map_kills.most_open_s", figures.most_open_s, "s");
  study::print_figure("map_kills.frames", static_cast<double>(figures.frames));
  study::print_figure("map_kills.restarts_from_a_snapshot", figures.snapshots);
  return figures.corrupt == 0 ? 0 : 1;
}
