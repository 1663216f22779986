// SPDX-License-Identifier: MIT
#include "watersky/align/detail/capture_clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

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
  const double jitter_s = *middle / 0.6745 / std::sqrt(2.0);
  return CaptureClock{line.start - line.slope * first, line.slope, jitter_s,
                      clock_rate_sigma(jitter_s, line.slope, static_cast<double>(n))};
}

double clock_rate_sigma(double scatter_s, double period_s, double count) {
  // Delays wander slowly as well, and the earliest arrivals are few.
  constexpr double kRoom = 4.0, kLeast = 1e-5, kMost = 0.05;
  const double line = std::sqrt(12.0) * scatter_s / (std::pow(count, 1.5) * period_s);
  return std::clamp(kRoom * line, kLeast, kMost);
}

std::string counted_note(const CaptureClock& clock) {
  char text[200];
  std::snprintf(text, sizeof text,
                "Frames are counted: a regular clock of %.3f ms a frame under their arrivals took "
                "out %.0f ms of jitter.",
                1e3 * clock.period_s, 1e3 * clock.jitter_s);
  return text;
}

std::vector<double> even_times(const std::vector<double>& received_s) {
  constexpr std::ptrdiff_t kAround = 12;
  const auto n = static_cast<std::ptrdiff_t>(received_s.size());
  std::vector<double> even(received_s.size());
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const std::ptrdiff_t from = std::max<std::ptrdiff_t>(0, i - kAround),
                         to = std::min(n - 1, i + kAround);
    std::vector<double> x, y;
    for (std::ptrdiff_t k = from; k <= to; ++k) {
      x.push_back(static_cast<double>(k - i));
      y.push_back(received_s[static_cast<std::size_t>(k)]);
    }
    even[static_cast<std::size_t>(i)] =
        x.size() < 5 ? received_s[static_cast<std::size_t>(i)]
                     : through(x, y, std::vector<double>(x.size(), 1.0)).start;
  }
  for (std::size_t i = 1; i < even.size(); ++i) even[i] = std::max(even[i], even[i - 1] + 1e-6);
  return even;
}

bool ArrivalClock::add(double received_s, const std::optional<std::uint64_t>& counter) {
  counted_ = counted_ && counter && (counters_.empty() || *counter > counters_.back());
  received_s_.push_back(received_s);
  if (counter) counters_.push_back(*counter);
  if (received_s_.size() > kRemembered) {
    received_s_.erase(received_s_.begin());
    if (counted_) counters_.erase(counters_.begin());
  }
  if (++count_ % kEnough != 0) return false;
  if (counted_) {
    clock_ = fit_capture_clock(counters_, received_s_);
    return clock_.has_value();
  }
  const bool was_regular = clock_.has_value();
  clock_.reset();
  const std::size_t recent = std::min<std::size_t>(received_s_.size(), 4 * kEnough);
  const std::vector<double> last(received_s_.end() - static_cast<std::ptrdiff_t>(recent),
                                 received_s_.end());
  jitter_s_ = arrival_jitter_s(last, even_times(last));
  return was_regular;
}

double ArrivalClock::base_s(double received_s, const std::optional<std::uint64_t>& counter) const {
  if (!clock_ || !counter) return received_s;
  return clock_->start_s + clock_->period_s * static_cast<double>(*counter);
}

double arrival_jitter_s(const std::vector<double>& received_s, const std::vector<double>& even_s) {
  std::vector<double> off;
  for (std::size_t k = 0; k < even_s.size(); ++k)
    off.push_back(std::abs(received_s[k] - even_s[k]));
  if (off.empty()) return 0.0;
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return std::clamp(1.2 * *middle / 0.6745, 1e-3, 0.2);
}

namespace {

double middle_of(std::vector<double> v) {
  const auto at = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), at, v.end());
  return *at;
}

/// Slots for `count` frames from `first` on, all below `end`, rising, nearest to `wanted` (in
/// slots) by squares: dynamic programming over few frames and few free slots.
std::vector<std::int64_t> fill(const std::vector<double>& wanted, std::int64_t first,
                               std::int64_t end) {
  const auto count = static_cast<std::int64_t>(wanted.size());
  const std::int64_t spare = end - first - count;
  std::vector<std::int64_t> out;
  if (spare <= 0 || spare > 400) {
    for (std::int64_t k = 0; k < count; ++k) out.push_back(first + k);
    return out;
  }
  const auto width = static_cast<std::size_t>(spare + 1);
  std::vector<std::vector<double>> cost(wanted.size(), std::vector<double>(width));
  std::vector<std::vector<std::size_t>> from(wanted.size(), std::vector<std::size_t>(width, 0));
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    std::size_t best = 0;
    for (std::size_t skip = 0; skip < width; ++skip) {
      const double off = static_cast<double>(first) + static_cast<double>(k + skip) - wanted[k];
      if (k > 0 && cost[k - 1][skip] < cost[k - 1][best]) best = skip;
      cost[k][skip] = off * off + (k > 0 ? cost[k - 1][best] : 0.0);
      from[k][skip] = best;
    }
  }
  auto skip = static_cast<std::size_t>(std::min_element(cost.back().begin(), cost.back().end()) -
                                       cost.back().begin());
  out.assign(wanted.size(), 0);
  for (std::size_t k = wanted.size(); k-- > 0;) {
    out[k] = first + static_cast<std::int64_t>(k + skip);
    skip = from[k][skip];
  }
  return out;
}

}  // namespace

std::optional<Slots> find_slots(const std::vector<double>& estimated_s,
                                const std::vector<double>& sigma_s) {
  const std::size_t n = estimated_s.size();
  // A first idea of the period: the middle step of neighbours that are both known well.
  std::vector<double> known_sigmas;
  for (const double s : sigma_s)
    if (std::isfinite(s)) known_sigmas.push_back(s);
  if (known_sigmas.size() < 20 || known_sigmas.size() * 5 < n) return std::nullopt;
  std::vector<double> steps;
  const double typical_s = middle_of(known_sigmas);
  const auto good = [&](std::size_t i) { return sigma_s[i] < 2.0 * typical_s; };
  for (std::size_t i = 1; i < n; ++i)
    if (good(i) && good(i - 1)) steps.push_back(estimated_s[i] - estimated_s[i - 1]);
  if (steps.size() < 20) return std::nullopt;
  double period = middle_of(steps);
  if (!(period > 0) || typical_s > 0.25 * period) return std::nullopt;

  Slots out;
  std::vector<std::size_t> at;
  for (std::size_t i = 0; i < n; ++i)
    if (good(i)) at.push_back(i);
  std::vector<double> x, y, weight;
  Line line;
  for (int round = 0; round < 3; ++round) {
    // From neighbour to neighbour, so that a period a little off does not add up.
    x.clear(), y.clear(), weight.clear();
    double slot = 0.0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      if (k > 0) {
        const double least = static_cast<double>(at[k] - at[k - 1]);
        slot += std::max(least, std::round((estimated_s[at[k]] - estimated_s[at[k - 1]]) / period));
      }
      x.push_back(slot);
      y.push_back(estimated_s[at[k]]);
      weight.push_back(1.0);
    }
    for (int robust = 0; robust < 5; ++robust) {
      line = through(x, y, weight);
      std::vector<double> off;
      for (std::size_t k = 0; k < x.size(); ++k)
        off.push_back(std::abs(y[k] - line.start - line.slope * x[k]));
      out.residual_s = middle_of(off) / 0.6745;
      for (std::size_t k = 0; k < x.size(); ++k)
        weight[k] = 1.0 / (1.0 + std::pow(off[k] / (2.0 * out.residual_s + 1e-6), 2));
    }
    period = line.slope;
  }
  if (!(period > 0) || out.residual_s > 0.12 * period) return std::nullopt;
  out.clock = {line.start, period, 0.0,
               clock_rate_sigma(out.residual_s, period, static_cast<double>(x.size()))};
  // One that fell into a wrong slot would drag those between along: only what fits holds.
  std::vector<std::int64_t> fixed(n, -1);
  std::int64_t last = -1;
  for (std::size_t k = 0; k < at.size(); ++k) {
    const double off = y[k] - line.start - period * x[k];
    const auto slot = static_cast<std::int64_t>(x[k]);
    if (std::abs(off) > 0.35 * period || slot <= last) continue;
    fixed[at[k]] = slot;
    last = slot;
  }
  out.slot.assign(n, 0);
  std::size_t i = 0;
  std::int64_t before = std::numeric_limits<std::int64_t>::min();
  while (i < n) {
    if (fixed[i] >= 0 && fixed[i] > before) {
      out.slot[i] = before = fixed[i];
      ++i;
      continue;
    }
    std::size_t end = i;
    std::vector<double> wanted;
    while (end < n && fixed[end] < 0) {
      wanted.push_back((estimated_s[end] - line.start) / period);
      ++end;
    }
    if (wanted.empty()) return std::nullopt;
    const auto count = static_cast<std::int64_t>(wanted.size());
    const std::int64_t first =
        before != std::numeric_limits<std::int64_t>::min()
            ? before + 1
            : std::min(static_cast<std::int64_t>(std::llround(wanted.front())) - 1,
                       end < n ? fixed[end] - count : std::numeric_limits<std::int64_t>::max());
    const std::int64_t limit =
        end < n
            ? fixed[end]
            : std::max(first + count, static_cast<std::int64_t>(std::llround(wanted.back())) + 2);
    const auto slots = fill(wanted, first, limit);
    for (std::size_t k = 0; k < slots.size(); ++k) out.slot[i + k] = slots[k];
    before = slots.back();
    i = end;
  }
  return out;
}

}  // namespace watersky::align
