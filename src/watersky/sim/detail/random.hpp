// SPDX-License-Identifier: MIT
#pragma once
/// Random numbers that are the same on every machine: the standard library leaves its
/// distributions to each implementation.
#include <cmath>
#include <cstdint>
#include <numbers>

namespace watersky::sim {

/// The finaliser of splitmix64 (Steele, Lea, Flood 2014): neighbouring inputs give unrelated
/// outputs, so "seed, what for, which frame" may be mixed one after the other.
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

/// One number from several.
template <class... Rest>
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t first, std::uint64_t second, Rest... rest) {
  return mix(mix(first) ^ second, static_cast<std::uint64_t>(rest)...);
}

/// What a stream of random numbers is for; streams of one seed do not depend on each other.
enum class Stream : std::uint64_t {
  Sea = 1,
  Appearance,
  Texture,
  Gusts,
  Navigation,
  Clock,
  Pattern,
  Noise,
  Mount,
  Link,
  Patches,
  KnownPoints
};

/// xoshiro256++ (Blackman, Vigna 2019).
class Random {
 public:
  explicit Random(std::uint64_t seed) {
    for (std::uint64_t& s : state_) s = seed = mix(seed);
  }
  Random(std::uint64_t seed, Stream stream)
      : Random(mix(seed, static_cast<std::uint64_t>(stream))) {}

  [[nodiscard]] std::uint64_t bits() {
    const std::uint64_t result = rotate(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = rotate(state_[3], 45);
    return result;
  }
  /// In [0, 1).
  [[nodiscard]] double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  [[nodiscard]] double uniform(double from, double to) { return from + (to - from) * uniform(); }
  /// In [0, n).
  [[nodiscard]] std::size_t index(std::size_t n) {
    return static_cast<std::size_t>(uniform() * static_cast<double>(n));
  }
  /// Zero mean, unit variance (Box, Muller 1958).
  [[nodiscard]] double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  static constexpr std::uint64_t rotate(std::uint64_t x, int k) {
    return (x << k) | (x >> (64 - k));
  }
  std::uint64_t state_[4]{};
};

}  // namespace watersky::sim
