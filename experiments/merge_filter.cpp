// SPDX-License-Identifier: MIT
/// How far the merged view (each source's evidence summed, clamped last) is from the exact filter,
/// which sees the looks of all sources in the order of their times: with cells that forget nothing,
/// where only clamping differs, and with cells that forget (2.21), where each source forgets its
/// own evidence alone.
///
///   merge_filter [SEED]
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "support/map_tiles.hpp"
#include "support/print_figure.hpp"
#include "watersky/map/log_odds.hpp"
#include "watersky/store/map_view.hpp"

using namespace watersky;

namespace {

constexpr int kCells = 256 * 256;
constexpr double kPrior = 0.5, kMostProbability = 0.999;

struct Look {
  double time_s = 0.0;
  int source = 0;
  double evidence = 0.0;
};

/// A cell by the filter: predicted between looks, clamped after each.
struct Filter {
  double evidence = 0.0;
  std::optional<double> last_s;
  void to(double time_s, const std::optional<CellDynamics>& dynamics) {
    if (last_s && dynamics && time_s > *last_s)
      evidence = log_odds(dynamics->predict(probability(evidence), time_s - *last_s));
    last_s = time_s;
  }
  void look(const Look& l, const std::optional<CellDynamics>& dynamics) {
    to(l.time_s, dynamics);
    const double most = log_odds(kMostProbability);
    evidence = std::clamp(evidence + l.evidence, -most, most);
  }
};

void put(MapTile& tile, int cell, const Filter& filter, int looks) {
  const int column = cell % 256, row = cell / 256;
  MapTile::Block& block = tile.make_block(MapTile::block_of(column, row));
  const auto i = static_cast<std::size_t>(MapTile::cell_in_block(column, row));
  block.seen[i] = block.place_of(test::at_second(*filter.last_s));
  block.evidence[i] = static_cast<std::int16_t>(std::lround(filter.evidence * kEvidenceUnits));
  block.looks[i] = static_cast<std::uint8_t>(looks);
}

void compare(const std::string& name, int sources, int looks, double strength,
             const std::optional<CellDynamics>& dynamics, unsigned seed) {
  constexpr double kFlight_s = 600.0;
  std::mt19937 random(seed);
  std::vector<MapTile> tiles(static_cast<std::size_t>(sources));
  std::vector<double> exact(kCells);
  // Blocks name at most 256 times: looks come at whole ten seconds.
  std::uniform_int_distribution<int> time(0, 60), source(0, sources - 1);
  for (int cell = 0; cell < kCells; ++cell) {
    const bool ice = random() % 2 == 0;
    std::vector<Look> seen;
    for (int i = 0; i < looks; ++i) {
      // An inverse sensor model that is right as often as it says: mean = variance / 2.
      std::normal_distribution<double> said(strength * strength / 2 * (ice ? 1 : -1), strength);
      seen.push_back({10.0 * time(random), source(random), said(random)});
    }
    std::sort(seen.begin(), seen.end(),
              [](const Look& a, const Look& b) { return a.time_s < b.time_s; });
    Filter all;
    std::vector<Filter> own(static_cast<std::size_t>(sources));
    std::vector<int> counts(static_cast<std::size_t>(sources), 0);
    for (const Look& l : seen) {
      all.look(l, dynamics);
      own[static_cast<std::size_t>(l.source)].look(l, dynamics);
      ++counts[static_cast<std::size_t>(l.source)];
    }
    all.to(kFlight_s, dynamics);
    exact[static_cast<std::size_t>(cell)] = probability(all.evidence);
    for (std::size_t s = 0; s < own.size(); ++s)
      if (counts[s] > 0) put(tiles[s], cell, own[s], counts[s]);
  }
  MapViewParameters parameters{.prior = kPrior, .max_probability = kMostProbability};
  if (dynamics) {
    parameters.dynamics = dynamics;
    parameters.common_time = test::at_second(kFlight_s);
  }
  const MapTile view = sum_of(tiles, parameters);
  double square = 0.0, worst = 0.0;
  int other = 0;
  for (int cell = 0; cell < kCells; ++cell) {
    const int column = cell % 256, row = cell / 256;
    const MapTile::Block& block = *view.block(MapTile::block_of(column, row));
    const double p = probability(
        static_cast<double>(
            block.evidence[static_cast<std::size_t>(MapTile::cell_in_block(column, row))]) /
        kEvidenceUnits);
    const double off = p - exact[static_cast<std::size_t>(cell)];
    square += off * off / kCells;
    worst = std::max(worst, std::abs(off));
    other += (p > 0.5) != (exact[static_cast<std::size_t>(cell)] > 0.5) ? 1 : 0;
  }
  study::print_figure("merge_filter." + name + ".p_rms", std::sqrt(square));
  study::print_figure("merge_filter." + name + ".p_worst", worst);
  study::print_figure("merge_filter." + name + ".classed_otherwise",
                      static_cast<double>(other) / kCells);
}

}  // namespace

int main(int argc, char** argv) {
  const unsigned seed = argc > 1 ? static_cast<unsigned>(std::atoi(argv[1])) : 1;
  const auto forgets = [](double p_stays, double step_s) {
    return CellDynamics::make(p_stays, 1 - p_stays, step_s, kPrior).value();
  };
  compare("still.2_sources.6_looks", 2, 6, 1.5, std::nullopt, seed);
  compare("still.4_sources.6_looks", 4, 6, 1.5, std::nullopt, seed);
  compare("still.2_sources.60_looks", 2, 60, 1.5, std::nullopt, seed);
  // Half of what a cell knows is forgotten in 10 minutes, and in one.
  compare("slow.2_sources.6_looks", 2, 6, 1.5, forgets(0.75, 600.0), seed);
  compare("slow.4_sources.6_looks", 4, 6, 1.5, forgets(0.75, 600.0), seed);
  compare("fast.2_sources.6_looks", 2, 6, 1.5, forgets(0.75, 60.0), seed);
  compare("fast.4_sources.60_looks", 4, 60, 1.5, forgets(0.75, 60.0), seed);
  return 0;
}
