// SPDX-License-Identifier: MIT
#include "watersky/sim/detail/image_link.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace watersky::sim {
namespace {

/// One image takes this long to come in, so the next arrives no sooner after it.
constexpr double kTransfer_s = 0.001;

}  // namespace

Wandering::Wandering(Random& random, double step_s, double correlation_s)
    : random_(&random),
      keep_(correlation_s > 0.0 ? std::exp(-step_s / correlation_s) : 0.0),
      value_(random.normal()) {}

double Wandering::next() {
  const double now = value_;
  value_ = keep_ * value_ + std::sqrt(1.0 - keep_ * keep_) * random_->normal();
  return now;
}

ImageLink::ImageLink(const CameraSetup& setup, std::uint64_t seed)
    : setup_(setup),
      random_(seed, Stream::Link),
      drift_(random_, 1.0 / setup.frame_rate_hz, setup.arrival_drift_correlation_s),
      last_arrival_s_(-std::numeric_limits<double>::infinity()) {}

ImageLink::Passage ImageLink::pass(double captured_s, double jitter) {
  const bool lost = random_.uniform() < setup_.drop_share;
  double delay_s = setup_.arrival_delay_s + setup_.arrival_drift_s * drift_.next();
  const double jitter_s = setup_.arrival_jitter_s * jitter;
  delay_s += setup_.arrival_two_sided ? jitter_s : std::abs(jitter_s);
  delay_s = std::max({delay_s, 0.0, last_arrival_s_ + kTransfer_s - captured_s});
  if (!lost) last_arrival_s_ = captured_s + delay_s;
  return {delay_s, lost};
}

}  // namespace watersky::sim
