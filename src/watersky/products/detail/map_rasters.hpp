// SPDX-License-Identifier: MIT
#pragma once
/// A stored map's cells as rasters, a part at a time.
#include <list>
#include <utility>

#include "watersky/io/geotiff_stream.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/store/stored_map.hpp"

namespace watersky::detail {

/// Reads parts of a map; remembers the tiles that it read last.
class MapRasters {
 public:
  explicit MapRasters(const StoredMap& map) : map_(map) {}

  [[nodiscard]] Result<cv::Mat> probability(const CellBox& box);  ///< CV_32F, NaN unseen
  [[nodiscard]] Result<cv::Mat> looks(const CellBox& box);        ///< CV_16U, 0 unseen
  [[nodiscard]] Result<cv::Mat> last_seen_s(const CellBox& box);  ///< CV_64F, NaN unseen

 private:
  template <class Pixel, class Read>
  Result<cv::Mat> read(const CellBox& box, int type, Pixel unseen, const Read& read);
  [[nodiscard]] Result<const MapTile*> tile(const TileIndex& index);

  const StoredMap& map_;
  std::list<std::pair<TileIndex, MapTile>> recent_;  ///< the latest first
};

/// Calls `body(index, part of the tile's cells, part of the box's)` for each tile that a box meets.
template <class Body>
Status for_each_tile(const CellBox& box, const Body& body) {
  for (int r = tile_of(box.first_row); r <= tile_of(box.end_row() - 1); ++r)
    for (int c = tile_of(box.first_column); c <= tile_of(box.end_column() - 1); ++c) {
      const cv::Rect cells(c * kTileCells, r * kTileCells, kTileCells, kTileCells);
      const cv::Rect met = cells & cv::Rect(box.first_column, box.first_row, box.columns, box.rows);
      WATERSKY_CHECK(body(TileIndex{c, r}, met - cv::Point(cells.x, cells.y),
                          met - cv::Point(box.first_column, box.first_row)));
    }
  return {};
}

/// A part of a raster whose north-west cell is that of `box`.
[[nodiscard]] inline CellBox part_of(const CellBox& box, const cv::Rect& part) {
  return {box.first_column + part.x, box.first_row + part.y, part.width, part.height};
}

}  // namespace watersky::detail
