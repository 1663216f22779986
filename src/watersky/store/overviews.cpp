// SPDX-License-Identifier: MIT
#include "watersky/store/overviews.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/map/log_odds.hpp"

namespace watersky {

namespace {

constexpr int kMostLevels = 24;
constexpr std::size_t kSide = kTileCells;

/// The mean of those of four that are known, in whole steps; ties to even.
std::uint8_t mean_of_known(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
  unsigned sum = 0, count = 0;
  for (const std::uint8_t x : {a, b, c, d}) {
    const unsigned known = x != OverviewTile::kUnseen ? 1 : 0;
    sum += known * x;
    count += known;
  }
  if (count == 0) return OverviewTile::kUnseen;
  const unsigned whole = sum / count, rest = 2 * (sum % count);
  const bool up = rest > count || (rest == count && whole % 2 == 1);
  return static_cast<std::uint8_t>(whole + (up ? 1 : 0));
}

/// Bits of a number, each followed by a zero.
std::uint64_t spread(std::uint32_t x) {
  std::uint64_t v = x;
  v = (v | v << 16) & 0x0000ffff0000ffff;
  v = (v | v << 8) & 0x00ff00ff00ff00ff;
  v = (v | v << 4) & 0x0f0f0f0f0f0f0f0f;
  v = (v | v << 2) & 0x3333333333333333;
  return (v | v << 1) & 0x5555555555555555;
}

std::uint64_t morton(const TileIndex& index) {
  constexpr std::uint32_t kMiddle = std::uint32_t{1} << 31;  // halves of negative indices stay so
  return spread(static_cast<std::uint32_t>(index.column) + kMiddle) |
         spread(static_cast<std::uint32_t>(index.row) + kMiddle) << 1;
}

}  // namespace

OverviewTile overview_of(const MapTile& tile, double prior_log_odds) {
  // The step of each evidence, once for all: 64 kB, made in a millisecond a prior.
  struct Steps {
    double prior = std::nan("");
    std::vector<std::uint8_t> of;
  };
  thread_local Steps steps;
  if (steps.prior != prior_log_odds) {
    steps.prior = prior_log_odds;
    steps.of.resize(2 * (kMostEvidence + 1));
    for (int e = -kMostEvidence - 1; e <= kMostEvidence; ++e)
      steps.of[static_cast<std::size_t>(e + kMostEvidence + 1)] = static_cast<std::uint8_t>(
          std::lround(OverviewTile::kSteps *
                      probability(static_cast<double>(e) / kEvidenceUnits + prior_log_odds)));
  }
  OverviewTile out;
  for (int b = 0; b < MapTile::kBlocks * MapTile::kBlocks; ++b) {
    const MapTile::Block* block = tile.block(b);
    if (!block) continue;
    for (int r = 0; r < MapTile::kBlockCells; ++r)
      for (int c = 0; c < MapTile::kBlockCells; ++c) {
        const auto cell = static_cast<std::size_t>(r * MapTile::kBlockCells + c);
        if (block->looks[cell] == 0) continue;
        const int column = b % MapTile::kBlocks * MapTile::kBlockCells + c;
        const int row = b / MapTile::kBlocks * MapTile::kBlockCells + r;
        out.cells[static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column)] =
            steps.of[static_cast<std::size_t>(block->evidence[cell] + kMostEvidence + 1)];
      }
  }
  return out;
}

void put_halved(OverviewTile& above, const TileIndex& index, const OverviewTile& tile) {
  const auto left = static_cast<std::size_t>(index.column & 1) * (kSide / 2);
  const auto top = static_cast<std::size_t>(index.row & 1) * (kSide / 2);
  for (std::size_t r = 0; r < kSide / 2; ++r) {
    const std::uint8_t* upper = tile.cells.data() + 2 * r * kSide;
    const std::uint8_t* lower = upper + kSide;
    std::uint8_t* to = above.cells.data() + (top + r) * kSide + left;
    for (std::size_t c = 0; c < kSide / 2; ++c)
      to[c] = mean_of_known(upper[2 * c], upper[2 * c + 1], lower[2 * c], lower[2 * c + 1]);
  }
}

int overview_levels(const std::vector<TileIndex>& tiles) {
  std::set<TileIndex> level(tiles.begin(), tiles.end());
  int levels = 0;
  while (level.size() > 4 && levels < kMostLevels) {
    std::set<TileIndex> above;
    for (const TileIndex& index : level) above.insert(half_of(index));
    level = std::move(above);
    ++levels;
  }
  return levels;
}

void sort_for_overviews(std::vector<TileIndex>& tiles) {
  std::sort(tiles.begin(), tiles.end(),
            [](const TileIndex& a, const TileIndex& b) { return morton(a) < morton(b); });
}

void OverviewStream::put(std::size_t level, const TileIndex& index, const OverviewTile& tile) {
  if (level == open_.size()) return;
  const TileIndex above = half_of(index);
  if (open_[level].tile && open_[level].index != above) close(level);
  if (!open_[level].tile) open_[level] = {above, std::make_unique<OverviewTile>()};
  put_halved(*open_[level].tile, index, tile);
}

void OverviewStream::close(std::size_t level) {
  const Open done = std::exchange(open_[level], {});
  if (!done.tile) return;
  sink_(static_cast<int>(level) + 1, done.index, *done.tile);
  put(level + 1, done.index, *done.tile);
}

void OverviewStream::finish() {
  for (std::size_t level = 0; level < open_.size(); ++level) close(level);
}

void Overviews::change(const TileIndex& index, const MapTile& tile) {
  if (levels_.empty()) levels_.emplace_back();
  auto& above = levels_[0][half_of(index)];
  if (!above) above = std::make_unique<OverviewTile>();
  put_halved(*above, index, overview_of(tile, prior_log_odds_));
  changed_.insert(half_of(index));
}

std::vector<Overviews::Changed> Overviews::refresh() {
  std::vector<Changed> out;
  std::set<TileIndex> changed = std::exchange(changed_, {});
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    for (const TileIndex& index : changed) out.push_back({static_cast<int>(level) + 1, index});
    if (level + 1 == levels_.size()) {
      if (levels_[level].size() <= 4 || levels_.size() == kMostLevels) break;
      // A new level shows all of the one below, not only what changed.
      levels_.emplace_back();
      for (const auto& [index, tile] : levels_[level]) changed.insert(index);
    }
    std::set<TileIndex> above;
    for (const TileIndex& index : changed) {
      auto& into = levels_[level + 1][half_of(index)];
      if (!into) into = std::make_unique<OverviewTile>();
      put_halved(*into, index, *levels_[level].at(index));
      above.insert(half_of(index));
    }
    changed = std::move(above);
  }
  return out;
}

const OverviewTile* Overviews::tile(int level, const TileIndex& index) const {
  if (level < 1 || level > levels()) return nullptr;
  const auto& tiles = levels_[static_cast<std::size_t>(level) - 1];
  const auto found = tiles.find(index);
  return found == tiles.end() ? nullptr : found->second.get();
}

}  // namespace watersky
