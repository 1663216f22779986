// SPDX-License-Identifier: MIT
#include "watersky/sim/detail/sea_index.hpp"

#include <algorithm>

namespace watersky::sim {
namespace {

/// Whether a segment touches a square, by the separating axes of both; grown by a millionth of
/// the square against rounding.
bool touches(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& centre,
             double half) {
  half *= 1.0 + 1e-6;
  const Eigen::Vector2d mid = 0.5 * (a + b) - centre, reach = 0.5 * (b - a).cwiseAbs();
  if (std::abs(mid.x()) > half + reach.x() || std::abs(mid.y()) > half + reach.y()) return false;
  const Eigen::Vector2d normal(-(b - a).y(), (b - a).x());
  return std::abs(normal.dot(mid)) <= half * (std::abs(normal.x()) + std::abs(normal.y()));
}

}  // namespace

SeaIndex::SeaIndex(const std::vector<Outline>& pieces, const std::vector<int>& owners,
                   const Eigen::Vector2d& south_west, const Eigen::Vector2d& extent_m,
                   double cell_m)
    : south_(south_west.x()),
      west_(south_west.y()),
      cells_per_m_(1.0 / cell_m),
      rows_(std::max(1, static_cast<int>(std::ceil(extent_m.x() / cell_m)))),
      columns_(std::max(1, static_cast<int>(std::ceil(extent_m.y() / cell_m)))) {
  const std::size_t count = static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_);
  cells_.assign(count, -2 - kWater);
  const auto at = [&](int r, int c) {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(c);
  };
  const auto row_of = [&](double north) {
    return std::clamp(static_cast<int>(std::floor((north - south_) * cells_per_m_)), 0, rows_ - 1);
  };
  const auto column_of = [&](double east) {
    return std::clamp(static_cast<int>(std::floor((east - west_) * cells_per_m_)), 0, columns_ - 1);
  };

  struct Touch {
    std::size_t cell;
    Edge edge;
  };
  std::vector<Touch> touching;
  std::vector<double> crossings;
  for (std::size_t piece = 0; piece < pieces.size(); ++piece) {
    const Outline& outline = pieces[piece];
    Eigen::Vector2d low = outline[0], high = outline[0];
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d& a = outline[i];
      const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
      low = low.cwiseMin(a);
      high = high.cwiseMax(a);
      // One cell more on each side: an edge along a border belongs to both neighbours.
      const int r1 = std::min(rows_ - 1, row_of(std::max(a.x(), b.x())) + 1);
      const int c1 = std::min(columns_ - 1, column_of(std::max(a.y(), b.y())) + 1);
      for (int r = std::max(0, row_of(std::min(a.x(), b.x())) - 1); r <= r1; ++r)
        for (int c = std::max(0, column_of(std::min(a.y(), b.y())) - 1); c <= c1; ++c) {
          const Eigen::Vector2d centre(south_ + (r + 0.5) * cell_m, west_ + (c + 0.5) * cell_m);
          if (touches(a, b, centre, 0.5 * cell_m))
            touching.push_back({at(r, c), {a.x(), a.y(), b.x(), b.y(), owners[piece]}});
        }
    }
    // Scan lines through the cells' centres, with the same half-open rule for corners as the
    // queries.
    for (int r = row_of(low.x()); r <= row_of(high.x()); ++r) {
      const double north = south_ + (r + 0.5) * cell_m;
      crossings.clear();
      for (std::size_t i = 0; i < outline.size(); ++i) {
        const Eigen::Vector2d& a = outline[i];
        const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
        if ((a.x() >= north) != (b.x() >= north))
          crossings.push_back(a.y() + (b.y() - a.y()) * (north - a.x()) / (b.x() - a.x()));
      }
      std::sort(crossings.begin(), crossings.end());
      for (std::size_t k = 0; k + 1 < crossings.size(); k += 2)
        for (int c = column_of(crossings[k]); c <= column_of(crossings[k + 1]); ++c) {
          const double east = west_ + (c + 0.5) * cell_m;
          if (east >= crossings[k] && east < crossings[k + 1])
            cells_[at(r, c)] = -2 - owners[piece];
        }
    }
  }

  std::sort(touching.begin(), touching.end(), [](const Touch& a, const Touch& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.edge.object < b.edge.object;
  });
  edges_.reserve(touching.size());
  for (std::size_t i = 0; i < touching.size();) {
    const std::size_t cell = touching[i].cell;
    Mixed mixed{};
    mixed.north =
        south_ + (static_cast<double>(cell / static_cast<std::size_t>(columns_)) + 0.5) * cell_m;
    mixed.east =
        west_ + (static_cast<double>(cell % static_cast<std::size_t>(columns_)) + 0.5) * cell_m;
    mixed.object = -2 - cells_[cell];
    mixed.first_edge = static_cast<std::uint32_t>(edges_.size());
    for (; i < touching.size() && touching[i].cell == cell; ++i) edges_.push_back(touching[i].edge);
    mixed.edge_count = static_cast<std::uint32_t>(edges_.size()) - mixed.first_edge;
    cells_[cell] = static_cast<std::int32_t>(mixed_.size());
    mixed_.push_back(mixed);
  }
}

}  // namespace watersky::sim
