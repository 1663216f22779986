// SPDX-License-Identifier: MIT
#include "watersky/ice/detail/gap.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace watersky::ice::detail {

namespace {

// Distance above, label below, in one number: the smaller number is the nearer piece.
using Key = std::uint64_t;
constexpr double kUnitsPerCell = 8192;
constexpr Key weight(double cells) { return static_cast<Key>(cells * kUnitsPerCell + 0.5) << 32; }
constexpr Key kEdge = weight(1.0);
constexpr Key kDiagonal = weight(1.4);
constexpr Key kKnight = weight(2.1969);
constexpr Key kFar = Key{0x3fffffff} << 32;
constexpr int kBorder = 2;

std::uint32_t label_of(Key key) { return static_cast<std::uint32_t>(key); }
double cells_of(Key key) { return static_cast<double>(key >> 32) / kUnitsPerCell; }

}  // namespace

std::vector<float> gaps_cells(const cv::Mat& pieces, int labels) {
  const int width = pieces.cols;
  const int height = pieces.rows;
  const std::ptrdiff_t stride = width + 2 * kBorder;
  std::vector<Key> keys(
      static_cast<std::size_t>(stride) * static_cast<std::size_t>(height + 2 * kBorder), kFar);
  const auto row = [&](int r) { return keys.data() + (r + kBorder) * stride + kBorder; };

  for (int r = 0; r < height; ++r) {
    const int* piece = pieces.ptr<int>(r);
    Key* here = row(r);
    const Key* up = here - stride;
    const Key* up2 = up - stride;
    for (int c = 0; c < width; ++c) {
      const Key own = piece[c] != 0 ? static_cast<Key>(piece[c]) : kFar;
      const Key edge = up[c] + kEdge;
      const Key diagonal = std::min(up[c - 1], up[c + 1]) + kDiagonal;
      const Key knight =
          std::min(std::min(up2[c - 1], up2[c + 1]), std::min(up[c - 2], up[c + 2])) + kKnight;
      here[c] = std::min(std::min(own, edge), std::min(diagonal, knight));
    }
    // Along the row by itself: the rest of the row then does not wait for it.
    for (int c = 0; c < width; ++c) here[c] = std::min(here[c], here[c - 1] + kEdge);
  }

  std::vector<float> gaps(static_cast<std::size_t>(labels), std::numeric_limits<float>::infinity());
  const auto meet = [&](Key a, Key b) {
    if (label_of(a) == label_of(b)) return;
    const float gap = static_cast<float>(cells_of(a) + cells_of(b));
    gaps[label_of(a)] = std::min(gaps[label_of(a)], gap);
    gaps[label_of(b)] = std::min(gaps[label_of(b)], gap);
  };
  for (int r = height - 1; r >= 0; --r) {
    Key* here = row(r);
    const Key* down = here + stride;
    const Key* down2 = down + stride;
    for (int c = 0; c < width; ++c) {
      const Key edge = down[c] + kEdge;
      const Key diagonal = std::min(down[c - 1], down[c + 1]) + kDiagonal;
      const Key knight =
          std::min(std::min(down2[c - 1], down2[c + 1]), std::min(down[c - 2], down[c + 2])) +
          kKnight;
      here[c] = std::min(std::min(here[c], edge), std::min(diagonal, knight));
    }
    for (int c = width - 1; c >= 0; --c) here[c] = std::min(here[c], here[c + 1] + kEdge);
    for (int c = 0; c + 1 < width; ++c) meet(here[c], here[c + 1]);
    if (r + 1 < height)
      for (int c = 0; c < width; ++c) meet(here[c], down[c]);
  }
  return gaps;
}

}  // namespace watersky::ice::detail
