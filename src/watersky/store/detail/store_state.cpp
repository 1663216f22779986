// SPDX-License-Identifier: MIT
#include "watersky/store/detail/store_state.hpp"

#include <algorithm>
#include <cstdio>

namespace watersky::detail {

namespace {

constexpr std::size_t kPatchHeadBytes = 24;
constexpr std::size_t kCommitBytes = 32;

class ChainReader final : public TileReader {
 public:
  explicit ChainReader(TileChain chain) : chain_(std::move(chain)) {}
  [[nodiscard]] Result<MapTile> load(std::uint64_t) const override { return chain_.load(); }
  [[nodiscard]] Result<PackedTile> packed(std::uint64_t) const override {
    WATERSKY_TRY(const MapTile tile, chain_.load());
    return pack(tile);
  }

 private:
  TileChain chain_;
};

}  // namespace

void TileChain::add(Patch patch) {
  std::uint64_t later = patch.blocks;
  patches.push_back(std::move(patch));
  for (std::size_t i = patches.size() - 1; i-- > 0;) {
    if ((patches[i].blocks & ~later) == 0)
      patches.erase(patches.begin() + static_cast<std::ptrdiff_t>(i));
    else
      later |= patches[i].blocks;
  }
}

Result<MapTile> TileChain::load() const {
  MapTile tile;
  std::uint64_t missing = present;
  const auto take = [&](const MapTile& from) {
    for (int b = 0; b < MapTile::kBlocks * MapTile::kBlocks; ++b)
      if ((missing >> b & 1) == 1)
        if (const MapTile::Block* block = from.block(b)) {
          tile.make_block(b) = *block;
          missing &= ~(std::uint64_t{1} << b);
        }
  };
  for (auto patch = patches.rbegin(); patch != patches.rend(); ++patch) {
    WATERSKY_TRY(const Record record,
                 read_record(*patch->journal.file, patch->offset, patch->journal.salt));
    WATERSKY_TRY(const PatchRecord found, parse_patch_record(record));
    WATERSKY_TRY(const MapTile blocks, unpack(found.changed.tile));
    take(blocks);
  }
  if (base && missing != 0) {
    WATERSKY_TRY(const MapTile whole, base->load());
    take(whole);
  }
  return tile;
}

TileSet tiles_of(const std::vector<MapSource>& sources, const TileChains& chains) {
  std::vector<TileItem> items;
  items.reserve(chains.size());
  for (const auto& [key, chain] : chains) {
    if (chain.patches.empty()) {
      items.push_back(*chain.base);
      items.back().source = key.second;
      continue;
    }
    items.push_back({.index = key.first,
                     .source = key.second,
                     .seen_cells = chain.seen_cells,
                     .version = chain.version,
                     .digest = chain.digest,
                     .reader = std::make_shared<const ChainReader>(chain),
                     .place = 0});
  }
  return {sources, std::move(items)};
}

Bytes encode_patch_record(const TileIndex& index, std::uint32_t source, std::uint64_t version,
                          const TileChange& change) {
  Bytes out;
  put(out, tile_digest(change.digests));
  put(out, change.present());
  put(out, change.seen_cells);
  put(out, std::uint32_t{0});
  const Bytes tile = encode_tile_record(index, source, version, change.changed);
  out.insert(out.end(), tile.begin(), tile.end());
  return out;
}

Result<PatchRecord> parse_patch_record(const Record& record) {
  const Bytes& b = record.payload;
  if (record.kind != RecordKind::Patch || b.size() < kPatchHeadBytes)
    return Error{ErrorCode::InvalidInput, "a record is no patch"};
  PatchRecord out{.digest = number_at<std::uint64_t>(b, 0),
                  .present = number_at<std::uint64_t>(b, 8),
                  .seen_cells = number_at<std::uint32_t>(b, 16),
                  .changed = {}};
  WATERSKY_TRY(out.changed, parse_tile_record({RecordKind::Tile, record.offset, record.salt,
                                               Bytes(b.begin() + kPatchHeadBytes, b.end())}));
  return out;
}

Bytes encode_commit_record(const CommitRecord& commit) {
  Bytes out;
  put(out, commit.commit.sequence);
  put(out, static_cast<std::int64_t>(commit.commit.time.time_since_epoch().count()));
  put(out, commit.batch_offset);
  put(out, commit.records);
  put(out, std::uint32_t{0});
  return out;
}

Result<CommitRecord> parse_commit_record(const Record& record) {
  const Bytes& b = record.payload;
  if (record.kind != RecordKind::Commit || b.size() != kCommitBytes)
    return Error{ErrorCode::InvalidInput, "a record ends no batch"};
  return CommitRecord{.commit = {.sequence = number_at<std::uint64_t>(b, 0),
                                 .time = Time(Duration(number_at<std::int64_t>(b, 8)))},
                      .batch_offset = number_at<std::uint64_t>(b, 16),
                      .records = number_at<std::uint32_t>(b, 24)};
}

std::string snapshot_name(std::uint32_t number) {
  char text[40];
  std::snprintf(text, sizeof text, "snapshot-%08u.wsmap", number);
  return text;
}

std::string journal_name(std::uint32_t number) {
  char text[40];
  std::snprintf(text, sizeof text, "journal-%08u.wsj", number);
  return text;
}

}  // namespace watersky::detail
