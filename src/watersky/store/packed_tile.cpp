// SPDX-License-Identifier: MIT
#include "watersky/store/packed_tile.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

#include "watersky/store/detail/compression.hpp"
#include "watersky/store/detail/records.hpp"

namespace watersky {

namespace {

using detail::checksum;
using detail::compress;
using detail::decompress;

constexpr std::size_t kCells = MapTile::kCellsInBlock;
constexpr std::size_t kPlanes = 5;
/// A block as encode() writes it, without its times: how many, evidence, looks, seen.
constexpr std::size_t kBlockBytes = 2 + 4 * kCells;

/// A block in the bytes of MapTile::encode().
struct EncodedBlock {
  int number = 0;
  std::span<const std::uint8_t> bytes;

  [[nodiscard]] std::uint16_t times() const { return number_at<std::uint16_t>(bytes, 0); }
  [[nodiscard]] std::span<const std::uint8_t> time_list() const {
    return bytes.subspan(2, std::size_t{8} * times());
  }
  [[nodiscard]] std::span<const std::uint8_t> cells() const { return bytes.last(4 * kCells); }
  [[nodiscard]] std::uint64_t digest() const {
    // 0 says that there is no block; a checksum that is 0 by chance is as good as 1.
    return std::max<std::uint64_t>(checksum(bytes), 1);
  }
  [[nodiscard]] std::uint32_t seen_cells() const {
    const auto looks = cells().subspan(2 * kCells, kCells);
    return static_cast<std::uint32_t>(
        std::count_if(looks.begin(), looks.end(), [](std::uint8_t l) { return l != 0; }));
  }
};

/// Of bytes that encode() made, or that decode() took.
std::vector<EncodedBlock> blocks_in(std::span<const std::uint8_t> encoded) {
  std::vector<EncodedBlock> out;
  const auto present = number_at<std::uint64_t>(encoded, 0);
  std::size_t at = 8;
  for (int b = 0; b < static_cast<int>(BlockDigests{}.size()); ++b) {
    if ((present >> b & 1) == 0) continue;
    const std::size_t size = kBlockBytes + std::size_t{8} * number_at<std::uint16_t>(encoded, at);
    out.push_back({b, encoded.subspan(at, size)});
    at += size;
  }
  return out;
}

BlockDigests digests_of(const std::vector<EncodedBlock>& blocks) {
  BlockDigests digests{};
  for (const EncodedBlock& block : blocks)
    digests[static_cast<std::size_t>(block.number)] = block.digest();
  return digests;
}

Error damaged(const char* what) {
  return {ErrorCode::InvalidInput, std::string("a tile's planes ") + what};
}

}  // namespace

std::uint64_t TileChange::present() const {
  std::uint64_t out = 0;
  for (std::size_t b = 0; b < digests.size(); ++b)
    out |= std::uint64_t{digests[b] != 0 ? 1U : 0U} << b;
  return out;
}

std::uint64_t tile_digest(const BlockDigests& blocks) {
  return checksum(
      {reinterpret_cast<const std::uint8_t*>(blocks.data()), blocks.size() * sizeof blocks[0]});
}

namespace {

PackedTile packed(const std::vector<EncodedBlock>& blocks) {
  PackedTile out;
  BlockDigests digests{};
  // Times first count, then list: blocks that lie beside each other were seen at the same times,
  // and zstd finds the lists again.
  Bytes counts, times, low, high, looks, seen;
  for (Bytes* plane : {&low, &high, &looks, &seen}) plane->reserve(blocks.size() * kCells);
  for (const EncodedBlock& block : blocks) {
    out.blocks |= std::uint64_t{1} << block.number;
    digests[static_cast<std::size_t>(block.number)] = block.digest();
    out.seen_cells += block.seen_cells();
    put(counts, block.times());
    const auto list = block.time_list(), cells = block.cells();
    times.insert(times.end(), list.begin(), list.end());
    for (std::size_t c = 0; c < kCells; ++c) {
      low.push_back(cells[2 * c]);
      high.push_back(cells[2 * c + 1]);
    }
    looks.insert(looks.end(), cells.begin() + 2 * kCells, cells.begin() + 3 * kCells);
    seen.insert(seen.end(), cells.begin() + 3 * kCells, cells.end());
  }
  out.digest = tile_digest(digests);
  counts.insert(counts.end(), times.begin(), times.end());
  put(out.planes, static_cast<std::uint32_t>(counts.size()));
  for (const Bytes* plane : {&counts, &low, &high, &looks, &seen}) {
    const Bytes small = compress(*plane);
    put(out.planes, static_cast<std::uint32_t>(small.size()));
    out.planes.insert(out.planes.end(), small.begin(), small.end());
  }
  return out;
}

}  // namespace

PackedTile pack(const MapTile& tile) {
  const Bytes bytes = tile.encode();
  return packed(blocks_in(bytes));
}

TileChange change_of(const MapTile& tile, const BlockDigests& before) {
  const Bytes bytes = tile.encode();
  std::vector<EncodedBlock> blocks = blocks_in(bytes);
  TileChange out;
  out.digests = digests_of(blocks);
  for (const EncodedBlock& block : blocks) out.seen_cells += block.seen_cells();
  std::erase_if(blocks, [&](const EncodedBlock& block) {
    const auto number = static_cast<std::size_t>(block.number);
    return before[number] == out.digests[number];
  });
  out.changed = packed(blocks);
  return out;
}

Result<MapTile> unpack(std::uint64_t blocks, std::uint64_t digest,
                       std::span<const std::uint8_t> planes) {
  const auto count = static_cast<std::size_t>(std::popcount(blocks));
  if (planes.size() < 4) return damaged("are cut");
  const auto times_bytes = number_at<std::uint32_t>(planes, 0);
  if (times_bytes < 2 * count || times_bytes > count * (2 + 8 * MapTile::kMostTimes))
    return damaged("list an impossible number of times");
  planes = planes.subspan(4);
  std::array<Bytes, kPlanes> whole;
  for (std::size_t i = 0; i < kPlanes; ++i) {
    if (planes.size() < 4) return damaged("are cut");
    const auto size = number_at<std::uint32_t>(planes, 0);
    planes = planes.subspan(4);
    if (size > planes.size()) return damaged("are cut");
    WATERSKY_TRY(whole[i], decompress(planes.first(size), i == 0 ? times_bytes : count * kCells));
    planes = planes.subspan(size);
  }
  if (!planes.empty()) return damaged("go on after their end");

  const auto& [times, low, high, looks, seen] = whole;
  Bytes bytes;
  bytes.reserve(8 + count * kBlockBytes + times.size());
  put(bytes, blocks);
  std::size_t time_at = 2 * count;
  for (std::size_t b = 0; b < count; ++b) {
    const auto listed = number_at<std::uint16_t>(times, 2 * b);
    const std::size_t list_bytes = std::size_t{8} * listed;
    if (list_bytes > times.size() - time_at) return damaged("list fewer times than they count");
    put(bytes, listed);
    bytes.insert(bytes.end(), times.begin() + time_at, times.begin() + time_at + list_bytes);
    time_at += list_bytes;
    const std::size_t from = b * kCells;
    const std::size_t at = bytes.size();
    bytes.resize(at + 4 * kCells);
    for (std::size_t c = 0; c < kCells; ++c) {
      bytes[at + 2 * c] = low[from + c];
      bytes[at + 2 * c + 1] = high[from + c];
    }
    std::copy_n(looks.begin() + from, kCells, bytes.begin() + at + 2 * kCells);
    std::copy_n(seen.begin() + from, kCells, bytes.begin() + at + 3 * kCells);
  }
  if (time_at != times.size()) return damaged("list more times than they count");
  WATERSKY_TRY(MapTile tile, MapTile::decode(bytes.data(), bytes.size()));
  if (tile_digest(digests_of(blocks_in(bytes))) != digest)
    return damaged("are not those of their digest");
  return tile;
}

}  // namespace watersky
