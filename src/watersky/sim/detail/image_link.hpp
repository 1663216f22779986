// SPDX-License-Identifier: MIT
#pragma once
/// The link that images come over: late, irregular, with losses, but never out of order.
#include "watersky/sim/detail/random.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::sim {

/// An error that forgets itself with a time constant (first-order Gauss-Markov), of sigma 1.
class Wandering {
 public:
  Wandering(Random& random, double step_s, double correlation_s);
  double next();

 private:
  Random* random_;
  double keep_, value_;
};

class ImageLink {
 public:
  ImageLink(const CameraSetup& setup, std::uint64_t seed);
  ImageLink(const ImageLink&) = delete;
  ImageLink& operator=(const ImageLink&) = delete;

  struct Passage {
    double delay_s = 0.0;
    bool lost = false;
  };
  /// Of the next image, in the order of capture. `jitter` is standard normal.
  [[nodiscard]] Passage pass(double captured_s, double jitter);

 private:
  CameraSetup setup_;
  Random random_;
  Wandering drift_;
  double last_arrival_s_;
};

}  // namespace watersky::sim
