// SPDX-License-Identifier: MIT
#pragma once
/// What a set of tiles means: one map. Each source's cells are brought to a common time, their
/// evidence is summed and their looks are, the last look is the latest of all, and the sum is
/// clamped last.
///
/// This is the exact filter wherever no source was clamped and cells do not forget: the sum of
/// log-odds does not ask for order. Where a source was clamped its later looks counted less than
/// they said, and where cells forget each source forgot its own evidence and not the others';
/// experiments/merge_filter prints how much either is.
#include <optional>
#include <span>
#include <vector>

#include "watersky/map/log_odds.hpp"
#include "watersky/store/tile_set.hpp"

namespace watersky {

struct MapViewParameters {
  double prior = 0.5;
  double max_probability = 0.999;
  /// Cells forget by (2.21) from their source's last look until then. Both or none.
  std::optional<CellDynamics> dynamics{};
  std::optional<Time> common_time{};

  /// Where cells forget, the common time is the last look of all sources.
  [[nodiscard]] static MapViewParameters of(const MapHeader& header);
};

/// The sum of several sources' tiles of one place.
[[nodiscard]] MapTile sum_of(std::span<const MapTile> sources, const MapViewParameters& parameters);

/// The same of a set's tile; nothing was seen there: a tile without blocks.
[[nodiscard]] Result<MapTile> view_tile(const TileSet& set, const TileIndex& index,
                                        const MapViewParameters& parameters);

/// The box of all cells seen; reads the tiles at its border only. Empty when there are none.
[[nodiscard]] Result<CellBox> seen_box(const TileSet& set);

}  // namespace watersky
