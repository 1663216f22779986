// SPDX-License-Identifier: MIT
#include "watersky/align/detail/capture_clock.hpp"

#include <algorithm>
#include <cmath>

namespace watersky::align {

namespace {

struct Line {
  double start = 0.0, slope = 0.0;
};

Line through(const std::vector<double>& x, const std::vector<double>& y,
             const std::vector<double>& weight) {
  double sw = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sw += weight[i], sx += weight[i] * x[i], sy += weight[i] * y[i];
  }
  const double mx = sx / sw, my = sy / sw;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += weight[i] * (x[i] - mx) * (x[i] - mx);
    sxy += weight[i] * (x[i] - mx) * (y[i] - my);
  }
  const double slope = sxy / sxx;
  return {my - slope * mx, slope};
}

}  // namespace

std::optional<CaptureClock> fit_capture_clock(const std::vector<std::uint64_t>& counters,
                                              const std::vector<double>& received_s) {
  const std::size_t n = counters.size();
  if (n < 8 || received_s.size() != n) return std::nullopt;
  for (std::size_t i = 1; i < n; ++i)
    if (counters[i] <= counters[i - 1]) return std::nullopt;
  std::vector<double> k(n), weight(n, 1.0), rest(n);
  for (std::size_t i = 0; i < n; ++i) k[i] = static_cast<double>(counters[i] - counters[0]);
  // Least squares first; then the line that a tenth of the arrivals lie below, by weights that
  // turn squares into the tilted absolute loss of a quantile.
  Line line = through(k, received_s, weight);
  constexpr double kShare = 0.1;
  double spread = 1e-3;
  for (int round = 0; round < 40; ++round) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      rest[i] = received_s[i] - line.start - line.slope * k[i];
      sum += std::abs(rest[i]);
    }
    if (round == 0) spread = std::max(1e-6, 0.02 * sum / static_cast<double>(n));
    for (std::size_t i = 0; i < n; ++i)
      weight[i] = (rest[i] > 0 ? kShare : 1.0 - kShare) / std::max(std::abs(rest[i]), spread);
    line = through(k, received_s, weight);
  }
  if (!(line.slope > 0)) return std::nullopt;
  std::vector<double> steps;
  for (std::size_t i = 0; i < n; ++i) rest[i] = received_s[i] - line.start - line.slope * k[i];
  for (std::size_t i = 1; i < n; ++i) steps.push_back(std::abs(rest[i] - rest[i - 1]));
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double first = static_cast<double>(counters[0]);
  return CaptureClock{line.start - line.slope * first, line.slope,
                      *middle / 0.6745 / std::sqrt(2.0)};
}

}  // namespace watersky::align
