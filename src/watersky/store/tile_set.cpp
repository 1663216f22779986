// SPDX-License-Identifier: MIT
#include "watersky/store/tile_set.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace watersky {

namespace {

/// What is known of one source by two maps: commutative, associative and idempotent as well.
MapSource joined(const MapSource& a, const MapSource& b) {
  const auto either = [](const auto& x, const auto& y, auto choose) {
    return x && y ? std::optional(choose(*x, *y)) : x ? x : y;
  };
  MapSource out = a;
  out.name = std::max(a.name, b.name);
  out.first = either(a.first, b.first, [](Time x, Time y) { return std::min(x, y); });
  out.last = either(a.last, b.last, [](Time x, Time y) { return std::max(x, y); });
  out.times_are_utc = a.times_are_utc && b.times_are_utc;
  return out;
}

class OneTile final : public TileReader {
 public:
  explicit OneTile(PackedTile tile) : tile_(std::move(tile)) {}
  [[nodiscard]] const PackedTile& tile() const { return tile_; }
  [[nodiscard]] Result<PackedTile> packed(std::uint64_t) const override { return tile_; }

 private:
  PackedTile tile_;
};

auto rank(const TileItem& item) { return std::tuple(item.version, item.digest, item.seen_cells); }

}  // namespace

Result<MapTile> TileReader::load(std::uint64_t place) const {
  WATERSKY_TRY(const PackedTile whole, packed(place));
  return unpack(whole);
}

TileSet::TileSet(std::vector<MapSource> sources, std::vector<TileItem> items)
    : items_(std::move(items)) {
  std::map<std::string, MapSource> by_id;
  for (const MapSource& source : sources) {
    const auto [found, made] = by_id.emplace(source.id, source);
    if (!made) found->second = joined(found->second, source);
  }
  std::map<std::string, std::uint32_t> number;
  for (auto& [id, source] : by_id) {
    number[id] = static_cast<std::uint32_t>(sources_.size());
    sources_.push_back(std::move(source));
  }
  for (TileItem& item : items_) item.source = number.at(sources[item.source].id);
  std::sort(items_.begin(), items_.end(), [](const TileItem& a, const TileItem& b) {
    return std::tuple(a.index, a.source, rank(b)) < std::tuple(b.index, b.source, rank(a));
  });
  const auto same = [](const TileItem& a, const TileItem& b) {
    return a.index == b.index && a.source == b.source;
  };
  items_.erase(std::unique(items_.begin(), items_.end(), same), items_.end());
}

std::span<const TileItem> TileSet::of(const TileIndex& index) const {
  const auto first = std::lower_bound(
      items_.begin(), items_.end(), index,
      [](const TileItem& item, const TileIndex& wanted) { return item.index < wanted; });
  auto last = first;
  while (last != items_.end() && last->index == index) ++last;
  return {first, last};
}

std::vector<TileIndex> TileSet::tiles() const {
  std::vector<TileIndex> out;
  for (const TileItem& item : items_)
    if (out.empty() || out.back() != item.index) out.push_back(item.index);
  return out;
}

TileSet TileSet::united(const TileSet& other) const {
  std::vector<MapSource> sources = sources_;
  sources.insert(sources.end(), other.sources_.begin(), other.sources_.end());
  std::vector<TileItem> items = items_;
  items.reserve(items_.size() + other.items_.size());
  for (TileItem item : other.items_) {
    item.source = static_cast<std::uint32_t>(item.source + sources_.size());
    items.push_back(std::move(item));
  }
  return {std::move(sources), std::move(items)};
}

TileSet TileSet::shifted(const TileIndex& by) const {
  TileSet out = *this;
  for (TileItem& item : out.items_)
    item.index = {item.index.column + by.column, item.index.row + by.row};
  return out;
}

bool TileSet::operator==(const TileSet& other) const {
  return sources_ == other.sources_ &&
         std::equal(items_.begin(), items_.end(), other.items_.begin(), other.items_.end(),
                    [](const TileItem& a, const TileItem& b) {
                      return a.index == b.index && a.source == b.source && rank(a) == rank(b);
                    });
}

TileItem item_in_memory(const TileIndex& index, std::uint32_t source, std::uint64_t version,
                        const MapTile& tile) {
  auto memory = std::make_shared<const OneTile>(pack(tile));
  return {.index = index,
          .source = source,
          .seen_cells = memory->tile().seen_cells,
          .version = version,
          .digest = memory->tile().digest,
          .reader = memory,
          .place = 0};
}

}  // namespace watersky
