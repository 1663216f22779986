// SPDX-License-Identifier: MIT
/// A map of 100 km x 100 km at 1 m, 10^10 cells of which a survey's swaths have seen a part: made
/// as a file, opened, panned over and exported, each in a process of its own, with its peak of
/// memory.
///
///   map_large [SEEN [FOLDER]]    the part seen, 0.1 by default; the file takes some 15 GB times
///   it
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <string>

#include "bench.hpp"
#include "support/map_tiles.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/products/map_products.hpp"
#include "watersky/store/map_file.hpp"

using namespace watersky;
namespace fs = std::filesystem;

namespace {

constexpr int kSide = 391;  // tiles of 256 m: 100.1 km

/// In a child, so that its peak of memory is its own.
bool phase(const std::string& name, const std::function<Status()>& body) {
  std::fflush(stdout);
  int status = 0;
  struct rusage used {};
  const double s = bench::seconds_of([&] {
    const pid_t child = ::fork();
    if (child == 0) {
      const Status done = body();
      if (!done) std::fprintf(stderr, "map_large: %s\n", done.error().message.c_str());
      ::_exit(done ? 0 : 1);
    }
    ::wait4(child, &status, 0, &used);
  });
  bench::print_figure(("map_large." + name + "_s").c_str(), s, "s");
  bench::print_figure(("map_large." + name + "_peak_mb").c_str(),
                      static_cast<double>(used.ru_maxrss) / 1024, "MB");
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

MapHeader header_1m() {
  MapHeader header = test::some_header();
  header.wkt = Projection::from_text(header.projection).value().wkt();
  header.cell_m = 1.0;
  header.anchor_easting_m = 400'128.0;
  header.anchor_northing_m = 8'800'000.0;
  return header;
}

/// Swaths one tile wide. Tiles repeat themselves, but each is packed, written and read as its own.
TileSet survey(const MapHeader& header, double seen) {
  std::vector<TileItem> kinds;
  std::mt19937 random(1);
  for (int k = 0; k < 16; ++k) {
    MapTile tile;
    for (int i = 0; i < 30; ++i)
      test::frame(tile, random, 0, 8 * i, 256, 40, (i + k) % 5 < 3 ? 900 : -900,
                  test::at_second(i));
    kinds.push_back(item_in_memory({0, 0}, 0, 1, tile));
  }
  const int apart = std::max(1, static_cast<int>(std::lround(1 / seen)));
  std::vector<TileItem> items;
  for (int r = 0; r < kSide; r += apart)
    for (int c = 0; c < kSide; ++c) {
      items.push_back(kinds[random() % kinds.size()]);
      items.back().index = {c, r};
    }
  return {header.sources, std::move(items)};
}

}  // namespace

int main(int argc, char** argv) {
  const double seen = argc > 1 ? std::atof(argv[1]) : 0.1;
  const test::TemporaryFolder temporary;
  const fs::path folder = argc > 2 ? fs::path(argv[2]) : temporary.path();
  const fs::path file = folder / "large.wsmap";
  const MapHeader header = header_1m();
  bool ok = phase("write", [&]() -> Status {
    const TileSet set = survey(header, seen);
    bench::print_figure("map_large.seen_cells", 65536.0 * static_cast<double>(set.items().size()),
                        "1");
    return write_map_file(disk(), file, header, set);
  });
  ok = ok && phase("open", [&]() -> Status {
         const auto map = MapFile::open(disk(), file);
         if (!map) return map.error();
         bench::print_figure("map_large.file_bytes", static_cast<double>(map->bytes()), "B");
         bench::print_figure("map_large.levels", map->levels(), "1");
         return {};
       });
  ok = ok && phase("pan", [&]() -> Status {
         // A screen of 2048 x 1024 cells at 200 places of each level, as a page asks for it.
         WATERSKY_TRY(const MapFile map, MapFile::open(disk(), file));
         std::mt19937 random(2);
         std::vector<double> screen_s;
         for (int level = 0; level <= map.levels(); ++level)
           for (int i = 0; i < 200; ++i) {
             const int side = std::max(1, kSide >> level);
             const int c0 = static_cast<int>(random() % static_cast<unsigned>(side));
             const int r0 = static_cast<int>(random() % static_cast<unsigned>(side));
             Status read;
             screen_s.push_back(bench::seconds_of([&] {
               for (int r = r0; r < r0 + 4 && read; ++r)
                 for (int c = c0; c < c0 + 8 && read; ++c) {
                   if (level > 0) {
                     if (const auto t = map.overview(level, {c, r}); !t) read = t.error();
                   } else if (const auto t = view_tile(map.tiles(), {c, r}, {}); !t) {
                     read = t.error();
                   }
                 }
             }));
             WATERSKY_CHECK(read);
           }
         bench::print_figure("map_large.screen_median_ms", 1e3 * bench::median(screen_s), "ms");
         bench::print_figure("map_large.screen_worst_ms",
                             1e3 * *std::max_element(screen_s.begin(), screen_s.end()), "ms");
         return {};
       });
  ok =
      ok && phase("export", [&]() -> Status {
        WATERSKY_TRY(const StoredMap map, open_map(disk(), file));
        const fs::path tif = folder / "probability.tif";
        WATERSKY_CHECK(export_probability(map, tif));
        bench::print_figure("map_large.export_bytes", static_cast<double>(fs::file_size(tif)), "B");
        return {};
      });
  return ok ? 0 : 1;
}
