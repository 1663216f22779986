// SPDX-License-Identifier: MIT
#include "watersky/store/detail/tile_record.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <string>

#include "watersky/store/detail/compression.hpp"

namespace watersky::detail {

namespace {

constexpr std::size_t kTileHeadBytes = 48;
constexpr std::size_t kOverviewHeadBytes = 16;
constexpr std::size_t kIndexEntryBytes = 48;
constexpr std::array<std::uint8_t, 8> kFooterMagic{'W', 'S', 'M', 'i', 'n', 'd', 'e', 'x'};

Error wrong(const char* what) { return {ErrorCode::InvalidInput, std::string("a record ") + what}; }

bool too_far(const TileIndex& index) {
  return index.column < -kFarthestTile || index.column > kFarthestTile ||
         index.row < -kFarthestTile || index.row > kFarthestTile;
}

TileIndex index_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return {number_at<std::int32_t>(bytes, at), number_at<std::int32_t>(bytes, at + 4)};
}

}  // namespace

Bytes encode_tile_record(const TileIndex& index, std::uint32_t source, std::uint64_t version,
                         const PackedTile& tile) {
  Bytes out;
  out.reserve(kTileHeadBytes + tile.planes.size());
  put<std::int32_t>(out, index.column);
  put<std::int32_t>(out, index.row);
  put(out, source);
  put(out, tile.seen_cells);
  put(out, version);
  put(out, tile.digest);
  put(out, tile.blocks);
  put(out, std::uint64_t{1});  // how the planes are packed: the only way there is
  out.insert(out.end(), tile.planes.begin(), tile.planes.end());
  return out;
}

Result<TileRecord> parse_tile_record(const Record& record) {
  const Bytes& b = record.payload;
  if (record.kind != RecordKind::Tile || b.size() < kTileHeadBytes) return wrong("is no tile");
  if (number_at<std::uint64_t>(b, 40) != 1) return wrong("is packed in a way not known here");
  TileRecord out{.index = index_at(b, 0),
                 .source = number_at<std::uint32_t>(b, 8),
                 .version = number_at<std::uint64_t>(b, 16)};
  out.tile = {.blocks = number_at<std::uint64_t>(b, 32),
              .digest = number_at<std::uint64_t>(b, 24),
              .seen_cells = number_at<std::uint32_t>(b, 12),
              .planes = Bytes(b.begin() + kTileHeadBytes, b.end())};
  const auto cells = static_cast<std::uint32_t>(std::popcount(out.tile.blocks)) *
                     static_cast<std::uint32_t>(MapTile::kCellsInBlock);
  if (too_far(out.index) || out.tile.seen_cells > cells)
    return wrong("names a tile that cannot be");
  return out;
}

Bytes encode_overview_record(int level, const TileIndex& index, const OverviewTile& tile) {
  Bytes out;
  put<std::int32_t>(out, index.column);
  put<std::int32_t>(out, index.row);
  put<std::uint32_t>(out, static_cast<std::uint32_t>(level));
  put(out, std::uint32_t{1});
  const Bytes small = compress(tile.cells);
  out.insert(out.end(), small.begin(), small.end());
  return out;
}

Result<OverviewRecord> parse_overview_record(const Record& record) {
  const Bytes& b = record.payload;
  if (record.kind != RecordKind::Overview || b.size() < kOverviewHeadBytes)
    return wrong("is no overview");
  if (number_at<std::uint32_t>(b, 12) != 1) return wrong("is packed in a way not known here");
  const auto level = number_at<std::uint32_t>(b, 8);
  if (level < 1 || level > kMostLevel) return wrong("has an impossible level");
  OverviewRecord out{.level = static_cast<int>(level), .index = index_at(b, 0), .tile = {}};
  WATERSKY_TRY(const Bytes cells,
               decompress(std::span(b).subspan(kOverviewHeadBytes), out.tile.cells.size()));
  std::copy(cells.begin(), cells.end(), out.tile.cells.begin());
  return out;
}

Bytes encode_index(const std::vector<IndexEntry>& entries) {
  Bytes out;
  out.reserve(8 + entries.size() * kIndexEntryBytes);
  put(out, static_cast<std::uint64_t>(entries.size()));
  for (const IndexEntry& e : entries) {
    put<std::int32_t>(out, e.index.column);
    put<std::int32_t>(out, e.index.row);
    put(out, e.source);
    put(out, e.seen_cells);
    put(out, e.version);
    put(out, e.digest);
    put(out, e.offset);
    put(out, static_cast<std::uint64_t>(e.level));
  }
  return out;
}

Result<std::vector<IndexEntry>> parse_index(const Record& record) {
  const Bytes& b = record.payload;
  if (record.kind != RecordKind::Index || b.size() < 8) return wrong("is no index");
  const auto count = number_at<std::uint64_t>(b, 0);
  if ((b.size() - 8) % kIndexEntryBytes != 0 || count != (b.size() - 8) / kIndexEntryBytes)
    return wrong("counts more or less tiles than it lists");
  std::vector<IndexEntry> out;
  out.reserve(static_cast<std::size_t>(count));
  for (std::size_t at = 8; at < b.size(); at += kIndexEntryBytes) {
    const auto level = number_at<std::uint64_t>(b, at + 40);
    IndexEntry e{.offset = number_at<std::uint64_t>(b, at + 32),
                 .source = number_at<std::uint32_t>(b, at + 8),
                 .level = static_cast<int>(std::min<std::uint64_t>(level, kMostLevel + 1)),
                 .index = index_at(b, at),
                 .seen_cells = number_at<std::uint32_t>(b, at + 12),
                 .version = number_at<std::uint64_t>(b, at + 16),
                 .digest = number_at<std::uint64_t>(b, at + 24)};
    if (e.level > kMostLevel || too_far(e.index)) return wrong("lists a tile that cannot be");
    out.push_back(e);
  }
  return out;
}

Bytes encode_footer(std::uint64_t index_offset) {
  Bytes out;
  put(out, index_offset);
  out.insert(out.end(), kFooterMagic.begin(), kFooterMagic.end());
  put(out, checksum(out));
  return out;
}

Result<std::uint64_t> read_footer(const StorageFile& file) {
  std::array<std::uint8_t, kFooterBytes> b{};
  const Error none{ErrorCode::InvalidInput,
                   file.path().string() + ": does not end as a map file does; it was cut at byte " +
                       std::to_string(file.size()) +
                       " or its end is damaged; take another copy, or recover the tiles that are "
                       "whole with watersky merge --recover"};
  if (file.size() < kPreambleBytes + kFooterBytes) return none;
  WATERSKY_CHECK(file.read(file.size() - b.size(), b));
  if (!std::equal(kFooterMagic.begin(), kFooterMagic.end(), b.begin() + 8) ||
      number_at<std::uint64_t>(b, 16) != checksum(std::span(b).first(16)))
    return none;
  return number_at<std::uint64_t>(b, 0);
}

}  // namespace watersky::detail
