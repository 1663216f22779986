// SPDX-License-Identifier: MIT
#pragma once
/// A flight whose process is killed, again and again, while frames stream into its map.
///
/// Frame k is a number's doing alone, so that whoever reads the folder afterwards can say what the
/// map must hold: the map after frames 1 to k, k being what the last commit says.
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <new>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "support/map_tiles.hpp"
#include "watersky/store/journal_writer.hpp"

namespace watersky::test {

/// A map that frames are laid into.
class StreamedMap {
 public:
  static constexpr int kSide = 10;  ///< tiles

  /// 30 000 cells at a place that wanders over the map.
  void frame(std::uint64_t k) {
    const int column = static_cast<int>(k * 37 % (kSide * kTileCells - 200));
    const int row = static_cast<int>(k * 11 % (kSide * kTileCells - 150));
    const Time time = at_second(static_cast<double>(k));
    std::uint64_t noise = k * 0x9E3779B97F4A7C15;
    std::map<std::pair<TileIndex, int>, std::uint8_t> place;
    for (int r = row; r < row + 150; ++r)
      for (int c = column; c < column + 200; ++c) {
        const TileIndex index{tile_of(c), tile_of(r)};
        Tile& tile = tiles_[index];
        tile.version = k;
        const int in_column = c - index.column * kTileCells, in_row = r - index.row * kTileCells;
        const int number = MapTile::block_of(in_column, in_row);
        MapTile::Block& block = tile.tile.make_block(number);
        auto [known, asked] = place.try_emplace({index, number});
        if (asked) known->second = block.place_of(time);
        const auto cell = static_cast<std::size_t>(MapTile::cell_in_block(in_column, in_row));
        noise = noise * 6364136223846793005ULL + 1442695040888963407ULL;
        const int evidence = static_cast<int>(noise >> 54) - 400;  // -400 to 623
        block.seen[cell] = known->second;
        block.looks[cell] = static_cast<std::uint8_t>(std::min(block.looks[cell] + 1, 255));
        block.evidence[cell] =
            static_cast<std::int16_t>(std::clamp(block.evidence[cell] + evidence, -7072, 7072));
        changed_[index] = true;
      }
  }

  [[nodiscard]] std::vector<OfferedTile> take_changed() {
    std::vector<OfferedTile> out;
    for (const auto& [index, unused] : changed_)
      out.push_back({index, tiles_[index].version, tiles_[index].tile});
    changed_.clear();
    return out;
  }
  /// As the folder has it.
  Status restore(const TileSet& tiles) {
    for (const TileItem& item : tiles.items()) {
      WATERSKY_TRY(MapTile tile, item.load());
      tiles_[item.index] = {item.version, std::move(tile)};
    }
    return {};
  }
  [[nodiscard]] bool equals(const TileSet& tiles) const {
    if (tiles.items().size() != tiles_.size()) return false;
    return std::all_of(tiles.items().begin(), tiles.items().end(), [&](const TileItem& item) {
      const auto tile = item.load();
      const auto mine = tiles_.find(item.index);
      return tile && mine != tiles_.end() && *tile == mine->second.tile;
    });
  }

 private:
  struct Tile {
    std::uint64_t version = 0;
    MapTile tile;
  };
  std::map<TileIndex, Tile> tiles_;
  std::map<TileIndex, bool> changed_;
};

struct KillFigures {
  int kills = 0;
  int corrupt = 0;           ///< maps that could not be read, or are none that ever was
  double most_lost_s = 0.0;  ///< age, at the kill, of the oldest frame that was not restored
  double most_open_s = 0.0;  ///< of MapStore::open
  std::uint64_t frames = 0;
  int snapshots = 0;  ///< restarts from one
};

/// Kills the process of a flight `kills` times, each up to `most_life_s` after its start.
inline KillFigures kill_flights(const std::filesystem::path& folder, int kills, double most_life_s,
                                unsigned seed) {
  using Clock = std::chrono::steady_clock;
  constexpr std::uint64_t kRing = 4096;
  struct Shared {
    std::atomic<std::uint64_t> frames{0};
    std::array<std::atomic<std::int64_t>, kRing> at{};  ///< when frame k was in the map
  };
  void* page =
      ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return {};
  auto* shared = new (page) Shared();
  const auto now_ns = [] { return Clock::now().time_since_epoch().count(); };

  const auto fly = [&] {
    StreamedMap map;
    std::uint64_t k = 0;
    if (const auto store = MapStore::open(disk(), folder); store && store->last()) {
      k = static_cast<std::uint64_t>(std::llround(to_seconds(store->last()->time)));
      if (!map.restore(store->tiles())) ::_exit(3);
    }
    shared->frames = k;
    auto writer = JournalWriter::start(disk(), folder, some_header(), "source of flight",
                                       {.journal = {.compact_above_bytes = 4 << 20}});
    if (!writer) ::_exit(4);
    for (auto next = Clock::now();; next += std::chrono::milliseconds(33)) {
      std::this_thread::sleep_until(next);
      map.frame(++k);
      shared->at[k % kRing] = now_ns();
      shared->frames = k;
      if ((*writer)->due()) (*writer)->offer(map.take_changed(), at_second(static_cast<double>(k)));
    }
  };

  std::mt19937 random(seed);
  KillFigures figures;
  StreamedMap expected;
  std::uint64_t expected_frames = 0;
  for (; figures.kills < kills; ++figures.kills) {
    // What an earlier life did after its last commit is lost, and was counted when it was.
    shared->frames = expected_frames;
    const pid_t child = ::fork();
    if (child == 0) fly();
    std::this_thread::sleep_for(std::chrono::duration<double>(
        std::uniform_real_distribution<double>(0.02, most_life_s)(random)));
    ::kill(child, SIGKILL);
    const std::int64_t killed_at = now_ns();
    int status = 0;
    ::waitpid(child, &status, 0);
    if (!WIFSIGNALED(status)) ++figures.corrupt;  // it gave up by itself: what it found was wrong

    const auto start = Clock::now();
    const auto store = MapStore::open(disk(), folder);
    figures.most_open_s =
        std::max(figures.most_open_s, std::chrono::duration<double>(Clock::now() - start).count());
    const std::uint64_t done = shared->frames;
    const std::uint64_t restored =
        store && store->last()
            ? static_cast<std::uint64_t>(std::llround(to_seconds(store->last()->time)))
            : 0;
    if (restored < expected_frames || restored > done || (store && !store->notes().empty()) ||
        (!store && store.error().code != ErrorCode::NotFound)) {
      ++figures.corrupt;
      continue;
    }
    for (; expected_frames < restored; ++expected_frames) expected.frame(expected_frames + 1);
    if (store && !expected.equals(store->tiles())) ++figures.corrupt;
    if (restored < done)
      figures.most_lost_s =
          std::max(figures.most_lost_s,
                   1e-9 * static_cast<double>(killed_at - shared->at[(restored + 1) % kRing]));
    figures.frames = restored;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      figures.snapshots += entry.path().extension() == ".wsmap" ? 1 : 0;
  }
  ::munmap(page, sizeof(Shared));
  return figures;
}

}  // namespace watersky::test
