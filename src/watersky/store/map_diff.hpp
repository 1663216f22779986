// SPDX-License-Identifier: MIT
#pragma once
/// What changed from one map to another.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/map/grid_view.hpp"
#include "watersky/store/stored_map.hpp"

namespace watersky {

/// What became of a cell. Ice: P(ice) above the threshold.
enum class CellChange : std::uint8_t {
  StayedWater = 0,
  StayedIce = 1,
  BecameWater = 2,
  BecameIce = 3,
  NewWater = 4,   ///< seen in the later map only
  NewIce = 5,     ///< seen in the later map only
  OnlyBefore = 6  ///< seen in the earlier map only
};
inline constexpr std::size_t kCellChanges = 7;
inline constexpr std::uint8_t kNeitherSeen = 255;
/// "became_ice".
[[nodiscard]] std::string_view name_of(CellChange change);

/// Of a tile's 256 x 256 cells, row by row; kNeitherSeen where neither map has seen the cell.
using TileChanges = std::vector<std::uint8_t>;
[[nodiscard]] TileChanges changes_of(const MapTile& before, const MapTile& after,
                                     double prior_log_odds, double ice_probability);

/// Two maps in one grid, that of the earlier.
class MapDiff {
 public:
  /// InvalidInput when the two do not share a grid and a prior, with their names.
  [[nodiscard]] static Result<MapDiff> of(const StoredMap& before, const StoredMap& after,
                                          const std::string& before_name,
                                          const std::string& after_name,
                                          double ice_probability = 0.5);

  [[nodiscard]] const MapHeader& header() const { return before_.header; }
  /// The tiles that either map has.
  [[nodiscard]] const std::vector<TileIndex>& tiles() const { return tiles_; }
  [[nodiscard]] Result<TileChanges> changes(const TileIndex& index) const;
  /// Cells of each change, one tile in memory at a time.
  using Counts = std::array<std::size_t, kCellChanges>;
  [[nodiscard]] Result<Counts> count(const Progress& progress = {}) const;
  /// Cells that either map has seen.
  [[nodiscard]] Result<CellBox> seen() const;

 private:
  MapDiff(StoredMap before, StoredMap after, double ice_probability);
  StoredMap before_, after_;
  double ice_probability_;
  std::vector<TileIndex> tiles_;
};

}  // namespace watersky
