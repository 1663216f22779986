// SPDX-License-Identifier: MIT
#include "watersky/field/marginals.hpp"

#include <cmath>

#include "watersky/field/detail/belief.hpp"

namespace watersky::field {

Result<Marginals> marginals(const cv::Mat& log_odds, double coupling, int max_iterations,
                            double tolerance) {
  WATERSKY_CHECK(check_field(log_odds, coupling));
  Marginals out;
  if (coupling == 0.0 || log_odds.empty()) {
    out.probability.create(log_odds.size(), CV_32F);
    for (int r = 0; r < log_odds.rows; ++r)
      for (int c = 0; c < log_odds.cols; ++c)
        out.probability.at<float>(r, c) = 1.0F / (1.0F + std::exp(-log_odds.at<float>(r, c)));
    return out;
  }
  detail::Belief belief(log_odds, coupling);
  do {
    out.last_change = static_cast<double>(belief.sweep());
    ++out.iterations;
  } while (out.iterations < max_iterations && out.last_change > tolerance);
  out.probability = belief.probability();
  return out;
}

}  // namespace watersky::field
