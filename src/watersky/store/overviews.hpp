// SPDX-License-Identifier: MIT
#pragma once
/// P(ice) at halved sizes, for display: what shows a map of any size without reading all of it.
///
/// Level 0 is the map itself. A tile of level n has 256 x 256 cells of which each is the mean of
/// the known among 2 x 2 of level n - 1; tile (c, r) of level n covers tiles (2c, 2r) to
/// (2c + 1, 2r + 1) of level n - 1, halves rounded down.
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "watersky/map/map_tile.hpp"

namespace watersky {

/// 256 x 256 cells, row by row: P(ice) in 254ths; kUnseen where nothing was seen.
struct OverviewTile {
  static constexpr std::uint8_t kUnseen = 255;
  static constexpr double kSteps = 254.0;
  static constexpr std::size_t kCells = static_cast<std::size_t>(kTileCells) * kTileCells;
  OverviewTile() { cells.fill(kUnseen); }
  std::array<std::uint8_t, kCells> cells;
  bool operator==(const OverviewTile&) const = default;
};

[[nodiscard]] constexpr int half_of(int index) {
  return index >= 0 ? index / 2 : -((-index + 1) / 2);
}
[[nodiscard]] constexpr TileIndex half_of(const TileIndex& index) {
  return {half_of(index.column), half_of(index.row)};
}

/// Level 0: the tile itself, with the prior's log-odds added to its evidence.
[[nodiscard]] OverviewTile overview_of(const MapTile& tile, double prior_log_odds);

/// Puts a tile, halved, into its quarter of the tile above it. Sums of equal remainders round to
/// even, so that levels do not drift.
void put_halved(OverviewTile& above, const TileIndex& index, const OverviewTile& tile);

/// The levels of which the last has at most four tiles.
[[nodiscard]] int overview_levels(const std::vector<TileIndex>& tiles);

/// The order in which tiles must come for their overviews to be made one tile a level at a time
/// (Morton's).
void sort_for_overviews(std::vector<TileIndex>& tiles);

/// Makes the levels of tiles that come in that order; holds one tile a level.
class OverviewStream {
 public:
  /// Called with each tile when it is whole, levels from 1 to `levels`.
  using Sink = std::function<void(int level, const TileIndex&, const OverviewTile&)>;
  OverviewStream(int levels, Sink sink)
      : open_(static_cast<std::size_t>(levels)), sink_(std::move(sink)) {}
  void add(const TileIndex& index, const OverviewTile& tile) { put(0, index, tile); }
  void finish();

 private:
  struct Open {
    TileIndex index;
    std::unique_ptr<OverviewTile> tile;
  };
  void put(std::size_t level, const TileIndex& index, const OverviewTile& tile);
  void close(std::size_t level);
  std::vector<Open> open_;  ///< [level - 1]
  Sink sink_;
};

/// The levels of a map that changes, kept in memory: a change costs its own tiles and those above
/// them, whatever the size of the map. A third of a byte for each cell of the tiles it was given.
class Overviews {
 public:
  explicit Overviews(double prior_log_odds) : prior_log_odds_(prior_log_odds) {}

  /// Says that a tile is now so; refresh() carries it upwards.
  void change(const TileIndex& index, const MapTile& tile);
  /// Brings all levels up to date. Returns the tiles that changed, for a page to fetch.
  struct Changed {
    int level = 0;
    TileIndex index;
  };
  std::vector<Changed> refresh();

  /// How many there are above level 0; valid after refresh().
  [[nodiscard]] int levels() const { return static_cast<int>(levels_.size()); }
  /// nullptr when nothing was seen there; level from 1 to levels().
  [[nodiscard]] const OverviewTile* tile(int level, const TileIndex& index) const;

 private:
  using Level = std::map<TileIndex, std::unique_ptr<OverviewTile>>;
  double prior_log_odds_;
  std::vector<Level> levels_;    ///< [level - 1]
  std::set<TileIndex> changed_;  ///< of level 1
};

}  // namespace watersky
