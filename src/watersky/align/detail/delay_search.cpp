// SPDX-License-Identifier: MIT
#include "watersky/align/detail/delay_search.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/align/detail/median.hpp"

namespace watersky::align {

namespace {}  // namespace

AdjustmentState without_errors(const Adjustment& adjustment, double delay_s) {
  AdjustmentState s = adjustment.state;
  for (auto& k : s.knots) k.fill(0.0);
  for (auto& e : s.extra) e.fill(0.0);
  std::fill(s.delay_s.begin(), s.delay_s.end(), delay_s);
  std::fill(s.jitter_s.begin(), s.jitter_s.end(), 0.0);
  s.globals.setZero();
  return s;
}

std::optional<double> search_delay(const Adjustment& adjustment, const DelaySearch& how) {
  // Pairs some tenths of a second apart: long enough that motion stands out of the noise, short
  // enough that navigation errors do not.
  constexpr double kSpan_s = 0.35;
  constexpr double kStep_s = 0.01;
  constexpr std::size_t kTiesOfPair = 7;
  const auto& groups = adjustment.groups;
  std::vector<std::pair<double, std::size_t>> by_span;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const double span = adjustment.frames[static_cast<std::size_t>(groups[g].frame)].base_s -
                        adjustment.frames[static_cast<std::size_t>(groups[g].host)].base_s;
    by_span.emplace_back(std::abs(std::log(std::max(1e-3, span) / kSpan_s)), g);
  }
  std::sort(by_span.begin(), by_span.end());
  // Of the better third of spans, spread over the flight.
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < std::max<std::size_t>(1, by_span.size() / 3) && k < by_span.size();
       ++k)
    chosen.push_back(by_span[k].second);
  std::sort(chosen.begin(), chosen.end());
  std::vector<std::size_t> used;
  const std::size_t most = std::min(how.most_pairs, chosen.size());
  for (std::size_t k = 0; k < most; ++k) used.push_back(chosen[k * chosen.size() / most]);
  const auto score = [&](double delay_s) {
    const Cameras cameras = adjustment.cameras(without_errors(adjustment, delay_s));
    std::vector<double> sizes;
    for (const std::size_t g : used) {
      std::vector<double> u, v;
      for (const Tie& t : groups[g].ties)
        if (const auto r = adjustment.residual_px(groups[g], t, cameras)) {
          u.push_back(r->x());
          v.push_back(r->y());
          if (u.size() >= kTiesOfPair) break;
        }
      if (!u.empty()) sizes.push_back(std::hypot(median(std::move(u)), median(std::move(v))));
    }
    return median(std::move(sizes));
  };
  const double at_given = score(how.given_s);
  double best_s = how.given_s, best = at_given;
  for (double d = how.from_s; d <= how.to_s + 1e-9; d += kStep_s)
    if (const double now = score(d); now < best) best = now, best_s = d;
  // A valley, or the delay is not to be seen.
  if (!(best < 0.95 * at_given)) return std::nullopt;
  return best_s;
}

}  // namespace watersky::align
