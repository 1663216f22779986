// SPDX-License-Identifier: MIT
#include "watersky/align/detail/turned_images.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace watersky::detail {

namespace {

/// A pair whose turns differ in cost by less says nothing.
constexpr double kSure = 0.5;

/// The cost of a pair under all turns of both.
using Costs = std::array<std::array<double, kQuarters>, kQuarters>;

class Forest {
 public:
  explicit Forest(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  [[nodiscard]] std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  bool join(std::size_t a, std::size_t b) {
    a = root(a), b = root(b);
    parent_[b] = a;
    return a != b;
  }

 private:
  std::vector<std::size_t> parent_;
};

struct Edge {
  std::size_t a, b;
  int relative;  ///< quarters of b over a
  double sure;
};

}  // namespace

TurnedImages find_turned_images(const Disagreement& disagreement, std::span<const SeenFrame> frames,
                                bool quarters, double penalty) {
  const auto& pairs = disagreement.pairs();
  const int step = quarters ? 1 : 2;
  const auto at = [](int k) { return static_cast<std::size_t>(k); };
  std::vector<Costs> costs(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (int a = 0; a < kQuarters; a += step)
      for (int b = 0; b < kQuarters; b += step)
        costs[p][at(a)][at(b)] = disagreement.cost_of(disagreement.of_pair(p, frames, a, b));

  std::vector<Edge> edges;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    double best = std::numeric_limits<double>::infinity(), second = best;
    int relative = 0;
    for (int k = 0; k < kQuarters; k += step) {
      double least = std::numeric_limits<double>::infinity();
      for (int a = 0; a < kQuarters; a += step)
        least = std::min(least, costs[p][at(a)][at((a + k) % kQuarters)]);
      if (least < best) {
        second = std::exchange(best, least);
        relative = k;
      } else {
        second = std::min(second, least);
      }
    }
    if (second - best > kSure) edges.push_back({pairs[p].a, pairs[p].b, relative, second - best});
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const Edge& x, const Edge& y) { return x.sure > y.sure; });
  Forest forest(frames.size());
  std::vector<std::vector<std::pair<std::size_t, int>>> tree(frames.size());
  for (const Edge& edge : edges)
    if (forest.join(edge.a, edge.b)) {
      tree[edge.a].emplace_back(edge.b, edge.relative);
      tree[edge.b].emplace_back(edge.a, (kQuarters - edge.relative) % kQuarters);
    }

  TurnedImages out;
  out.quarters.assign(frames.size(), 0);
  out.alone.assign(frames.size(), 0.0);
  out.together.assign(frames.size(), 0.0);
  out.pairs.assign(frames.size(), 0);
  std::vector<std::vector<std::size_t>> of_frame(frames.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    of_frame[pairs[p].a].push_back(p);
    of_frame[pairs[p].b].push_back(p);
  }
  const auto cost_of = [&](std::size_t p, const Quarters& q) {
    return costs[p][at(q[pairs[p].a])][at(q[pairs[p].b])];
  };

  // Trees: turns against the root, then the root's.
  std::vector<std::vector<std::size_t>> trees;
  std::vector<bool> reached(frames.size(), false);
  for (std::size_t root = 0; root < frames.size(); ++root) {
    if (reached[root]) continue;
    std::vector<std::size_t> members{root};
    reached[root] = true;
    for (std::size_t i = 0; i < members.size(); ++i)
      for (const auto& [next, relative] : tree[members[i]])
        if (!reached[next]) {
          reached[next] = true;
          out.quarters[next] = (out.quarters[members[i]] + relative) % kQuarters;
          members.push_back(next);
        }
    trees.push_back(std::move(members));
  }
  /// Of all pairs that touch the members, and of their turns.
  const auto cost_of_members = [&](const std::vector<std::size_t>& members, const Quarters& q) {
    double sum = 0.0;
    for (const std::size_t i : members) {
      if (q[i] != 0) sum += penalty;
      for (const std::size_t p : of_frame[i])
        if (pairs[p].a == i ||
            std::find(members.begin(), members.end(), pairs[p].a) == members.end())
          sum += cost_of(p, q);
    }
    return sum;
  };
  const auto turned = [&](const std::vector<std::size_t>& members, int k) {
    Quarters q = out.quarters;
    for (const std::size_t i : members) q[i] = (q[i] + k) % kQuarters;
    return q;
  };
  const auto improve = [&](const std::vector<std::size_t>& members) {
    int best = 0;
    double least = cost_of_members(members, out.quarters) - 1e-9;
    for (int k = step; k < kQuarters; k += step)
      if (const double c = cost_of_members(members, turned(members, k)); c < least)
        least = c, best = k;
    if (best != 0) out.quarters = turned(members, best);
    return best != 0;
  };
  for (int round = 0; round < 4; ++round) {
    bool changed = false;
    for (const auto& members : trees) changed |= improve(members);
    for (std::size_t i = 0; i < frames.size(); ++i) changed |= improve({i});
    if (!changed) break;
  }

  for (const auto& members : trees) {
    std::vector<std::size_t> off;
    for (const std::size_t i : members)
      if (out.quarters[i] != 0) off.push_back(i);
    if (off.empty()) continue;
    Quarters none = out.quarters;
    for (const std::size_t i : off) none[i] = 0;
    const double together = cost_of_members(members, none) - cost_of_members(members, out.quarters);
    for (const std::size_t i : off) {
      Quarters without = out.quarters;
      without[i] = 0;
      out.together[i] = together;
      out.alone[i] = cost_of_members({i}, without) - cost_of_members({i}, out.quarters);
      out.pairs[i] = of_frame[i].size();
    }
  }
  return out;
}

}  // namespace watersky::detail
