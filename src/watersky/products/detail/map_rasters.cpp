// SPDX-License-Identifier: MIT
#include "watersky/products/detail/map_rasters.hpp"

#include <cmath>
#include <limits>

namespace watersky::detail {

namespace {

/// Those that a block of the raster and its neighbour share.
constexpr std::size_t kRecentTiles = 16;

}  // namespace

Result<const MapTile*> MapRasters::tile(const TileIndex& index) {
  for (auto it = recent_.begin(); it != recent_.end(); ++it)
    if (it->first == index) {
      recent_.splice(recent_.begin(), recent_, it);
      return static_cast<const MapTile*>(&it->second);
    }
  if (map_.tiles.of(index).empty()) return static_cast<const MapTile*>(nullptr);
  WATERSKY_TRY(MapTile view, view_tile(map_.tiles, index, map_.view()));
  recent_.emplace_front(index, std::move(view));
  if (recent_.size() > kRecentTiles) recent_.pop_back();
  return static_cast<const MapTile*>(&recent_.front().second);
}

template <class Pixel, class Read>
Result<cv::Mat> MapRasters::read(const CellBox& box, int type, Pixel unseen, const Read& read) {
  cv::Mat out(box.rows, box.columns, type, cv::Scalar(static_cast<double>(unseen)));
  WATERSKY_CHECK(for_each_tile(
      box, [&](const TileIndex& index, const cv::Rect& from, const cv::Rect& to) -> Status {
        WATERSKY_TRY(const MapTile* view, tile(index));
        if (!view) return {};
        for (int r = 0; r < from.height; ++r) {
          Pixel* line = out.ptr<Pixel>(to.y + r) + to.x;
          for (int c = 0; c < from.width; ++c) {
            const MapTile::Block* block = view->block(MapTile::block_of(from.x + c, from.y + r));
            const auto cell =
                static_cast<std::size_t>(MapTile::cell_in_block(from.x + c, from.y + r));
            if (block && block->looks[cell] != 0) line[c] = read(*block, cell);
          }
        }
        return {};
      }));
  return out;
}

Result<cv::Mat> MapRasters::probability(const CellBox& box) {
  const double prior = log_odds(map_.header.prior);
  return read<float>(box, CV_32F, std::numeric_limits<float>::quiet_NaN(),
                     [prior](const MapTile::Block& block, std::size_t cell) {
                       return static_cast<float>(watersky::probability(
                           static_cast<double>(block.evidence[cell]) / kEvidenceUnits + prior));
                     });
}

Result<cv::Mat> MapRasters::looks(const CellBox& box) {
  return read<std::uint16_t>(box, CV_16U, std::uint16_t{0},
                             [](const MapTile::Block& block, std::size_t cell) -> std::uint16_t {
                               return block.looks[cell];
                             });
}

Result<cv::Mat> MapRasters::last_seen_s(const CellBox& box) {
  return read<double>(box, CV_64F, std::numeric_limits<double>::quiet_NaN(),
                      [](const MapTile::Block& block, std::size_t cell) {
                        return to_seconds(block.times[block.seen[cell]]);
                      });
}

}  // namespace watersky::detail
