// SPDX-License-Identifier: MIT
#include "watersky/store/map_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace watersky {

namespace {

constexpr int kBlocksInTile = MapTile::kBlocks * MapTile::kBlocks;
constexpr auto kCells = static_cast<std::size_t>(MapTile::kCellsInBlock);

/// Log-odds minus the prior's of a cell that nobody looked at for a while.
double forgotten(double evidence, double prior_log_odds, const CellDynamics& dynamics,
                 double elapsed_s) {
  const double p = dynamics.predict(probability(evidence + prior_log_odds), elapsed_s);
  return log_odds(p) - prior_log_odds;
}

/// What one source adds to the sums of a block.
void add(const MapTile::Block& block, const MapViewParameters& parameters, double prior_log_odds,
         std::array<double, kCells>& evidence, std::array<unsigned, kCells>& looks,
         std::array<std::optional<Time>, kCells>& seen) {
  for (std::size_t c = 0; c < kCells; ++c) {
    if (block.looks[c] == 0) continue;
    double e = static_cast<double>(block.evidence[c]) / kEvidenceUnits;
    const Time last = block.times[block.seen[c]];
    if (parameters.dynamics && parameters.common_time && *parameters.common_time > last)
      e = forgotten(e, prior_log_odds, *parameters.dynamics,
                    to_seconds(*parameters.common_time - last));
    evidence[c] += e;
    looks[c] += block.looks[c];
    seen[c] = seen[c] ? std::max(*seen[c], last) : last;
  }
}

/// Of the cells seen, within the tile.
CellBox seen_cells_box(const MapTile& tile) {
  int left = kTileCells, right = -1, top = kTileCells, bottom = -1;
  for (int b = 0; b < kBlocksInTile; ++b) {
    const MapTile::Block* block = tile.block(b);
    if (!block) continue;
    for (int i = 0; i < MapTile::kCellsInBlock; ++i) {
      if (block->looks[static_cast<std::size_t>(i)] == 0) continue;
      const int c = b % MapTile::kBlocks * MapTile::kBlockCells + i % MapTile::kBlockCells;
      const int r = b / MapTile::kBlocks * MapTile::kBlockCells + i / MapTile::kBlockCells;
      left = std::min(left, c), right = std::max(right, c);
      top = std::min(top, r), bottom = std::max(bottom, r);
    }
  }
  return {left, top, right - left + 1, bottom - top + 1};
}

}  // namespace

MapViewParameters MapViewParameters::of(const MapHeader& header) {
  MapViewParameters out{.prior = header.prior, .max_probability = header.max_probability};
  for (const MapSource& source : header.sources)
    out.common_time = std::max(out.common_time, source.last);
  if (header.half_life_s > 0 && out.common_time)
    out.dynamics = CellDynamics::with_half_life(header.half_life_s, header.prior);
  else
    out.common_time.reset();
  return out;
}

MapTile sum_of(std::span<const MapTile> sources, const MapViewParameters& parameters) {
  const double prior_log_odds = log_odds(parameters.prior);
  const double most = log_odds(parameters.max_probability);
  const auto units = [](double e) {
    return std::clamp(e * kEvidenceUnits, -1.0 * kMostEvidence, 1.0 * kMostEvidence);
  };
  // One source with nothing to forget is as it is, to the bit.
  if (sources.size() == 1 && !parameters.dynamics) return sources.front();
  MapTile out;
  for (int b = 0; b < kBlocksInTile; ++b) {
    std::array<double, kCells> evidence{};
    std::array<unsigned, kCells> looks{};
    std::array<std::optional<Time>, kCells> seen{};
    bool any = false;
    for (const MapTile& source : sources)
      if (const MapTile::Block* block = source.block(b)) {
        add(*block, parameters, prior_log_odds, evidence, looks, seen);
        any = true;
      }
    if (!any) continue;
    std::vector<Time> times;
    for (const auto& time : seen)
      if (time) times.push_back(*time);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    MapTile::Block& block = out.make_block(b);
    // In order, so that places stay; too many for one block become earlier (MapTile's own rule).
    if (times.size() <= MapTile::kMostTimes) block.times = times;
    for (std::size_t c = 0; c < kCells; ++c) {
      if (!seen[c]) continue;
      const double clamped = std::clamp(evidence[c] + prior_log_odds, -most, most) - prior_log_odds;
      block.evidence[c] = static_cast<std::int16_t>(std::lround(units(clamped)));
      block.looks[c] = static_cast<std::uint8_t>(std::min<unsigned>(looks[c], MapTile::kMostLooks));
      if (times.size() <= MapTile::kMostTimes) block.seen[c] = block.place_of(*seen[c]);
    }
    if (times.size() <= MapTile::kMostTimes) continue;
    for (const Time& time : times) {
      const std::uint8_t place = block.place_of(time);
      for (std::size_t c = 0; c < kCells; ++c)
        if (seen[c] && *seen[c] == time) block.seen[c] = place;
    }
  }
  return out;
}

Result<MapTile> view_tile(const TileSet& set, const TileIndex& index,
                          const MapViewParameters& parameters) {
  std::vector<MapTile> sources;
  for (const TileItem& item : set.of(index)) {
    WATERSKY_TRY(MapTile tile, item.load());
    sources.push_back(std::move(tile));
  }
  return sum_of(sources, parameters);
}

Result<CellBox> seen_box(const TileSet& set) {
  const std::vector<TileIndex> tiles = set.tiles();
  if (tiles.empty()) return CellBox{};
  TileIndex first = tiles.front(), last = tiles.front();
  for (const TileIndex& t : tiles) {
    first = {std::min(first.column, t.column), std::min(first.row, t.row)};
    last = {std::max(last.column, t.column), std::max(last.row, t.row)};
  }
  CellBox box;
  for (const TileItem& item : set.items()) {
    const TileIndex& t = item.index;
    if (t.column != first.column && t.column != last.column && t.row != first.row &&
        t.row != last.row)
      continue;
    WATERSKY_TRY(const MapTile tile, item.load());
    const CellBox seen = seen_cells_box(tile);
    if (seen.empty()) continue;
    const CellBox cells = cells_of(t);
    box = box.united({cells.first_column + seen.first_column, cells.first_row + seen.first_row,
                      seen.columns, seen.rows});
  }
  return box;
}

}  // namespace watersky
