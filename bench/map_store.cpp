// SPDX-License-Identifier: MIT
/// What a map takes on disk and how soon it is back: bytes for each seen cell of a simulated
/// flight's map (or of the map files named), packing a tile, and a restart with 10^8 cells in a
/// live map's folder, snapshot and journal, the files in the page cache as a restart after a crash
/// of the program finds them.
///
///   map_store [MAP.wsmap…]
#include <string>

#include "bench.hpp"
#include "support/map_tiles.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/sim/simulate.hpp"
#include "watersky/store/map_file.hpp"
#include "watersky/store/map_journal.hpp"
#include "watersky/store/stored_map.hpp"

using namespace watersky;
namespace fs = std::filesystem;

namespace {

bool failed(const Error& error) {
  std::fprintf(stderr, "map_store: %s\n", error.message.c_str());
  return true;
}

bool size_of(const std::string& name, const fs::path& file) {
  const auto map = MapFile::open(disk(), file);
  if (!map) return !failed(map.error());
  double seen = 0, tiles = 0;
  for (const TileItem& item : map->tiles().items()) {
    const auto packed = item.packed();
    if (!packed) return !failed(packed.error());
    seen += packed->seen_cells;
    tiles += static_cast<double>(packed->planes.size());
  }
  const std::string prefix = "map_store." + name;
  bench::print_figure((prefix + ".seen_cells").c_str(), seen, "1");
  bench::print_figure((prefix + ".bytes_a_seen_cell").c_str(),
                      static_cast<double>(map->bytes()) / seen, "B");
  bench::print_figure((prefix + ".without_overviews").c_str(), tiles / seen, "B");
  return true;
}

bool simulated(const fs::path& folder) {
  auto scenario = sim::scenario_preset("not_easy");
  if (!scenario) return !failed(scenario.error());
  const auto simulation = sim::simulate(*scenario);
  if (!simulation) return !failed(simulation.error());
  MappingOptions options;
  options.parameters.mosaic = false;
  options.threads = 1;
  for (const double cell_m : {0.5, 0.25}) {
    options.parameters.map.cell_m = cell_m;
    const auto run = map_flight(simulation->flight, options);
    if (!run) return !failed(run.error());
    MapHeader header = test::some_header();
    header.cell_m = cell_m;
    const fs::path file = folder / "simulated.wsmap";
    const TileSet tiles = tiles_of(run->map, header.sources[0], 1);
    if (const Status s = write_map_file(disk(), file, header, tiles); !s) return !failed(s.error());
    if (!size_of(cell_m == 0.5 ? "simulated_050" : "simulated_025", file)) return false;
  }
  return true;
}

/// Tiles full of evidence that is all noise: as large as a map gets.
std::vector<MapTile> full_tiles() {
  std::vector<MapTile> tiles(8);
  std::mt19937 random(1);
  for (MapTile& tile : tiles)
    for (int i = 0; i < 30; ++i)
      test::frame(tile, random, 0, 8 * i, 256, 40, i % 5 < 3 ? 700 : -700, test::at_second(i));
  return tiles;
}

bool restart(const fs::path& folder, const std::vector<MapTile>& tiles) {
  constexpr int kSide = 39;  // 39² tiles: 0.997 x 10^8 cells
  auto journal = MapJournal::open(disk(), folder, test::some_header());
  if (!journal) return !failed(journal.error());
  int n = 0;
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c)
      journal->change({c, r}, 1, tiles[static_cast<std::size_t>(n++) % tiles.size()]);
    if (const Status s = journal->commit(test::at_second(r)); !s) return !failed(s.error());
  }
  if (const Status s = journal->compact(); !s) return !failed(s.error());
  // Ten minutes of two commits a second, since the snapshot.
  for (int i = 0; i < 1200; ++i) {
    MapTile changed = tiles[static_cast<std::size_t>(i) % tiles.size()];
    std::mt19937 random(static_cast<unsigned>(i));
    test::frame(changed, random, 0, i % 100, 200, 100, 300, test::at_second(1000 + i));
    journal->change({i % kSide, i / kSide}, static_cast<std::uint64_t>(i) + 2, changed);
    if (const Status s = journal->commit(test::at_second(1000 + i)); !s) return !failed(s.error());
  }
  double bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder))
    bytes += static_cast<double>(entry.file_size());
  bench::print_figure("map_store.restart_1e8.folder_bytes", bytes, "B");
  std::vector<double> open_s, all_s;
  for (int i = 0; i < 5; ++i) {
    std::optional<Result<MapStore>> store;
    open_s.push_back(bench::seconds_of([&] { store = MapStore::open(disk(), folder); }));
    if (!*store) return !failed(store->error());
    std::vector<MapTile> map;
    all_s.push_back(bench::seconds_of([&] {
      for (const TileItem& item : (*store)->tiles().items())
        if (auto tile = item.load()) map.push_back(*std::move(tile));
    }));
    if (map.size() != static_cast<std::size_t>(kSide * kSide)) return false;
  }
  bench::print_figure("map_store.restart_1e8.open_s", bench::median(open_s), "s");
  bench::print_figure("map_store.restart_1e8.all_tiles_s", bench::median(all_s), "s");
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const test::TemporaryFolder folder;
  for (int i = 1; i < argc; ++i)
    if (!size_of(fs::path(argv[i]).stem(), argv[i])) return 1;
  if (argc > 1) return 0;
  const std::vector<MapTile> tiles = full_tiles();
  std::vector<double> pack_s, unpack_s;
  PackedTile packed;
  for (int i = 0; i < 50; ++i) {
    const MapTile& tile = tiles[static_cast<std::size_t>(i) % tiles.size()];
    pack_s.push_back(bench::seconds_of([&] { packed = pack(tile); }));
    unpack_s.push_back(bench::seconds_of([&] { (void)unpack(packed).ok(); }));
  }
  bench::print_figure("map_store.noise.bytes_a_seen_cell",
                      static_cast<double>(packed.planes.size()) / packed.seen_cells, "B");
  bench::print_figure("map_store.pack_tile_ms", 1e3 * bench::median(pack_s), "ms");
  bench::print_figure("map_store.unpack_tile_ms", 1e3 * bench::median(unpack_s), "ms");
  return simulated(folder.path()) && restart(folder.path() / "live", tiles) ? 0 : 1;
}
