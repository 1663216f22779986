// SPDX-License-Identifier: MIT
#pragma once
/// The payloads of records: tiles, overviews, the index.
#include <vector>

#include "watersky/map/map_tile.hpp"
#include "watersky/store/detail/records.hpp"
#include "watersky/store/overviews.hpp"
#include "watersky/store/packed_tile.hpp"
#include "watersky/store/tile_set.hpp"

namespace watersky::detail {

/// Tile numbers reach as far as cell numbers (±10^9) do.
inline constexpr int kFarthestTile = 1'000'000'000 / kTileCells;
inline constexpr int kMostLevel = 24;

struct TileRecord {
  TileIndex index;
  std::uint32_t source = 0;
  std::uint64_t version = 0;
  PackedTile tile{};
};
[[nodiscard]] Bytes encode_tile_record(const TileIndex& index, std::uint32_t source,
                                       std::uint64_t version, const PackedTile& tile);
/// What comes before the planes, which stay packed.
[[nodiscard]] Result<TileRecord> parse_tile_record(const Record& record);

struct OverviewRecord {
  int level = 0;
  TileIndex index;
  OverviewTile tile;
};
[[nodiscard]] Bytes encode_overview_record(int level, const TileIndex& index,
                                           const OverviewTile& tile);
[[nodiscard]] Result<OverviewRecord> parse_overview_record(const Record& record);

struct IndexEntry {
  std::uint64_t offset = 0;  ///< of the record
  std::uint32_t source = 0;
  int level = 0;  ///< 0: a tile of the map; else of an overview
  TileIndex index;
  std::uint32_t seen_cells = 0;
  std::uint64_t version = 0;
  std::uint64_t digest = 0;
};
[[nodiscard]] Bytes encode_index(const std::vector<IndexEntry>& entries);
[[nodiscard]] Result<std::vector<IndexEntry>> parse_index(const Record& record);

/// The last bytes of a map file: where its index is.
inline constexpr std::size_t kFooterBytes = 24;
[[nodiscard]] Bytes encode_footer(std::uint64_t index_offset);
/// InvalidInput when the file does not end in a footer.
[[nodiscard]] Result<std::uint64_t> read_footer(const StorageFile& file);

}  // namespace watersky::detail
