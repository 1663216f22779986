// SPDX-License-Identifier: MIT
#include "watersky/map/ice_map.hpp"

#include <cmath>

#include "watersky/map/detail/cell_sampler.hpp"

namespace watersky {

namespace {

constexpr std::size_t kCellsInTile = static_cast<std::size_t>(kTileCells) * kTileCells;

/// Bilinear reading of a float image with its edge pixels extended outwards.
class EvidenceImage {
 public:
  explicit EvidenceImage(const cv::Mat& image)
      : data_(image.ptr<float>()),
        stride_(image.step1()),
        max_u_(static_cast<float>(image.cols - 1)),
        max_v_(static_cast<float>(image.rows - 1)),
        last_u_(image.cols > 1 ? image.cols - 2 : 0),
        last_v_(image.rows > 1 ? image.rows - 2 : 0),
        next_u_(image.cols > 1 ? 1 : 0),
        next_v_(image.rows > 1 ? stride_ : 0) {}

  [[nodiscard]] float at(float u, float v) const {
    u = std::min(std::max(u, 0.0F), max_u_);
    v = std::min(std::max(v, 0.0F), max_v_);
    const int iu = std::min(static_cast<int>(u), last_u_);
    const int iv = std::min(static_cast<int>(v), last_v_);
    const float fu = u - static_cast<float>(iu), fv = v - static_cast<float>(iv);
    const float* p = data_ + static_cast<std::size_t>(iv) * stride_ + iu;
    const float top = p[0] + fu * (p[next_u_] - p[0]);
    const float bottom =
        p[next_v_] + fu * (p[next_v_ + static_cast<std::size_t>(next_u_)] - p[next_v_]);
    return top + fv * (bottom - top);
  }

  /// Adds the values at a line of positions, and counts those that are known.
  void add_line(const float* u, const float* v, int count, float* sum, int* known) const {
    for (int i = 0; i < count; ++i) {
      if (u[i] == CellSampler::kUnseen) continue;
      const float value = at(u[i], v[i]);
      const bool is_known = value == value;
      sum[i] += is_known ? value : 0.0F;
      known[i] += is_known;
    }
  }

 private:
  const float* data_;
  std::size_t stride_;
  float max_u_, max_v_;
  int last_u_, last_v_, next_u_;
  std::size_t next_v_;
};

/// Copies the part of each tile that lies in `box` into a raster, cell by cell.
template <class Pixel, class Read>
cv::Mat raster(const std::map<TileIndex, IceMap::Tile>& tiles, const CellBox& box, Pixel unseen,
               const Read& read) {
  cv::Mat_<Pixel> out(std::max(0, box.rows), std::max(0, box.columns), unseen);
  for (const auto& [index, tile] : tiles) {
    const int column0 = index.column * kTileCells, row0 = index.row * kTileCells;
    const int c_from = std::max(column0, box.first_column),
              c_to = std::min(column0 + kTileCells, box.end_column());
    const int r_from = std::max(row0, box.first_row),
              r_to = std::min(row0 + kTileCells, box.end_row());
    for (int r = r_from; r < r_to; ++r) {
      Pixel* to = out[r - box.first_row];
      const std::size_t line = static_cast<std::size_t>(r - row0) * kTileCells;
      for (int c = c_from; c < c_to; ++c) {
        const std::size_t cell = line + static_cast<std::size_t>(c - column0);
        if (tile.looks[cell] != 0) to[c - box.first_column] = read(tile, cell);
      }
    }
  }
  return cv::Mat(out);
}

}  // namespace

IceMap::Tile::Tile()
    : evidence(kCellsInTile, 0.0F),
      looks(kCellsInTile, 0),
      last_seen_s(kCellsInTile, std::numeric_limits<double>::quiet_NaN()) {}

IceMap::IceMap(const MapParameters& parameters)
    : parameters_(parameters),
      prior_log_odds_(static_cast<float>(watersky::log_odds(parameters.prior))) {}

Result<IceMap> IceMap::make(const MapParameters& parameters) {
  WATERSKY_CHECK(validate(parameters));
  if (parameters.prior > parameters.max_probability ||
      parameters.prior < 1 - parameters.max_probability)
    return Error{ErrorCode::Usage, "prior lies outside what max_probability allows"};
  return IceMap(parameters);
}

Result<std::size_t> IceMap::update(const GridView& view, const cv::Mat& evidence, Time time) {
  if (evidence.type() != CV_32F || evidence.cols != view.camera.width_px() ||
      evidence.rows != view.camera.height_px())
    return Error{ErrorCode::InvalidInput, "evidence of " + std::to_string(evidence.cols) + "x" +
                                              std::to_string(evidence.rows) +
                                              " pixels for a camera of " +
                                              std::to_string(view.camera.width_px()) + "x" +
                                              std::to_string(view.camera.height_px())};
  CellSampler sampler(view, parameters_.supersampling);
  const EvidenceImage image(evidence);
  const int samples = sampler.samples_per_cell();
  const auto limit = static_cast<float>(watersky::log_odds(parameters_.max_probability));
  const float lowest = -limit - prior_log_odds_, highest = limit - prior_log_odds_;
  const double time_s = to_seconds(time);

  std::vector<float> sums;
  std::vector<int> knowns;
  std::size_t touched = 0;
  for (int r = view.box.first_row; r < view.box.end_row(); ++r) {
    const CellSampler::Row row = sampler.row(r);
    if (row.columns == 0) continue;
    sums.assign(static_cast<std::size_t>(row.columns), 0.0F);
    knowns.assign(static_cast<std::size_t>(row.columns), 0);
    for (int k = 0; k < samples; ++k)
      image.add_line(row.u_plane(k), row.v_plane(k), row.columns, sums.data(), knowns.data());

    int tile_column = std::numeric_limits<int>::min();
    Tile* tile = nullptr;
    const std::size_t line = static_cast<std::size_t>(r - tile_of(r) * kTileCells) * kTileCells;
    for (int i = 0; i < row.columns; ++i) {
      const int known = knowns[static_cast<std::size_t>(i)];
      if (known * 2 < samples || known == 0) continue;
      const int column = row.first_column + i;
      if (const int t = tile_of(column); t != tile_column) {
        tile_column = t;
        tile = &tiles_[TileIndex{t, tile_of(r)}];
      }
      const std::size_t cell = line + static_cast<std::size_t>(column - tile_column * kTileCells);
      ++touched;
      float& l = tile->evidence[cell];
      l = std::clamp(l + sums[static_cast<std::size_t>(i)] / static_cast<float>(known), lowest,
                     highest);
      std::uint16_t& looks = tile->looks[cell];
      if (looks != std::numeric_limits<std::uint16_t>::max()) ++looks;
      double& seen = tile->last_seen_s[cell];
      if (!(seen >= time_s)) seen = time_s;
    }
  }
  return touched;
}

void IceMap::predict(const CellDynamics& dynamics, double elapsed_s) {
  for (auto& [index, tile] : tiles_) {
    for (std::size_t i = 0; i < kCellsInTile; ++i) {
      if (tile.looks[i] == 0) continue;
      const double p =
          watersky::probability(static_cast<double>(tile.evidence[i] + prior_log_odds_));
      tile.evidence[i] =
          static_cast<float>(watersky::log_odds(dynamics.predict(p, elapsed_s))) - prior_log_odds_;
    }
  }
}

CellBox IceMap::seen() const {
  CellBox all;
  for (const auto& [index, tile] : tiles_) {
    int c0 = kTileCells, c1 = -1, r0 = kTileCells, r1 = -1;
    for (int r = 0; r < kTileCells; ++r)
      for (int c = 0; c < kTileCells; ++c)
        if (tile.looks[static_cast<std::size_t>(r) * kTileCells + static_cast<std::size_t>(c)] !=
            0) {
          c0 = std::min(c0, c), c1 = std::max(c1, c);
          r0 = std::min(r0, r), r1 = std::max(r1, r);
        }
    if (c1 < 0) continue;
    all = all.united(
        {index.column * kTileCells + c0, index.row * kTileCells + r0, c1 - c0 + 1, r1 - r0 + 1});
  }
  return all;
}

cv::Mat IceMap::probability(const CellBox& box) const {
  return raster<float>(tiles_, box, std::numeric_limits<float>::quiet_NaN(),
                       [&](const Tile& tile, std::size_t cell) {
                         return 1.0F / (1.0F + std::exp(-(tile.evidence[cell] + prior_log_odds_)));
                       });
}

cv::Mat IceMap::log_odds(const CellBox& box) const {
  return raster<float>(tiles_, box, prior_log_odds_, [&](const Tile& tile, std::size_t cell) {
    return tile.evidence[cell] + prior_log_odds_;
  });
}

cv::Mat IceMap::looks(const CellBox& box) const {
  return raster<std::uint16_t>(tiles_, box, 0,
                               [](const Tile& tile, std::size_t cell) { return tile.looks[cell]; });
}

cv::Mat IceMap::last_seen_s(const CellBox& box) const {
  return raster<double>(tiles_, box, std::numeric_limits<double>::quiet_NaN(),
                        [](const Tile& tile, std::size_t cell) { return tile.last_seen_s[cell]; });
}

}  // namespace watersky
