// SPDX-License-Identifier: MIT
#include "watersky/store/stored_map.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/store/map_file.hpp"
#include "watersky/store/map_store.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

StoredMap stored(const MapFile& file) { return {file.header(), file.tiles(), file.notes()}; }

/// Through the map's rasters, which say all that a tile holds.
MapTile tile_of(const IceMap& map, const TileIndex& index) {
  const CellBox box = cells_of(index);
  const cv::Mat log_odds = map.log_odds(box), looks = map.looks(box);
  const cv::Mat last_seen_s = map.last_seen_s(box);
  MapTile tile;
  for (int b = 0; b < MapTile::kBlocks * MapTile::kBlocks; ++b) {
    std::vector<Time> times;
    const auto each = [&](const auto& body) {
      for (int i = 0; i < MapTile::kCellsInBlock; ++i) {
        const int c = b % MapTile::kBlocks * MapTile::kBlockCells + i % MapTile::kBlockCells;
        const int r = b / MapTile::kBlocks * MapTile::kBlockCells + i / MapTile::kBlockCells;
        const int seen = looks.at<std::uint16_t>(r, c);
        if (seen == 0) continue;
        body(static_cast<std::size_t>(i), r, c, seen,
             time_from_seconds(last_seen_s.at<double>(r, c)).value_or(Time{}));
      }
    };
    each([&](std::size_t, int, int, int, Time time) { times.push_back(time); });
    if (times.empty()) continue;
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    MapTile::Block& block = tile.make_block(b);
    for (const Time& time : times) {
      const std::uint8_t place = block.place_of(time);
      each([&](std::size_t cell, int r, int c, int seen, Time at) {
        if (at != time) return;
        const double evidence = log_odds.at<float>(r, c) - map.prior_log_odds();
        block.evidence[cell] = static_cast<std::int16_t>(std::lround(
            std::clamp(evidence * kEvidenceUnits, -1.0 * kMostEvidence, 1.0 * kMostEvidence)));
        block.looks[cell] = static_cast<std::uint8_t>(std::min(seen, MapTile::kMostLooks));
        block.seen[cell] = place;
      });
    }
  }
  return tile;
}

}  // namespace

Result<StoredMap> StoredMap::in_grid_of(const MapHeader& other) const {
  WATERSKY_TRY(const TileIndex by, tiles_between(header, other));
  StoredMap out{header, tiles.shifted(by), notes};
  out.header.anchor_easting_m = other.anchor_easting_m;
  out.header.anchor_northing_m = other.anchor_northing_m;
  return out;
}

Result<StoredMap> open_map(Storage& storage, const fs::path& path, bool recover) {
  auto names = storage.list(path);
  if (names && std::find(names->begin(), names->end(), kMapFileName) == names->end()) {
    auto live = MapStore::open(storage, path);
    if (!live && live.error().code == ErrorCode::NotFound)
      return Error{ErrorCode::NotFound, path.string() + ": holds no map (" + kMapFileName +
                                            ", or a live map's journal); give a folder of watersky "
                                            "map, or a map file"};
    if (!live) return live.error();
    return StoredMap{live->header(), live->tiles(), live->notes()};
  }
  const fs::path file = names ? path / kMapFileName : path;
  auto map = MapFile::open(storage, file);
  if (map) return stored(*map);
  if (!recover || map.error().code != ErrorCode::InvalidInput) return map.error();
  WATERSKY_TRY(std::unique_ptr<StorageFile> again, storage.open(file, FileAccess::Read));
  WATERSKY_TRY(const MapFile recovered, MapFile::recover(std::move(again)));
  return stored(recovered);
}

Result<StoredMap> merge_maps(const std::vector<StoredMap>& maps,
                             const std::vector<std::string>& names) {
  WATERSKY_REQUIRE(!maps.empty() && maps.size() == names.size());
  StoredMap out = maps.front();
  for (std::size_t i = 1; i < maps.size(); ++i) {
    const auto other = maps[i].in_grid_of(out.header);
    if (!other) return other.error().at(names[0] + " and " + names[i]);
    out.tiles = out.tiles.united(other->tiles);
    out.header.max_probability =
        std::max(out.header.max_probability, other->header.max_probability);
    out.notes.insert(out.notes.end(), other->notes.begin(), other->notes.end());
  }
  out.header.sources = out.tiles.sources();
  return out;
}

TileSet tiles_of(const IceMap& map, const MapSource& source, std::uint64_t version) {
  std::vector<TileItem> items;
  for (const auto& [index, unused] : map.tiles()) {
    const MapTile tile = tile_of(map, index);
    if (tile.seen_cells() > 0) items.push_back(item_in_memory(index, 0, version, tile));
  }
  return {{source}, std::move(items)};
}

}  // namespace watersky
