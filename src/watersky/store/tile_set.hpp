// SPDX-License-Identifier: MIT
#pragma once
/// Maps of several flights as one set of (source, tile, version), of which the highest version of
/// each (source, tile) counts. Its union is commutative, associative and idempotent: in whatever
/// order maps arrive, how often, and whatever got lost on the way and came later, the set is the
/// same. What the set means is map_view.hpp's.
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/map/map_tile.hpp"
#include "watersky/store/map_header.hpp"
#include "watersky/store/packed_tile.hpp"

namespace watersky {

/// Where tiles lie: a file, a journal, memory.
class TileReader {
 public:
  virtual ~TileReader() = default;
  /// `place` as the item has it. Errors name file and byte.
  [[nodiscard]] virtual Result<PackedTile> packed(std::uint64_t place) const = 0;
  [[nodiscard]] virtual Result<MapTile> load(std::uint64_t place) const;
};

struct TileItem {
  TileIndex index;
  std::uint32_t source = 0;  ///< in the set's list of sources
  std::uint32_t seen_cells = 0;
  std::uint64_t version = 0;  ///< counts the changes of this tile by its source, from 1
  std::uint64_t digest = 0;   ///< PackedTile::digest
  std::shared_ptr<const TileReader> reader;
  std::uint64_t place = 0;

  [[nodiscard]] Result<PackedTile> packed() const { return reader->packed(place); }
  [[nodiscard]] Result<MapTile> load() const { return reader->load(place); }
};

class TileSet {
 public:
  TileSet() = default;
  /// Items in any order; of one (source, tile) that is there twice the higher version counts.
  TileSet(std::vector<MapSource> sources, std::vector<TileItem> items);

  /// By id.
  [[nodiscard]] const std::vector<MapSource>& sources() const { return sources_; }
  /// By tile, then by source.
  [[nodiscard]] const std::vector<TileItem>& items() const { return items_; }
  /// All sources' items of one tile.
  [[nodiscard]] std::span<const TileItem> of(const TileIndex& index) const;
  /// Each tile once, in order.
  [[nodiscard]] std::vector<TileIndex> tiles() const;

  /// The union. Tiles of one source with equal versions should be equal; if they are not, the one
  /// of the higher digest counts, so that the laws hold for whatever comes in.
  [[nodiscard]] TileSet united(const TileSet& other) const;
  /// The same set in a grid whose indices are greater by `by`.
  [[nodiscard]] TileSet shifted(const TileIndex& by) const;

  /// Same sources, tiles, versions and contents, wherever they lie.
  bool operator==(const TileSet& other) const;

 private:
  std::vector<MapSource> sources_;
  std::vector<TileItem> items_;
};

/// A tile in memory as an item.
[[nodiscard]] TileItem item_in_memory(const TileIndex& index, std::uint32_t source,
                                      std::uint64_t version, const MapTile& tile);

}  // namespace watersky
