// SPDX-License-Identifier: MIT
#include "watersky/field/smoothing.hpp"

#include <chrono>
#include <utility>

#include "watersky/field/coupling.hpp"
#include "watersky/field/marginals.hpp"
#include "watersky/field/most_likely.hpp"

namespace watersky::field {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

Result<Smoothed> smooth(const cv::Mat& log_odds, const SmoothingParameters& parameters) {
  WATERSKY_CHECK(validate(parameters));
  WATERSKY_CHECK(check_field(log_odds, 0.0));
  Smoothed out;
  out.parameters = parameters;
  out.coupling = parameters.coupling;
  auto start = Clock::now();
  if (parameters.coupling < 0.0) {
    WATERSKY_TRY(const CouplingEstimate estimate, estimate_coupling(log_odds));
    out.coupling = estimate.coupling;
    out.best_foretelling = estimate.best_foretelling;
    out.coupling_s = seconds_since(start);
  }
  start = Clock::now();
  WATERSKY_TRY(Marginals found, marginals(log_odds, out.coupling, parameters.smoothing_iterations,
                                          parameters.smoothing_tolerance));
  out.probability = std::move(found.probability);
  out.iterations = found.iterations;
  out.last_change = found.last_change;
  out.marginals_s = seconds_since(start);
  start = Clock::now();
  WATERSKY_TRY(out.most_likely, most_likely(log_odds, out.coupling));
  out.cut_s = seconds_since(start);
  return out;
}

}  // namespace watersky::field
