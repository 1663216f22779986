// SPDX-License-Identifier: MIT
#include "watersky/map/mosaic.hpp"

#include <cmath>

#include "watersky/map/detail/cell_sampler.hpp"

namespace watersky {

namespace {

constexpr std::size_t kCellsInTile = static_cast<std::size_t>(kTileCells) * kTileCells;

/// Sums the bilinear reading of an 8-bit image in fixed point (1/32 pixel).
template <int Channels>
void add_sample(const cv::Mat& image, float u, float v, std::array<int, 3>& sum) {
  constexpr int kOne = 32;
  const int fixed_u = std::clamp(static_cast<int>(u * kOne + 0.5F), 0, (image.cols - 1) * kOne);
  const int fixed_v = std::clamp(static_cast<int>(v * kOne + 0.5F), 0, (image.rows - 1) * kOne);
  const int iu = fixed_u / kOne, iv = fixed_v / kOne, fu = fixed_u % kOne, fv = fixed_v % kOne;
  const std::uint8_t* p = image.ptr<std::uint8_t>(iv) + iu * Channels;
  const int right = fu == 0 ? 0 : Channels;
  const std::ptrdiff_t down = fv == 0 ? 0 : static_cast<std::ptrdiff_t>(image.step[0]);
  for (int k = 0; k < Channels; ++k) {
    const int top = p[k] * (kOne - fu) + p[k + right] * fu;
    const int bottom = p[k + down] * (kOne - fu) + p[k + down + right] * fu;
    sum[static_cast<std::size_t>(k)] += top * (kOne - fv) + bottom * fv;
  }
}

}  // namespace

Mosaic::Tile::Tile()
    : bgr(kCellsInTile, cv::Vec3b()),
      distance2_m2(kCellsInTile, std::numeric_limits<float>::infinity()) {}

Status Mosaic::add(const GridView& view, const cv::Mat& image) {
  if (image.depth() != CV_8U || (image.channels() != 1 && image.channels() != 3))
    return Error{ErrorCode::InvalidInput, "a mosaic takes 8-bit images of 1 or 3 channels"};
  if (image.cols != view.camera.width_px() || image.rows != view.camera.height_px())
    return Error{ErrorCode::InvalidInput, "the image's size contradicts the camera"};
  const bool color = image.channels() == 3;
  CellSampler sampler(view, 0);
  const int samples = sampler.samples_per_cell();
  for (int r = view.box.first_row; r < view.box.end_row(); ++r) {
    const CellSampler::Row row = sampler.row(r);
    if (row.columns == 0) continue;
    const Eigen::Vector2d first =
        (view.sea_from_grid * Eigen::Vector3d(row.first_column, r, 1.0)).head<2>() -
        view.below_north_east_m;
    const Eigen::Vector2d step = view.sea_from_grid.col(0).head<2>();
    int tile_column = std::numeric_limits<int>::min();
    Tile* tile = nullptr;
    const std::size_t line = static_cast<std::size_t>(r - tile_of(r) * kTileCells) * kTileCells;
    for (int i = 0; i < row.columns; ++i) {
      const int column = row.first_column + i;
      const auto distance = static_cast<float>((first + i * step).squaredNorm());
      if (const int t = tile_of(column); t != tile_column) {
        tile_column = t;
        const auto found = tiles_.find(TileIndex{t, tile_of(r)});
        tile = found == tiles_.end() ? nullptr : &found->second;
      }
      const std::size_t cell = line + static_cast<std::size_t>(column - tile_column * kTileCells);
      if (tile && tile->distance2_m2[cell] <= distance) continue;

      std::array<int, 3> sum{};
      int known = 0;
      for (int k = 0; k < samples; ++k) {
        const float u = row.u_plane(k)[i], v = row.v_plane(k)[i];
        if (u == CellSampler::kUnseen) continue;
        color ? add_sample<3>(image, u, v, sum) : add_sample<1>(image, u, v, sum);
        ++known;
      }
      if (known * 2 < samples || known == 0) continue;
      if (!tile) tile = &tiles_[TileIndex{tile_column, tile_of(r)}];
      tile->distance2_m2[cell] = distance;
      const int scale = known * 1024, half = scale / 2;
      const auto mean = [&](std::size_t k) {
        return static_cast<std::uint8_t>((sum[k] + half) / scale);
      };
      tile->bgr[cell] = color ? cv::Vec3b(mean(0), mean(1), mean(2)) : cv::Vec3b::all(mean(0));
    }
  }
  return {};
}

cv::Mat Mosaic::bgra(const CellBox& box) const {
  cv::Mat_<cv::Vec4b> out(std::max(0, box.rows), std::max(0, box.columns), cv::Vec4b());
  for (const auto& [index, tile] : tiles_) {
    const int column0 = index.column * kTileCells, row0 = index.row * kTileCells;
    const int c_from = std::max(column0, box.first_column),
              c_to = std::min(column0 + kTileCells, box.end_column());
    const int r_from = std::max(row0, box.first_row),
              r_to = std::min(row0 + kTileCells, box.end_row());
    for (int r = r_from; r < r_to; ++r)
      for (int c = c_from; c < c_to; ++c) {
        const std::size_t cell =
            static_cast<std::size_t>(r - row0) * kTileCells + static_cast<std::size_t>(c - column0);
        if (!std::isfinite(tile.distance2_m2[cell])) continue;
        const cv::Vec3b& p = tile.bgr[cell];
        out(r - box.first_row, c - box.first_column) = {p[0], p[1], p[2], 255};
      }
  }
  return cv::Mat(out);
}

CellBox Mosaic::seen() const {
  CellBox all;
  for (const auto& [index, tile] : tiles_)
    all = all.united({index.column * kTileCells, index.row * kTileCells, kTileCells, kTileCells});
  return all;
}

}  // namespace watersky
