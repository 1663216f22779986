// SPDX-License-Identifier: MIT
#pragma once
/// Smooth random motion in closed form.
#include <cstdint>
#include <vector>

namespace watersky::sim {

/// A sum of sinusoids of random phase: noise of known sigma and band with all derivatives.
class BandLimitedNoise {
 public:
  BandLimitedNoise(std::uint64_t seed, double sigma, double band_hz);
  [[nodiscard]] double at(double t_s) const;

 private:
  struct Wave {
    double amplitude, rad_s, phase;
  };
  std::vector<Wave> waves_;
};

}  // namespace watersky::sim
