// SPDX-License-Identifier: MIT
#pragma once
/// Tiles as flights leave them, for tests of what keeps them.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "watersky/map/map_tile.hpp"
#include "watersky/store/map_header.hpp"

namespace watersky::test {

inline Time at_second(double s) { return *time_from_seconds(s); }

inline MapHeader some_header(const std::string& name = "flight") {
  return {.projection = "EPSG:32633",
          .wkt = "PROJCRS[\"WGS 84 / UTM zone 33N\"]",
          .anchor_easting_m = 433'152.0,
          .anchor_northing_m = 8'760'832.0,
          .cell_m = 0.5,
          .prior = 0.5,
          .max_probability = 0.999,
          .sources = {{.id = "source of " + name, .name = name}}};
}

/// One look at cells of a tile: `evidence` in units of 1/1024.
inline void look(MapTile& tile, int column, int row, int evidence, Time time) {
  MapTile::Block& block = tile.make_block(MapTile::block_of(column, row));
  const auto cell = static_cast<std::size_t>(MapTile::cell_in_block(column, row));
  const std::uint8_t place = block.place_of(time);
  block.seen[cell] = block.looks[cell] == 0 ? place : std::max(block.seen[cell], place);
  block.looks[cell] =
      static_cast<std::uint8_t>(std::min<int>(block.looks[cell] + 1, MapTile::kMostLooks));
  block.evidence[cell] =
      static_cast<std::int16_t>(std::clamp(block.evidence[cell] + evidence, -7072, 7072));
}

/// A rectangle of cells seen in one frame, their evidence noise about `mean`.
inline void frame(MapTile& tile, std::mt19937& random, int column, int row, int columns, int rows,
                  double mean, Time time) {
  std::normal_distribution<double> noise(mean, 400.0);
  for (int r = std::max(row, 0); r < std::min(row + rows, kTileCells); ++r)
    for (int c = std::max(column, 0); c < std::min(column + columns, kTileCells); ++c)
      look(tile, c, r, static_cast<int>(std::lround(noise(random))), time);
}

/// Some frames at random places of a tile.
inline MapTile some_tile(unsigned seed, int frames = 3) {
  std::mt19937 random(seed);
  MapTile tile;
  for (int i = 0; i < frames; ++i)
    frame(tile, random, std::uniform_int_distribution(-20, 230)(random),
          std::uniform_int_distribution(-20, 230)(random), 70, 50, i % 2 == 0 ? 900 : -900,
          at_second(1000.0 + i + seed));
  return tile;
}

}  // namespace watersky::test
