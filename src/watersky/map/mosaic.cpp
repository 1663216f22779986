// SPDX-License-Identifier: MIT
#include "watersky/map/mosaic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "watersky/map/detail/footprint.hpp"

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

/// A picture shrunk by a whole factor, so that two or three samples along a cell's edge see all of
/// it.
struct Picture {
  cv::Mat image;
  int shrink = 1;
  [[nodiscard]] float scaled(double full_px) const {
    return static_cast<float>((full_px + 0.5) / shrink - 0.5);
  }
};

Picture picture_for(const cv::Mat& image, double pixels_per_cell) {
  const int shrink = std::max(1, static_cast<int>(pixels_per_cell / 1.5));
  const cv::Size size(image.cols / shrink, image.rows / shrink);
  if (shrink == 1 || size.empty()) return {image, 1};
  cv::Mat small;
  cv::resize(image({0, 0, size.width * shrink, size.height * shrink}), small, size, 0, 0,
             cv::INTER_AREA);
  return {small, shrink};
}

/// One sample of each cell of a row of a patch.
struct AlongRow {
  AlongRow() = default;
  AlongRow(const detail::PixelPatch& patch, const Eigen::Vector2d& offset, int row) {
    const double x = offset.x(), y = row + offset.y();
    const auto moved = [&](const std::array<double, 6>& c, std::array<double, 3>& out) {
      out = {c[0] + x * (c[1] + x * c[3] + y * c[4]) + y * (c[2] + y * c[5]),
             c[1] + 2 * x * c[3] + y * c[4], c[3]};
    };
    moved(patch.u, u);
    moved(patch.v, v);
  }
  [[nodiscard]] Pixel at(int i) const {
    return {u[0] + i * (u[1] + i * u[2]), v[0] + i * (v[1] + i * v[2])};
  }
  std::array<double, 3> u{}, v{};
};

}  // namespace

Mosaic::Tile::Tile()
    : bgr(kCellsInTile, cv::Vec3b()),
      distance2_m2(kCellsInTile, std::numeric_limits<float>::infinity()) {}

Status Mosaic::add(const GridView& view, const cv::Mat& image) {
  if (image.depth() != CV_8U || (image.channels() != 1 && image.channels() != 3))
    return Error{ErrorCode::InvalidInput, "a mosaic takes 8-bit images of 1 or 3 channels"};
  if (image.cols != view.camera.width_px() || image.rows != view.camera.height_px())
    return Error{ErrorCode::InvalidInput, "the image's size contradicts the camera"};
  const Picture picture = picture_for(image, view.pixels_per_cell);
  image.channels() == 3 ? lay<3>(view, picture.image, picture.shrink)
                        : lay<1>(view, picture.image, picture.shrink);
  return {};
}

template <int Channels>
void Mosaic::lay(const GridView& view, const cv::Mat& image, int shrink) {
  const Picture picture{image, shrink};
  const int per_edge =
      std::clamp(static_cast<int>(std::lround(view.pixels_per_cell / shrink)), 1, 16);
  const int samples = per_edge * per_edge;
  std::vector<Eigen::Vector2d> offsets;
  for (int k = 0; k < samples; ++k)
    offsets.emplace_back((k % per_edge + 0.5) / per_edge - 0.5,
                         (k / per_edge + 0.5) / per_edge - 0.5);
  std::vector<AlongRow> along(offsets.size());
  const detail::Footprint footprint(view, 1);
  const Eigen::Vector2d middle = view.sea_from_grid.col(2).head<2>() - view.below_north_east_m;
  const Eigen::Vector2d column_m = view.sea_from_grid.col(0).head<2>();
  const Eigen::Vector2d row_m = view.sea_from_grid.col(1).head<2>();
  footprint.for_each([&](const detail::FootprintPart& part) {
    const int first_column = part.first_column(), first_row = part.first_row();
    const TileIndex index{tile_of(first_column), tile_of(first_row)};
    const auto found = tiles_.find(index);
    Tile* tile = found == tiles_.end() ? nullptr : &found->second;
    for (int j = 0; j < part.cells; ++j) {
      const int row = first_row + j;
      const std::size_t line = static_cast<std::size_t>(row - index.row * kTileCells) * kTileCells +
                               static_cast<std::size_t>(first_column - index.column * kTileCells);
      if (!part.exact)
        for (std::size_t k = 0; k < offsets.size(); ++k) along[k] = {part.patch, offsets[k], j};
      for (int i = 0; i < part.cells; ++i) {
        const int column = first_column + i;
        const auto distance =
            static_cast<float>((middle + column * column_m + row * row_m).squaredNorm());
        const std::size_t cell = line + static_cast<std::size_t>(i);
        if (tile && tile->distance2_m2[cell] <= distance) continue;

        std::array<int, 3> sum{};
        int known = 0;
        for (std::size_t k = 0; k < offsets.size(); ++k) {
          Pixel p;
          if (part.exact) {
            const auto seen = footprint.seen(column + offsets[k].x(), row + offsets[k].y());
            if (!seen) continue;
            p = *seen;
          } else {
            p = along[k].at(i);
            if (!part.inside && !view.camera.contains(p)) continue;
            if (part.limited &&
                !footprint.within_limit(column + offsets[k].x(), row + offsets[k].y()))
              continue;
          }
          add_sample<Channels>(picture.image, picture.scaled(p.u), picture.scaled(p.v), sum);
          ++known;
        }
        if (known * 2 < samples || known == 0) continue;
        if (!tile) tile = &tiles_[index];
        tile->distance2_m2[cell] = distance;
        const int scale = known * 1024, half = scale / 2;
        const auto mean = [&](std::size_t k) {
          return static_cast<std::uint8_t>((sum[k] + half) / scale);
        };
        tile->bgr[cell] =
            Channels == 3 ? cv::Vec3b(mean(0), mean(1), mean(2)) : cv::Vec3b::all(mean(0));
      }
    }
  });
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
