// SPDX-License-Identifier: MIT
#include "watersky/store/map_diff.hpp"

#include <algorithm>
#include <cmath>

namespace watersky {

namespace {

constexpr std::size_t kCells = static_cast<std::size_t>(kTileCells) * kTileCells;

enum class Seen : std::uint8_t { Not, Water, Ice };

Seen state_of(const MapTile::Block* block, std::size_t cell, double threshold) {
  if (!block || block->looks[cell] == 0) return Seen::Not;
  return block->evidence[cell] > threshold ? Seen::Ice : Seen::Water;
}

std::uint8_t change(Seen before, Seen after) {
  if (before == Seen::Not && after == Seen::Not) return kNeitherSeen;
  CellChange out = CellChange::OnlyBefore;
  if (before == Seen::Not) {
    out = after == Seen::Ice ? CellChange::NewIce : CellChange::NewWater;
  } else if (after != Seen::Not) {
    out = before == after ? (after == Seen::Ice ? CellChange::StayedIce : CellChange::StayedWater)
                          : (after == Seen::Ice ? CellChange::BecameIce : CellChange::BecameWater);
  }
  return static_cast<std::uint8_t>(out);
}

}  // namespace

std::string_view name_of(CellChange change) {
  constexpr std::array<std::string_view, kCellChanges> kNames{
      "stayed_water", "stayed_ice", "became_water", "became_ice",
      "new_water",    "new_ice",    "only_before"};
  return kNames[static_cast<std::size_t>(change)];
}

TileChanges changes_of(const MapTile& before, const MapTile& after, double prior_log_odds,
                       double ice_probability) {
  const double threshold = (log_odds(ice_probability) - prior_log_odds) * kEvidenceUnits;
  TileChanges out(kCells, kNeitherSeen);
  for (int b = 0; b < MapTile::kBlocks * MapTile::kBlocks; ++b) {
    const MapTile::Block *from = before.block(b), *to = after.block(b);
    if (!from && !to) continue;
    for (int i = 0; i < MapTile::kCellsInBlock; ++i) {
      const int c = b % MapTile::kBlocks * MapTile::kBlockCells + i % MapTile::kBlockCells;
      const int r = b / MapTile::kBlocks * MapTile::kBlockCells + i / MapTile::kBlockCells;
      const auto cell = static_cast<std::size_t>(i);
      out[static_cast<std::size_t>(r * kTileCells + c)] =
          change(state_of(from, cell, threshold), state_of(to, cell, threshold));
    }
  }
  return out;
}

MapDiff::MapDiff(StoredMap before, StoredMap after, double ice_probability)
    : before_(std::move(before)), after_(std::move(after)), ice_probability_(ice_probability) {
  tiles_ = before_.tiles.tiles();
  const std::vector<TileIndex> later = after_.tiles.tiles();
  tiles_.insert(tiles_.end(), later.begin(), later.end());
  std::sort(tiles_.begin(), tiles_.end());
  tiles_.erase(std::unique(tiles_.begin(), tiles_.end()), tiles_.end());
}

Result<MapDiff> MapDiff::of(const StoredMap& before, const StoredMap& after,
                            const std::string& before_name, const std::string& after_name,
                            double ice_probability) {
  auto aligned = after.in_grid_of(before.header);
  if (!aligned) return aligned.error().at(before_name + " and " + after_name);
  return MapDiff(before, *std::move(aligned), ice_probability);
}

Result<TileChanges> MapDiff::changes(const TileIndex& index) const {
  WATERSKY_TRY(const MapTile before, view_tile(before_.tiles, index, before_.view()));
  WATERSKY_TRY(const MapTile after, view_tile(after_.tiles, index, after_.view()));
  return changes_of(before, after, log_odds(before_.header.prior), ice_probability_);
}

Result<MapDiff::Counts> MapDiff::count(const Progress& progress) const {
  Counts counts{};
  std::size_t done = 0;
  for (const TileIndex& index : tiles_) {
    report(progress, "compare", done++, tiles_.size());
    WATERSKY_TRY(const TileChanges changed, changes(index));
    for (const std::uint8_t change : changed)
      if (change != kNeitherSeen) ++counts[change];
  }
  return counts;
}

Result<CellBox> MapDiff::seen() const {
  WATERSKY_TRY(const CellBox before, seen_box(before_.tiles));
  WATERSKY_TRY(const CellBox after, seen_box(after_.tiles));
  return before.empty() ? after : after.empty() ? before : before.united(after);
}

}  // namespace watersky
