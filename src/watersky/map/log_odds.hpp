// SPDX-License-Identifier: MIT
#pragma once
/// Probabilities as log-odds (2.27), (2.28) and the prediction step (2.21).
#include <algorithm>
#include <cmath>

#include "watersky/base/result.hpp"

namespace watersky {

/// log(p / (1-p)).
[[nodiscard]] inline double log_odds(double probability) {
  return std::log(probability / (1.0 - probability));
}
/// (2.28) as 1 / (1 + exp(-l)), which cannot overflow to NaN.
[[nodiscard]] inline double probability(double log_odds) {
  return 1.0 / (1.0 + std::exp(-log_odds));
}

/// The two-state Markov chain of (2.21): how a cell that nobody looks at forgets.
class CellDynamics {
 public:
  /// `p_ice_given_ice`, `p_ice_given_water`: transition probabilities over `step_s` seconds.
  /// InvalidInput when they are no probabilities, or when `prior` is not the chain's stationary
  /// probability: with another prior the subtraction in (2.27) is not exact. The message
  /// names the stationary probability.
  [[nodiscard]] static Result<CellDynamics> make(double p_ice_given_ice, double p_ice_given_water,
                                                 double step_s, double prior);

  /// Half of a probability's distance from the prior is gone after `half_life_s` (positive).
  [[nodiscard]] static CellDynamics with_half_life(double half_life_s, double prior) {
    return {prior, 0.5, half_life_s};
  }

  /// p_k = π + λ^(elapsed/step) (p - π), λ = P(ice|ice) - P(ice|water).
  [[nodiscard]] double predict(double probability, double elapsed_s) const {
    return stationary_ + remaining(elapsed_s) * (probability - stationary_);
  }
  /// What is left of a probability's distance from the stationary one.
  [[nodiscard]] double remaining(double elapsed_s) const {
    return std::pow(lambda_, elapsed_s / step_s_);
  }
  [[nodiscard]] double stationary() const { return stationary_; }

 private:
  CellDynamics(double stationary, double lambda, double step_s)
      : stationary_(stationary), lambda_(lambda), step_s_(step_s) {}
  double stationary_, lambda_, step_s_;
};

}  // namespace watersky
