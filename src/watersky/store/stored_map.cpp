// SPDX-License-Identifier: MIT
#include "watersky/store/stored_map.hpp"

#include <algorithm>

#include "watersky/store/map_file.hpp"
#include "watersky/store/map_store.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

StoredMap stored(const MapFile& file) { return {file.header(), file.tiles(), file.notes()}; }

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
    // The more forgetful of the two decides: it knows that its ice moves.
    const double half_life_s = other->header.half_life_s;
    if (half_life_s > 0 && (out.header.half_life_s == 0 || half_life_s < out.header.half_life_s))
      out.header.half_life_s = half_life_s;
    out.notes.insert(out.notes.end(), other->notes.begin(), other->notes.end());
  }
  out.header.sources = out.tiles.sources();
  return out;
}

TileSet tiles_of(const IceMap& map, const MapSource& source, std::uint64_t version) {
  std::vector<TileItem> items;
  for (const auto& [index, of_map] : map.tiles())
    if (of_map.tile.seen_cells() > 0)
      items.push_back(item_in_memory(index, 0, version, of_map.tile));
  return {{source}, std::move(items)};
}

}  // namespace watersky
