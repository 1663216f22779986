// SPDX-License-Identifier: MIT
#pragma once
/// How the cells of a block forget between two times (2.21).
#include <cmath>
#include <vector>

#include "watersky/map/log_odds.hpp"
#include "watersky/map/map_tile.hpp"

namespace watersky::detail {

class CellDecay {
 public:
  /// For cells last seen at the block's times; before `from` nothing is forgotten.
  CellDecay(const CellDynamics& dynamics, Time from, Time now, const std::vector<Time>& times)
      : prior_(dynamics.stationary()), prior_log_odds_(log_odds(prior_)), remaining_(times.size()) {
    for (std::size_t i = 0; i < times.size(); ++i) {
      const Duration elapsed = now - std::max(times[i], from);
      remaining_[i] = elapsed.count() > 0 ? dynamics.remaining(to_seconds(elapsed)) : 1.0;
    }
  }

  /// Log-odds minus the prior's, of a cell whose last look is in `place` of the times.
  [[nodiscard]] double operator()(double evidence, std::uint8_t place) const {
    const double left = remaining_[place];
    if (left == 1.0) return evidence;
    const double p = probability(evidence + prior_log_odds_);
    return log_odds(prior_ + left * (p - prior_)) - prior_log_odds_;
  }

 private:
  double prior_, prior_log_odds_;
  std::vector<double> remaining_;
};

}  // namespace watersky::detail
