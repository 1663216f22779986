// SPDX-License-Identifier: MIT
#pragma once
/// A tile, or some of its blocks, as few bytes: its planes apart (times, low and high bytes of the
/// evidence, looks, seen), each compressed by zstd. Unsaturated evidence is mostly noise, and its
/// low bytes with it; apart from them the other planes become small.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "watersky/map/map_tile.hpp"

namespace watersky {

/// A checksum for each block of a tile; 0: nothing was seen there.
using BlockDigests = std::array<std::uint64_t, MapTile::kBlocks * MapTile::kBlocks>;

/// What a tile's content comes to: of equal tiles equal, whatever way they came.
[[nodiscard]] std::uint64_t tile_digest(const BlockDigests& blocks);

struct PackedTile {
  std::uint64_t blocks = 0;  ///< bit i: block i is in it
  std::uint64_t digest = 0;  ///< tile_digest() of the blocks in it
  std::uint32_t seen_cells = 0;
  std::vector<std::uint8_t> planes;
};

[[nodiscard]] PackedTile pack(const MapTile& tile);
/// The inverse, for bytes from anywhere: InvalidInput for what pack() would not have made.
[[nodiscard]] Result<MapTile> unpack(std::uint64_t blocks, std::uint64_t digest,
                                     std::span<const std::uint8_t> planes);
[[nodiscard]] inline Result<MapTile> unpack(const PackedTile& packed) {
  return unpack(packed.blocks, packed.digest, packed.planes);
}

/// A tile and what has changed in it since it had `before` digests: what a journal writes.
struct TileChange {
  BlockDigests digests{};                       ///< of the whole tile as it is now
  std::uint32_t seen_cells = 0;                 ///< of the whole tile
  PackedTile changed;                           ///< the blocks that differ; `blocks` 0: none
  [[nodiscard]] std::uint64_t present() const;  ///< bit i: the tile has block i
};
[[nodiscard]] TileChange change_of(const MapTile& tile, const BlockDigests& before);

}  // namespace watersky
