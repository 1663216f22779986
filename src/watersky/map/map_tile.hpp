// SPDX-License-Identifier: MIT
#pragma once
/// One tile of a map: log-odds, looks and the time of the last look of each cell, in four bytes.
///
/// Cells are stored in blocks that are made when something in them is seen, so that the edge of a
/// swath costs little more than what it shows. Evidence is fixed point. A cell names its last look
/// by a place in its block's list of times: few different ones are alive in a block at once,
/// because a new look takes the old one's place.
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"

namespace watersky {

/// Position of a tile in the grid of tiles.
struct TileIndex {
  int column = 0;
  int row = 0;
  auto operator<=>(const TileIndex&) const = default;
};

struct TileHash {
  std::size_t operator()(const TileIndex& i) const {
    const auto key = static_cast<std::uint64_t>(static_cast<std::uint32_t>(i.column)) << 32U |
                     static_cast<std::uint32_t>(i.row);
    return static_cast<std::size_t>((key ^ key >> 31U) * 0x9E3779B97F4A7C15U >> 16U);
  }
};

/// Tiles have this many cells along an edge.
inline constexpr int kTileCells = 256;

[[nodiscard]] constexpr int tile_of(int cell) {
  return cell >= 0 ? cell / kTileCells : -((-cell + kTileCells - 1) / kTileCells);
}

/// Evidence, log-odds minus the prior's, is kept in whole numbers of 1/1024.
inline constexpr int kEvidenceUnits = 1024;
/// The most that a cell can hold either way: a little less than 32, which is 1 - 1e-13.
inline constexpr int kMostEvidence = std::numeric_limits<std::int16_t>::max();

class MapTile {
 public:
  static constexpr int kBlockCells = 32;  ///< along an edge
  static constexpr int kBlocks = kTileCells / kBlockCells;
  static constexpr int kCellsInBlock = kBlockCells * kBlockCells;
  static constexpr int kMostLooks = std::numeric_limits<std::uint8_t>::max();
  static constexpr std::size_t kMostTimes = 256;

  /// Cells row by row.
  struct Block {
    alignas(64) std::array<std::int16_t, kCellsInBlock> evidence{};
    alignas(64) std::array<std::uint8_t, kCellsInBlock> looks{};  ///< 0: never; stays at 255
    alignas(64) std::array<std::uint8_t, kCellsInBlock> seen{};   ///< the last look, in `times`
    std::vector<Time> times;                                      ///< ascending, each once

    /// Where `time` stands in `times`, put there when it is not. Places of other times may change:
    /// ask once a look, before writing `seen`. Where many times are alive, those within a tenth of
    /// a second become the earliest of them, and of 256 the two nearest the earlier: a cell is
    /// never said to be fresher than it is.
    [[nodiscard]] std::uint8_t place_of(Time time);
    /// Leaves out of `times` those that are no cell's last look.
    void drop_unused_times();
    /// Makes times within a tenth of a second one, the earliest.
    void join_near_times();
    bool operator==(const Block&) const = default;
  };

  MapTile() = default;
  MapTile(const MapTile& other);
  MapTile& operator=(const MapTile& other);
  MapTile(MapTile&&) = default;
  MapTile& operator=(MapTile&&) = default;
  ~MapTile() = default;

  [[nodiscard]] static constexpr int block_of(int column, int row) {
    return row / kBlockCells * kBlocks + column / kBlockCells;
  }
  [[nodiscard]] static constexpr int cell_in_block(int column, int row) {
    return row % kBlockCells * kBlockCells + column % kBlockCells;
  }

  /// nullptr where nothing was seen. `block`: 0 to kBlocks² - 1, row by row.
  [[nodiscard]] const Block* block(int block) const {
    return blocks_[static_cast<std::size_t>(block)].get();
  }
  [[nodiscard]] Block* block(int block) { return blocks_[static_cast<std::size_t>(block)].get(); }
  /// Makes the block when there is none.
  [[nodiscard]] Block& make_block(int block);

  [[nodiscard]] std::size_t seen_cells() const;
  /// What the tile takes in memory.
  [[nodiscard]] std::size_t bytes() const;
  /// Same cells with the same values, whatever the order in which times were listed.
  bool operator==(const MapTile& other) const;

  /// The tile as bytes, little-endian, not compressed; equal tiles give equal bytes. Which blocks
  /// there are (64 bits), then of each: the number of times (16 bits), the times (nanoseconds UTC,
  /// 64 bits each), evidence (16 bits a cell), looks and seen (8 bits a cell).
  [[nodiscard]] std::vector<std::uint8_t> encode() const;
  /// The inverse; InvalidInput, naming the byte, for anything encode() would not have written.
  [[nodiscard]] static Result<MapTile> decode(const std::uint8_t* bytes, std::size_t size);

 private:
  std::array<std::unique_ptr<Block>, static_cast<std::size_t>(kBlocks) * kBlocks> blocks_;
};

}  // namespace watersky
