// SPDX-License-Identifier: MIT
#include "watersky/sim/band_limited_noise.hpp"

#include <cmath>
#include <numbers>

#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {

BandLimitedNoise::BandLimitedNoise(std::uint64_t seed, double sigma, double band_hz) {
  if (sigma == 0.0) return;
  constexpr int kWaves = 24;
  Random random(seed);
  double power = 0.0;
  for (int i = 0; i < kWaves; ++i) {
    // One frequency from each part of the band; slower motion is stronger, as in turbulence.
    const double f = band_hz * (i + random.uniform(0.1, 0.9)) / kWaves;
    const double amplitude = std::pow(0.15 * band_hz + f, -5.0 / 6.0);
    power += 0.5 * amplitude * amplitude;
    waves_.push_back(
        {amplitude, 2.0 * std::numbers::pi * f, random.uniform(0.0, 2.0 * std::numbers::pi)});
  }
  for (Wave& wave : waves_) wave.amplitude *= sigma / std::sqrt(power);
}

double BandLimitedNoise::at(double t_s) const {
  double sum = 0.0;
  for (const Wave& wave : waves_) sum += wave.amplitude * std::sin(wave.rad_s * t_s + wave.phase);
  return sum;
}

}  // namespace watersky::sim
