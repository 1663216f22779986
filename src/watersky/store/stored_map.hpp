// SPDX-License-Identifier: MIT
#pragma once
/// A map as a header and a set of tiles, wherever it lies: what is merged, compared and shown.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "watersky/map/ice_map.hpp"
#include "watersky/store/map_header.hpp"
#include "watersky/store/map_view.hpp"
#include "watersky/store/storage.hpp"
#include "watersky/store/tile_set.hpp"

namespace watersky {

struct StoredMap {
  MapHeader header;
  TileSet tiles;
  std::vector<std::string> notes{};  ///< what was damaged, one sentence each

  [[nodiscard]] MapViewParameters view() const { return MapViewParameters::of(header); }
  /// The same map in the grid of another header; InvalidInput as tiles_between() has it.
  [[nodiscard]] Result<StoredMap> in_grid_of(const MapHeader& other) const;
};

/// The name of the map file in a folder that `watersky map` or `watersky merge` made.
inline constexpr const char* kMapFileName = "map.wsmap";

/// A map file, a folder of `watersky map` or `watersky merge` that holds one, or the folder of a
/// live map. With `recover` what is whole of a damaged file; notes then say what is not.
[[nodiscard]] Result<StoredMap> open_map(Storage& storage, const std::filesystem::path& path,
                                         bool recover = false);

/// The union, in the grid of the first; `names` are for messages. InvalidInput when the maps do not
/// share a grid or a prior.
[[nodiscard]] Result<StoredMap> merge_maps(const std::vector<StoredMap>& maps,
                                           const std::vector<std::string>& names);

/// The tiles of a map in memory, as versions of one source.
[[nodiscard]] TileSet tiles_of(const IceMap& map, const MapSource& source, std::uint64_t version);

}  // namespace watersky
