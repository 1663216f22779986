// SPDX-License-Identifier: MIT
#include "watersky/map/ice_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "watersky/map/detail/cell_decay.hpp"
#include "watersky/map/detail/footprint_update.hpp"

namespace watersky {

namespace {

constexpr int kBlock = MapTile::kBlockCells;

/// Calls for each block of a tile, with its first column and row in the grid.
template <class Use>
void for_each_block(const TileIndex& index, const MapTile& tile, const Use& use) {
  for (int b = 0; b < MapTile::kBlocks * MapTile::kBlocks; ++b)
    if (const MapTile::Block* block = tile.block(b))
      use(index.column * kTileCells + b % MapTile::kBlocks * kBlock,
          index.row * kTileCells + b / MapTile::kBlocks * kBlock, *block);
}

/// Copies the seen cells that lie in `box` into a raster. `reader_of(block)` gives what reads a
/// cell of it.
template <class Pixel, class ReaderOf>
cv::Mat raster(const IceMap::Tiles& tiles, const CellBox& box, Pixel unseen,
               const ReaderOf& reader_of) {
  cv::Mat_<Pixel> out(std::max(0, box.rows), std::max(0, box.columns), unseen);
  if (box.empty()) return cv::Mat(out);
  const auto copy = [&](int column0, int row0, const MapTile::Block& block) {
    const int c_from = std::max(column0, box.first_column),
              c_to = std::min(column0 + kBlock, box.end_column());
    const int r_from = std::max(row0, box.first_row), r_to = std::min(row0 + kBlock, box.end_row());
    if (c_from >= c_to || r_from >= r_to) return;
    const auto read = reader_of(block);
    for (int r = r_from; r < r_to; ++r) {
      Pixel* to = out[r - box.first_row];
      for (int c = c_from; c < c_to; ++c) {
        const auto cell = static_cast<std::size_t>((r - row0) * kBlock + (c - column0));
        if (block.looks[cell] != 0) to[c - box.first_column] = static_cast<Pixel>(read(cell));
      }
    }
  };
  // A small piece of a large map asks for its tiles, a large piece of a small one goes over them.
  const TileIndex first{tile_of(box.first_column), tile_of(box.first_row)};
  const TileIndex last{tile_of(box.end_column() - 1), tile_of(box.end_row() - 1)};
  if (1.0 * (last.column - first.column + 1) * (last.row - first.row + 1) >
      static_cast<double>(tiles.size())) {
    for (const auto& [index, versioned] : tiles) for_each_block(index, versioned.tile, copy);
    return cv::Mat(out);
  }
  for (int row = first.row; row <= last.row; ++row)
    for (int column = first.column; column <= last.column; ++column)
      if (const auto found = tiles.find({column, row}); found != tiles.end())
        for_each_block(found->first, found->second.tile, copy);
  return cv::Mat(out);
}

/// Reads log-odds minus the prior's, at the map's clock.
auto evidence_reader(const MapTile::Block& block, const std::optional<IceMap::Decay>& decay,
                     const std::optional<Time>& clock) {
  std::optional<detail::CellDecay> forget;
  if (decay && clock) forget.emplace(decay->dynamics, decay->from, *clock, block.times);
  return [&block, forget = std::move(forget)](std::size_t cell) {
    const double e = static_cast<double>(block.evidence[cell]) / kEvidenceUnits;
    return static_cast<float>(forget ? (*forget)(e, block.seen[cell]) : e);
  };
}

/// 0 to 1, another for every cell and time; as even as a hash is.
double dither(std::size_t cell, Time time) {
  auto x = static_cast<std::uint64_t>(time.time_since_epoch().count()) * 0x9E3779B97F4A7C15U + cell;
  x = (x ^ x >> 30U) * 0xBF58476D1CE4E5B9U;
  x = (x ^ x >> 27U) * 0x94D049BB133111EBU;
  return (static_cast<double>(x >> 40U) + 0.5) * 0x1p-24;
}

}  // namespace

IceMap::IceMap(const MapParameters& parameters)
    : parameters_(parameters),
      prior_log_odds_(static_cast<float>(watersky::log_odds(parameters.prior))),
      update_(std::make_unique<detail::FootprintUpdate>()) {}

IceMap::IceMap(const IceMap& other)
    : parameters_(other.parameters_),
      prior_log_odds_(other.prior_log_odds_),
      tiles_(other.tiles_),
      decay_(other.decay_),
      clock_(other.clock_),
      updates_(other.updates_),
      update_(std::make_unique<detail::FootprintUpdate>()) {}

IceMap& IceMap::operator=(const IceMap& other) {
  if (this != &other) *this = IceMap(other);
  return *this;
}

IceMap::IceMap(IceMap&&) noexcept = default;
IceMap& IceMap::operator=(IceMap&&) noexcept = default;
IceMap::~IceMap() = default;

std::string_view update_instructions() { return detail::update_kernels().name; }

Result<IceMap> IceMap::make(const MapParameters& parameters) {
  WATERSKY_CHECK(validate(parameters));
  if (parameters.prior > parameters.max_probability ||
      parameters.prior < 1 - parameters.max_probability)
    return Error{ErrorCode::Usage, "prior lies outside what max_probability allows"};
  IceMap map(parameters);
  if (parameters.half_life_s > 0)
    WATERSKY_CHECK(
        map.forget(CellDynamics::with_half_life(parameters.half_life_s, parameters.prior), Time{}));
  return map;
}

void IceMap::set_tile(const TileIndex& index, MapTile tile, std::uint64_t version) {
  VersionedTile& to = tiles_[index];
  to.tile = std::move(tile);
  to.version = version;
  to.touched_in = 0;
  for (int b = 0; b < MapTile::kBlocks * MapTile::kBlocks; ++b)
    if (const MapTile::Block* block = to.tile.block(b); block && !block->times.empty())
      predict(block->times.back());
}

std::size_t IceMap::bytes() const {
  // A node of the hash holds its key, a pointer and the tile; the hash a pointer for each.
  std::size_t size = sizeof(IceMap) + tiles_.bucket_count() * sizeof(void*);
  for (const auto& [index, versioned] : tiles_)
    size += versioned.tile.bytes() + sizeof(std::pair<const TileIndex, VersionedTile>) -
            sizeof(MapTile) + 2 * sizeof(void*);
  return size;
}

Result<std::size_t> IceMap::update(const GridView& view, const cv::Mat& evidence, Time time) {
  return update(view, Evidence::of_log_odds(evidence), time);
}

Result<std::size_t> IceMap::update(const GridView& view, const Evidence& evidence, Time time) {
  WATERSKY_CHECK(evidence.check());
  const auto size_of = [](int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
  };
  const cv::Mat& image = evidence.image();
  if (image.cols != view.camera.width_px() || image.rows != view.camera.height_px())
    return Error{ErrorCode::InvalidInput,
                 "evidence of " + size_of(image.cols, image.rows) + " pixels for a camera of " +
                     size_of(view.camera.width_px(), view.camera.height_px())};
  constexpr int kMost = detail::EvidenceLevels::kMostPixels;
  if (image.cols > kMost || image.rows > kMost)
    return Error{ErrorCode::InvalidInput, "evidence of " + size_of(image.cols, image.rows) +
                                              " pixels; map at most " + size_of(kMost, kMost) +
                                              " at once, in pieces or reduced"};
  const double limit = watersky::log_odds(parameters_.max_probability);
  const auto units = [&](double log_odds) {
    return static_cast<std::int16_t>(std::clamp<long>(
        std::lround((log_odds - static_cast<double>(prior_log_odds_)) * kEvidenceUnits),
        -kMostEvidence, kMostEvidence));
  };
  const detail::LookLimits limits{units(-limit), units(limit), parameters_.supersampling};

  ++updates_;
  std::optional<TileIndex> index;
  VersionedTile* tile = nullptr;
  const detail::BlockAt block_at = [&](int column, int row,
                                       const std::uint8_t* cells) -> MapTile::Block& {
    const TileIndex here{tile_of(column * kBlock), tile_of(row * kBlock)};
    if (here != index) {
      index = here;
      tile = &tiles_[here];
      if (tile->touched_in != updates_) ++tile->version;
      tile->touched_in = updates_;
    }
    MapTile::Block& block =
        tile->tile.make_block(MapTile::block_of((column - here.column * MapTile::kBlocks) * kBlock,
                                                (row - here.row * MapTile::kBlocks) * kBlock));
    if (decay_ && !block.times.empty()) bring_forward(block, time, cells);
    return block;
  };
  const std::size_t touched = update_->run(view, evidence, time, limits, block_at);
  if (touched > 0) predict(time);
  return touched;
}

/// Rounded by a dither of each cell and time: what decays by less than a unit between two looks
/// still decays.
void IceMap::bring_forward(MapTile::Block& block, Time time, const std::uint8_t* cells) const {
  const detail::CellDecay forget(decay_->dynamics, decay_->from, time, block.times);
  for (std::size_t cell = 0; cell < block.looks.size(); ++cell) {
    if (block.looks[cell] == 0 || (cells != nullptr && cells[cell] == 0)) continue;
    const double before = static_cast<double>(block.evidence[cell]) / kEvidenceUnits;
    const double after = forget(before, block.seen[cell]);
    if (after != before)
      block.evidence[cell] =
          static_cast<std::int16_t>(std::floor(after * kEvidenceUnits + dither(cell, time)));
  }
}

Status IceMap::forget(const CellDynamics& dynamics, Time from) {
  if (!(std::abs(dynamics.stationary() - parameters_.prior) <= 1e-6))
    return Error{ErrorCode::InvalidInput, "the map's prior " + std::to_string(parameters_.prior) +
                                              " is not the stationary probability " +
                                              std::to_string(dynamics.stationary()) +
                                              " of the dynamics; use that as the map's prior"};
  decay_ = Decay{dynamics, from};
  return {};
}

void IceMap::predict(Time now) { clock_ = clock_ ? std::max(*clock_, now) : now; }

CellBox IceMap::seen() const {
  CellBox all;
  const auto extend = [&](int column0, int row0, const MapTile::Block& block) {
    int c0 = kBlock, c1 = -1, r0 = kBlock, r1 = -1;
    for (int r = 0; r < kBlock; ++r)
      for (int c = 0; c < kBlock; ++c)
        if (block.looks[static_cast<std::size_t>(r * kBlock + c)] != 0) {
          c0 = std::min(c0, c), c1 = std::max(c1, c);
          r0 = std::min(r0, r), r1 = std::max(r1, r);
        }
    if (c1 >= 0) all = all.united({column0 + c0, row0 + r0, c1 - c0 + 1, r1 - r0 + 1});
  };
  for (const auto& [index, versioned] : tiles_) for_each_block(index, versioned.tile, extend);
  return all;
}

cv::Mat IceMap::probability(const CellBox& box) const {
  return raster<float>(
      tiles_, box, std::numeric_limits<float>::quiet_NaN(), [&](const MapTile::Block& block) {
        return [read = evidence_reader(block, decay_, clock_), this](std::size_t cell) {
          return 1.0F / (1.0F + std::exp(-(read(cell) + prior_log_odds_)));
        };
      });
}

cv::Mat IceMap::log_odds(const CellBox& box) const {
  return raster<float>(tiles_, box, prior_log_odds_, [&](const MapTile::Block& block) {
    return [read = evidence_reader(block, decay_, clock_), this](std::size_t cell) {
      return read(cell) + prior_log_odds_;
    };
  });
}

cv::Mat IceMap::looks(const CellBox& box) const {
  return raster<std::uint16_t>(tiles_, box, 0, [](const MapTile::Block& block) {
    return [&block](std::size_t cell) { return block.looks[cell]; };
  });
}

cv::Mat IceMap::last_seen_s(const CellBox& box) const {
  return raster<double>(
      tiles_, box, std::numeric_limits<double>::quiet_NaN(), [](const MapTile::Block& block) {
        return [&block](std::size_t cell) { return to_seconds(block.times[block.seen[cell]]); };
      });
}

}  // namespace watersky
