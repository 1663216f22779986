// SPDX-License-Identifier: MIT
#include "watersky/map/log_odds.hpp"

#include <cstdio>

namespace watersky {

Result<CellDynamics> CellDynamics::make(double p_ice_given_ice, double p_ice_given_water,
                                        double step_s, double prior) {
  const auto is_probability = [](double p) { return p >= 0.0 && p <= 1.0; };
  if (!is_probability(p_ice_given_ice) || !is_probability(p_ice_given_water))
    return Error{ErrorCode::InvalidInput, "transition probabilities must lie from 0 to 1"};
  if (!(step_s > 0) || !std::isfinite(step_s))
    return Error{ErrorCode::InvalidInput,
                 "the step of the transition probabilities must be longer than 0 s"};
  const double lambda = p_ice_given_ice - p_ice_given_water;
  // λ = 1: nothing ever changes, and every prior is stationary. λ < 0 would make ice and water
  // swap at every step, which has no meaning between steps.
  if (lambda < 0)
    return Error{
        ErrorCode::InvalidInput,
        "ice must stay ice at least as often as water becomes ice (P(ice|ice) >= P(ice|water))"};
  const double stationary = lambda == 1.0 ? prior : p_ice_given_water / (1.0 - lambda);
  if (!(std::abs(stationary - prior) <= 1e-6)) {
    char text[160];
    std::snprintf(
        text, sizeof text,
        "the prior %.6g is not the stationary probability %.6g of the transition probabilities; "
        "use that as the prior",
        prior, stationary);
    return Error{ErrorCode::InvalidInput, text};
  }
  return CellDynamics(stationary, lambda, step_s);
}

}  // namespace watersky
