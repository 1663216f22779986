// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/detail/lattice.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <set>

namespace watersky::detail {

namespace {

using Index = std::pair<int, int>;
using Candidates = std::vector<LatticeCandidate>;

constexpr double kTolerance = 0.25;  // of a step
constexpr double kSizeRatio = 2.5;   // of neighbours' areas
constexpr std::size_t kNeighbours = 12, kMostSeeds = 60;
constexpr std::array<Index, 4> kDirections{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

Index operator+(const Index& a, const Index& b) { return {a.first + b.first, a.second + b.second}; }
Index operator-(const Index& a, const Index& b) { return {a.first - b.first, a.second - b.second}; }

bool alike(const LatticeCandidate& a, const LatticeCandidate& b) {
  return a.size < kSizeRatio * b.size && b.size < kSizeRatio * a.size;
}

class Grower {
 public:
  explicit Grower(const Candidates& candidates) : all_(candidates) {
    near_.resize(all_.size());
    std::vector<std::pair<double, std::size_t>> distance(all_.size());
    for (std::size_t i = 0; i < all_.size(); ++i) {
      for (std::size_t k = 0; k < all_.size(); ++k)
        distance[k] = {(all_[k].position - all_[i].position).squaredNorm(), k};
      const std::size_t n = std::min(kNeighbours + 1, distance.size());
      std::partial_sort(distance.begin(), distance.begin() + static_cast<long>(n), distance.end());
      for (std::size_t k = 1; k < n; ++k) near_[i].push_back(distance[k].second);
    }
  }

  [[nodiscard]] Lattice largest() const;

 private:
  struct Cross {
    std::size_t middle = 0;
    std::array<std::size_t, 4> arms{};  // right, left, down, up in the lattice's own directions
    double fault = 0;                   // how far arms are from opposite, in steps
  };
  [[nodiscard]] std::optional<Cross> cross_at(std::size_t middle) const;
  [[nodiscard]] Lattice grow(const Cross& seed) const;
  [[nodiscard]] std::optional<std::size_t> nearest(const Eigen::Vector2d& place,
                                                   std::size_t from) const;
  /// Where `target` should lie by what is known around it; nullopt when nothing tells.
  [[nodiscard]] std::optional<Eigen::Vector2d> predicted(const Lattice& known, const Index& from,
                                                         const Index& direction) const;
  [[nodiscard]] const Eigen::Vector2d& at(std::size_t i) const { return all_[i].position; }

  const Candidates& all_;
  std::vector<std::vector<std::size_t>> near_;
};

/// Two pairs of opposite neighbours, the nearest that are not in one line.
std::optional<Grower::Cross> Grower::cross_at(std::size_t middle) const {
  struct Pair {
    std::size_t there, back;
    Eigen::Vector2d step;
    double fault;
  };
  std::vector<Pair> pairs;
  const auto& near = near_[middle];
  for (std::size_t i = 0; i < near.size(); ++i)
    for (std::size_t k = i + 1; k < near.size(); ++k) {
      if (!alike(all_[middle], all_[near[i]]) || !alike(all_[middle], all_[near[k]])) continue;
      const Eigen::Vector2d step = 0.5 * (at(near[i]) - at(near[k]));
      const double off = (0.5 * (at(near[i]) + at(near[k])) - at(middle)).norm() / step.norm();
      if (off < 0.15) pairs.push_back({near[i], near[k], step, off});
    }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return a.step.squaredNorm() < b.step.squaredNorm();
  });
  for (std::size_t k = 1; k < pairs.size(); ++k) {
    const Pair &a = pairs[0], &b = pairs[k];
    const double sine = std::abs(a.step.x() * b.step.y() - a.step.y() * b.step.x()) /
                        (a.step.norm() * b.step.norm());
    if (sine < 0.35 || b.step.norm() > 4 * a.step.norm()) continue;
    return Cross{middle, {a.there, a.back, b.there, b.back}, a.fault + b.fault};
  }
  return std::nullopt;
}

std::optional<std::size_t> Grower::nearest(const Eigen::Vector2d& place, std::size_t from) const {
  // Neighbours of neighbours reach all around, also where one side is foreshortened.
  const double step = (place - at(from)).norm();
  double best = kTolerance * step;
  std::optional<std::size_t> found;
  const auto look = [&](std::size_t i) {
    const double off = (at(i) - place).norm();
    if (off < best && i != from && alike(all_[i], all_[from])) best = off, found = i;
  };
  for (const std::size_t i : near_[from]) {
    look(i);
    for (const std::size_t k : near_[i]) look(k);
  }
  return found;
}

std::optional<Eigen::Vector2d> Grower::predicted(const Lattice& known, const Index& from,
                                                 const Index& direction) const {
  const Eigen::Vector2d& here = at(known.at(from));
  const auto place = [&](const Index& i) -> const Eigen::Vector2d* {
    const auto it = known.find(i);
    return it == known.end() ? nullptr : &at(it->second);
  };
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int votes = 0;
  const Index side{direction.second, direction.first};
  for (const Index& beside : {from + side, from - side}) {
    const auto *a = place(beside), *b = place(beside + direction);
    if (a && b) sum += here + (*b - *a), ++votes;
  }
  if (const auto* before = place(from - direction)) {
    if (votes < 2) sum += 2 * here - *before, ++votes;
  }
  if (votes == 0) return std::nullopt;
  return sum / votes;
}

Lattice Grower::grow(const Cross& seed) const {
  Lattice known{{{0, 0}, seed.middle}};
  std::set<std::size_t> used{seed.middle};
  std::deque<Index> queue;
  for (std::size_t k = 0; k < 4; ++k) {
    known[kDirections[k]] = seed.arms[k];
    used.insert(seed.arms[k]);
    queue.push_back(kDirections[k]);
  }
  if (used.size() < 5) return {};
  queue.push_back({0, 0});
  while (!queue.empty()) {
    const Index from = queue.front();
    queue.pop_front();
    for (const Index& direction : kDirections) {
      const Index to = from + direction;
      if (known.contains(to)) continue;
      const auto place = predicted(known, from, direction);
      if (!place) continue;
      const auto found = nearest(*place, known.at(from));
      if (!found || used.contains(*found)) continue;
      known[to] = *found;
      used.insert(*found);
      queue.push_back(to);
      // What could not be predicted before may be now.
      for (const Index& d : kDirections)
        if (known.contains(to + d)) queue.push_back(to + d);
    }
  }
  // A point that lies off the middle of two opposite neighbours is not of the lattice.
  for (auto it = known.begin(); it != known.end();) {
    bool off = false;
    for (const Index& d : {Index{1, 0}, Index{0, 1}}) {
      const auto a = known.find(it->first - d), b = known.find(it->first + d);
      if (a == known.end() || b == known.end()) continue;
      const Eigen::Vector2d step = 0.5 * (at(b->second) - at(a->second));
      const Eigen::Vector2d middle = 0.5 * (at(a->second) + at(b->second));
      off = off || (at(it->second) - middle).norm() > 0.2 * step.norm();
    }
    it = off ? known.erase(it) : std::next(it);
  }
  return known;
}

Lattice Grower::largest() const {
  std::vector<Cross> seeds;
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (const auto cross = cross_at(i)) seeds.push_back(*cross);
  std::sort(seeds.begin(), seeds.end(),
            [](const Cross& a, const Cross& b) { return a.fault < b.fault; });
  Lattice best;
  std::set<std::size_t> seen;
  std::size_t tried = 0;
  for (const Cross& seed : seeds) {
    if (seen.contains(seed.middle)) continue;
    if (++tried > kMostSeeds) break;
    Lattice grown = grow(seed);
    for (const auto& [index, i] : grown) seen.insert(i);
    if (grown.size() > best.size()) best = std::move(grown);
  }
  return best.size() >= 9 ? best : Lattice{};
}

/// The box around indices.
struct Box {
  int left = 0, top = 0, right = 0, bottom = 0;
  [[nodiscard]] int width() const { return right - left + 1; }
  [[nodiscard]] int height() const { return bottom - top + 1; }
};

Box box_of(const Lattice& lattice) {
  Box box{lattice.begin()->first.first, lattice.begin()->first.second, lattice.begin()->first.first,
          lattice.begin()->first.second};
  for (const auto& [index, i] : lattice) {
    box.left = std::min(box.left, index.first), box.right = std::max(box.right, index.first);
    box.top = std::min(box.top, index.second), box.bottom = std::max(box.bottom, index.second);
  }
  return box;
}

/// What lies in a box of `width` by `height`, where it holds most.
Lattice best_window(const Lattice& lattice, int width, int height) {
  const Box box = box_of(lattice);
  Lattice best;
  for (int left = box.left; left <= std::max(box.left, box.right - width + 1); ++left)
    for (int top = box.top; top <= std::max(box.top, box.bottom - height + 1); ++top) {
      Lattice inside;
      for (const auto& entry : lattice)
        if (entry.first.first >= left && entry.first.first < left + width &&
            entry.first.second >= top && entry.first.second < top + height)
          inside.insert(entry);
      if (inside.size() > best.size()) best = std::move(inside);
    }
  return best;
}

/// Rows and columns at the rim of which hardly anything is seen are stray spots, not the target.
Lattice trimmed(Lattice lattice, bool staggered) {
  for (bool again = true; again && lattice.size() >= 9;) {
    again = false;
    const Box box = box_of(lattice);
    const auto cut = [&](bool column, int at) {
      std::size_t seen = 0;
      for (const auto& [index, i] : lattice) seen += (column ? index.first : index.second) == at;
      const double places = (column ? box.height() : box.width()) / (staggered ? 2.0 : 1.0);
      if (2.0 * static_cast<double>(seen) >= places - 1) return;
      std::erase_if(lattice, [&](const auto& entry) {
        return (column ? entry.first.first : entry.first.second) == at;
      });
      again = true;
    };
    cut(true, box.left);
    if (!again) cut(true, box.right);
    if (!again) cut(false, box.top);
    if (!again) cut(false, box.bottom);
  }
  return lattice;
}

}  // namespace

Lattice find_lattice(const std::vector<LatticeCandidate>& candidates) {
  if (candidates.size() < 9) return {};
  return Grower(candidates).largest();
}

std::optional<ReadLattice> read_lattice(const Lattice& lattice, const Candidates& candidates,
                                        std::optional<TargetKind> kind,
                                        std::optional<TargetSize> size) {
  if (lattice.size() < 9) return std::nullopt;
  std::optional<ReadLattice> best;
  // Foreshortened, a diagonal may have been the shortest step: all bases near the found one are
  // tried, and the one in which the points fill their box is the target's.
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b)
      for (int c = -1; c <= 1; ++c)
        for (int d = -1; d <= 1; ++d) {
          if (a * d - b * c != 1) continue;
          for (const bool staggered : {false, true}) {
            if (kind && (*kind == TargetKind::AsymmetricCircles) != staggered) continue;
            Lattice turned;
            for (const auto& [index, i] : lattice) {
              const int m = a * index.first + b * index.second;
              const int n = c * index.first + d * index.second;
              turned[staggered ? Index{m + n, n - m} : Index{m, n}] = i;
            }
            turned = trimmed(std::move(turned), staggered);
            if (turned.size() < 9) continue;
            if (size) {
              const int across = staggered ? 2 * size->columns : size->columns;
              const Box box = box_of(turned);
              // Upright or lying: what loses less.
              if (box.width() > across || box.height() > size->rows) {
                Lattice upright = best_window(turned, across, size->rows);
                Lattice lying = best_window(turned, size->rows, across);
                turned = upright.size() >= lying.size() ? std::move(upright) : std::move(lying);
              }
              if (turned.size() < 9) continue;
            }
            const Box box = box_of(turned);
            const double places =
                staggered ? 0.5 * box.width() * box.height() : 1.0 * box.width() * box.height();
            const double fill = std::min(1.0, static_cast<double>(turned.size()) / places);
            if (fill < 0.66 || (best && fill <= best->fill)) continue;
            best = ReadLattice{};
            best->kind = staggered ? TargetKind::AsymmetricCircles : TargetKind::Circles;
            best->fill = fill;
            best->points = std::move(turned);
          }
        }
  if (!best) return std::nullopt;

  // The axis that points right in the image becomes the columns'; rows go down, so that the target
  // is seen from its front.
  const auto mean_step = [&](const Index& unit) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const auto& [index, i] : best->points)
      for (const Index& step : {unit, unit + unit})
        if (const auto next = best->points.find(index + step); next != best->points.end())
          sum += candidates[next->second].position - candidates[i].position;
    return sum;
  };
  const Eigen::Vector2d across = mean_step({1, 0}), down = mean_step({0, 1});
  const int side = across.x() * down.y() - across.y() * down.x() < 0 ? -1 : 1;
  Box box = box_of(best->points);
  const bool staggered = best->kind == TargetKind::AsymmetricCircles;
  bool turn = std::abs(across.y()) > std::abs(across.x());
  const auto fits = [&](int width, int height) {
    return size && width <= (staggered ? 2 * size->columns : size->columns) && height <= size->rows;
  };
  if (size && fits(box.width(), box.height()) != fits(box.height(), box.width()))
    turn = fits(box.height(), box.width());
  // Every row of an asymmetric grid is full, so its width in half steps is even.
  if (!size && staggered && (box.width() % 2) != (box.height() % 2)) turn = box.width() % 2 == 1;
  Lattice upright;
  for (const auto& [index, i] : best->points) {
    const Index front{index.first, side * index.second};
    upright[turn ? Index{front.second, -front.first} : front] = i;
  }
  box = box_of(upright);
  best->points.clear();
  for (const auto& [index, i] : upright) best->points[index - Index{box.left, box.top}] = i;
  best->size = {staggered ? (box.width() + 1) / 2 : box.width(), box.height()};
  return best;
}

}  // namespace watersky::detail
