// SPDX-License-Identifier: MIT
#pragma once
/// What a map on disk says of itself: where its cells lie, how its evidence is to be read, and
/// which flights it is made of.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"
#include "watersky/map/grid_view.hpp"
#include "watersky/map/map_tile.hpp"

namespace watersky {

/// One flight of one aircraft. Its tiles come from it alone, and count once, however often and by
/// whatever way they arrive.
struct MapSource {
  std::string id;                       ///< a UUID, as new_source_id() makes it
  std::string name;                     ///< of the flight, for people
  std::optional<Time> first{}, last{};  ///< of its looks, where known
  bool times_are_utc = true;
  bool operator==(const MapSource&) const = default;
};

/// Random: no two flights ever have the same.
[[nodiscard]] std::string new_source_id();
/// The same for the same text, however often (a UUID of version 5).
[[nodiscard]] std::string source_id_from(std::string_view text);

struct MapHeader {
  std::string projection;  ///< "EPSG:32633", or the text it was made from
  std::string wkt;         ///< of the projection
  /// North-west corner of cell (0, 0); tile (c, r) begins at cell (256 c, 256 r), columns east,
  /// rows south.
  double anchor_easting_m = 0.0;
  double anchor_northing_m = 0.0;
  double cell_m = 0.5;
  double prior = 0.5;              ///< P(ice) of a cell nobody has seen
  double max_probability = 0.999;  ///< evidence is kept within it
  double half_life_s = 0.0;        ///< of what is known of a cell; 0: cells do not forget
  std::vector<MapSource> sources;

  /// Of a source; nullopt when it is not among them.
  [[nodiscard]] std::optional<std::size_t> find_source(std::string_view id) const;
  bool operator==(const MapHeader&) const = default;
};

/// The part of a header that says in which grid the cells lie, in words: for messages.
[[nodiscard]] std::string describe_grid(const MapHeader& header);

/// What has to be added to a tile's index in `from` for the same place in `to`. InvalidInput,
/// saying what differs and how to map anew, when the two do not share a grid and a prior.
[[nodiscard]] Result<TileIndex> tiles_between(const MapHeader& from, const MapHeader& to);

/// JSON, and back; InvalidInput, naming the field.
[[nodiscard]] std::string header_json(const MapHeader& header);
[[nodiscard]] Result<MapHeader> parse_header(std::string_view json);

/// The cells of a tile.
[[nodiscard]] inline CellBox cells_of(const TileIndex& tile) {
  return {tile.column * kTileCells, tile.row * kTileCells, kTileCells, kTileCells};
}

}  // namespace watersky
