// SPDX-License-Identifier: MIT
#include "watersky/map/detail/footprint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "watersky/map/detail/polygon_span.hpp"

namespace watersky::detail {

namespace {

constexpr int kBlock = MapTile::kBlockCells;
/// The most pixels of an averaged image that the cells of a part may span: positions are 12 bits.
constexpr double kMostSpan_px = 1500.0;

int block_of(double cell) { return static_cast<int>(std::floor(cell / kBlock)); }

/// A bilinear reading does for cells up to this many pixels apart, of the image as it is and of
/// one averaged over pairs: beyond, pixels between two cells would count much less than others.
constexpr double kReachOfPlain_px = 1.25;
constexpr double kReachOfDoubled_px = 2.3;
/// From here on the image is shrunk; below, the average over shrunk pairs would be wider than a
/// cell by more than half.
constexpr double kLeastForShrinking_px = 3.06;

}  // namespace

Pixel PixelPatch::at(double i, double j) const {
  const auto value = [&](const std::array<double, 6>& c) {
    return c[0] + i * (c[1] + i * c[3] + j * c[4]) + j * (c[2] + j * c[5]);
  };
  return {value(u), value(v)};
}

Footprint::Footprint(const GridView& view, int supersampling)
    : view_(view),
      projection_(view),
      supersampling_(supersampling),
      sea_middle_(view.sea_from_grid.col(2).head<2>() - view.below_north_east_m),
      sea_column_(view.sea_from_grid.col(0).head<2>()),
      sea_row_(view.sea_from_grid.col(1).head<2>()),
      limit2_(view.max_distance_m * view.max_distance_m) {}

std::optional<Pixel> Footprint::seen(double column, double row) const {
  if (!within_limit(column, row)) return std::nullopt;
  const auto p = projection_(column, row);
  return p && view_.camera.contains(*p) ? p : std::nullopt;
}

Footprint::Node Footprint::node(double column, double row) const {
  const auto p = projection_(column, row);
  return p ? Node{p->u, p->v, true} : Node{};
}

void Footprint::choose_sampling(const Eigen::Matrix2d& j, FootprintPart& part) const {
  part.averaging = {};
  if (supersampling_ > 0) {
    part.samples_x = part.samples_y = supersampling_;
    return;
  }
  // The smaller singular value: how many pixels a cell covers where it covers fewest.
  const double a2 = j.col(0).squaredNorm(), b2 = j.col(1).squaredNorm();
  const double along = j.col(0).dot(j.col(1));
  const double half = 0.5 * (a2 + b2),
               root = std::sqrt(0.25 * (a2 - b2) * (a2 - b2) + along * along);
  const double least = std::sqrt(std::max(0.0, half - root));
  double reach = kReachOfPlain_px;
  if (least > kReachOfPlain_px) {
    part.averaging.doubled = true;
    if (least > kLeastForShrinking_px)
      part.averaging.shrink = std::min(EvidenceLevels::kMostShrink,
                                       static_cast<int>(std::ceil(least / kReachOfDoubled_px)));
    reach = kReachOfDoubled_px * part.averaging.shrink;
  }
  // A power of 2: sums of two and four samples are means by a shift.
  const auto samples = [&](double length) {
    int count = 1;
    while (count < 16 && count * 1.1 * reach < length) count *= 2;
    return count;
  };
  part.samples_x = samples(std::sqrt(a2));
  part.samples_y = samples(std::sqrt(b2));
}

bool Footprint::fit(const Nodes& n, FootprintPart& part) const {
  part.exact = true;
  for (const auto& row : n)
    for (const Node& node : row)
      if (!node.known) return true;

  const double h = 0.5 * part.cells;
  std::array<double, 6> centred[2];
  const auto fit_one = [&](double Node::*x, std::array<double, 6>& c) {
    const double middle = n[1][1].*x, west = n[1][0].*x, east = n[1][2].*x, north = n[0][1].*x,
                 south = n[2][1].*x;
    c = {middle,
         (east - west) / (2 * h),
         (south - north) / (2 * h),
         (east + west - 2 * middle) / (2 * h * h),
         (n[2][2].*x - n[2][0].*x - n[0][2].*x + n[0][0].*x) / (4 * h * h),
         (south + north - 2 * middle) / (2 * h * h)};
  };
  fit_one(&Node::u, centred[0]);
  fit_one(&Node::v, centred[1]);
  const PixelPatch about_middle{centred[0], centred[1]};

  Eigen::Matrix2d jacobian;
  jacobian << centred[0][1], centred[0][2], centred[1][1], centred[1][2];
  choose_sampling(jacobian, part);

  const double tolerance = kTolerance_px * part.averaging.shrink;
  const double most = kMostError_px * part.averaging.shrink;
  const auto off = [&](double x, double y, const Node& exact) {
    const Pixel p = about_middle.at(x, y);
    return std::max(std::abs(p.u - exact.u), std::abs(p.v - exact.v));
  };
  // The terms of third order that the nodes do not see: i²j and ij² are largest in the corners, i³
  // and j³ at 1/√3 of the way.
  double worst = std::max(std::max(off(-h, -h, n[0][0]), off(h, -h, n[0][2])),
                          std::max(off(-h, h, n[2][0]), off(h, h, n[2][2])));
  const auto spread = [&](const std::array<double, 6>& c) {
    const double g = h + 0.5;  // samples lie up to half a cell beyond
    return g * (std::abs(c[1]) + std::abs(c[2]) +
                g * (std::abs(c[3]) + std::abs(c[4]) + std::abs(c[5])));
  };
  const Eigen::Vector2d middle(centred[0][0], centred[1][0]);
  const Eigen::Vector2d around(spread(centred[0]) + most, spread(centred[1]) + most);
  part.low = middle - around;
  part.high = middle + around;
  const Eigen::Vector2d first(-0.5, -0.5);
  const Eigen::Vector2d last(view_.camera.width_px() - 0.5, view_.camera.height_px() - 0.5);

  if (worst <= tolerance) {
    if ((part.high.array() < first.array()).any() || (part.low.array() > last.array()).any())
      return false;
    const double third = h / std::sqrt(3.0);
    const double x = part.first_column() + h, y = part.first_row() + h;
    const Node east = node(x + third, y), south = node(x, y + third);
    worst = east.known && south.known
                ? std::max(worst, std::max(off(third, 0, east), off(0, third, south)))
                : std::numeric_limits<double>::infinity();
  }
  part.exact =
      !(worst <= tolerance && around.maxCoeff() < 0.5 * kMostSpan_px * part.averaging.shrink);
  part.inside = !part.exact && (part.low.array() > first.array()).all() &&
                (part.high.array() < last.array()).all();
  const auto from_corner = [&](const std::array<double, 6>& c) {
    return std::array<double, 6>{c[0] - h * (c[1] + c[2]) + h * h * (c[3] + c[4] + c[5]),
                                 c[1] - h * (2 * c[3] + c[4]),
                                 c[2] - h * (2 * c[5] + c[4]),
                                 c[3],
                                 c[4],
                                 c[5]};
  };
  part.patch = {from_corner(centred[0]), from_corner(centred[1])};
  return true;
}

void Footprint::emit(const Nodes& nodes, FootprintPart& part,
                     const std::function<void(const FootprintPart&)>& use) const {
  if (!fit(nodes, part)) return;
  if (part.exact && part.cells == kBlock) {
    FootprintPart quarter = part;
    quarter.cells = kBlock / 2;
    const double step = quarter.cells / 2;
    for (quarter.row = 0; quarter.row < kBlock; quarter.row += quarter.cells)
      for (quarter.column = 0; quarter.column < kBlock; quarter.column += quarter.cells) {
        Nodes finer;
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            finer[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] =
                node(quarter.first_column() + c * step, quarter.first_row() + r * step);
        emit(finer, quarter, use);
      }
    return;
  }
  // A circle is convex: when the corners lie in it, so does all between them.
  const double c0 = part.first_column() - 0.5, r0 = part.first_row() - 0.5;
  const double c1 = c0 + part.cells, r1 = r0 + part.cells;
  part.limited = !(within_limit(c0, r0) && within_limit(c1, r0) && within_limit(c0, r1) &&
                   within_limit(c1, r1));
  if (part.exact) {
    const auto p = projection_(0.5 * (c0 + c1), 0.5 * (r0 + r1));
    const auto q = projection_(0.5 * (c0 + c1) + 1, 0.5 * (r0 + r1));
    const auto s = projection_(0.5 * (c0 + c1), 0.5 * (r0 + r1) + 1);
    Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity() * view_.pixels_per_cell;
    if (p && q && s) jacobian << q->u - p->u, s->u - p->u, q->v - p->v, s->v - p->v;
    choose_sampling(jacobian, part);
  }
  use(part);
}

void Footprint::for_each(const std::function<void(const FootprintPart&)>& use) const {
  // An outline of finitely many corners cuts the bulges of a bent edge.
  const int margin = !view_.roll.isZero(0.0) ? 4 : view_.camera.distorts() ? 2 : 1;
  constexpr int kStep = kBlock / 2;
  struct Line {
    int row = 0, first = 0;
    std::vector<Node> nodes;
  };
  Line top, middle, bottom;
  const auto make = [&](Line& line, int row, int first, int count, const Line* known) {
    line.row = row;
    line.first = first;
    line.nodes.resize(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      const std::ptrdiff_t old =
          known != nullptr && known->row == row
              ? (static_cast<std::ptrdiff_t>(first) - known->first) / kStep + i
              : -1;
      line.nodes[static_cast<std::size_t>(i)] =
          old >= 0 && old < static_cast<std::ptrdiff_t>(known->nodes.size())
              ? known->nodes[static_cast<std::size_t>(old)]
              : node(first + i * kStep, row);
    }
  };
  const int first_row = view_.box.first_row - margin, end_row = view_.box.end_row() + margin;
  for (int block_row = block_of(first_row); block_row <= block_of(end_row - 1); ++block_row) {
    const int row = block_row * kBlock;
    const auto [low, high] =
        span_between(view_.footprint, row - 0.5 - margin, row + kBlock - 0.5 + margin);
    if (!(low <= high)) continue;
    const int begin = block_of(low - margin), end = block_of(high + margin + 0.5);
    const int count = 2 * (end - begin + 1) + 1;
    make(top, row, begin * kBlock, count, &bottom);
    make(middle, row + kStep, begin * kBlock, count, nullptr);
    make(bottom, row + kBlock, begin * kBlock, count, nullptr);
    for (int block_column = begin; block_column <= end; ++block_column) {
      const auto at = static_cast<std::size_t>(2 * (block_column - begin));
      const auto three = [&](const Line& line) {
        return std::array<Node, 3>{line.nodes[at], line.nodes[at + 1], line.nodes[at + 2]};
      };
      FootprintPart part;
      part.block_column = block_column;
      part.block_row = block_row;
      emit({three(top), three(middle), three(bottom)}, part, use);
    }
  }
}

}  // namespace watersky::detail
