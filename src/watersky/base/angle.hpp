// SPDX-License-Identifier: MIT
#pragma once
/// An angle that had to name its unit: `Angle::degrees(78.2)`, `90_deg`.
#include <cmath>
#include <compare>
#include <numbers>

namespace watersky {

class Angle {
 public:
  constexpr Angle() = default;
  [[nodiscard]] static constexpr Angle radians(double r) { return Angle(r); }
  [[nodiscard]] static constexpr Angle degrees(double d) {
    return Angle(d * (std::numbers::pi / 180.0));
  }

  [[nodiscard]] constexpr double radians() const { return radians_; }
  [[nodiscard]] constexpr double degrees() const { return radians_ * (180.0 / std::numbers::pi); }

  /// The same direction in (-π, π].
  [[nodiscard]] Angle wrapped() const {
    const double r = std::remainder(radians_, 2 * std::numbers::pi);
    return Angle(r == -std::numbers::pi ? std::numbers::pi : r);
  }

  constexpr Angle operator-() const { return Angle(-radians_); }
  constexpr Angle operator+(Angle o) const { return Angle(radians_ + o.radians_); }
  constexpr Angle operator-(Angle o) const { return Angle(radians_ - o.radians_); }
  constexpr Angle operator*(double s) const { return Angle(radians_ * s); }
  constexpr auto operator<=>(const Angle&) const = default;

 private:
  constexpr explicit Angle(double r) : radians_(r) {}
  double radians_ = 0.0;
};

[[nodiscard]] inline double sin(Angle a) { return std::sin(a.radians()); }
[[nodiscard]] inline double cos(Angle a) { return std::cos(a.radians()); }
[[nodiscard]] inline double tan(Angle a) { return std::tan(a.radians()); }

inline namespace literals {
constexpr Angle operator""_deg(long double d) { return Angle::degrees(static_cast<double>(d)); }
constexpr Angle operator""_deg(unsigned long long d) {
  return Angle::degrees(static_cast<double>(d));
}
}  // namespace literals

}  // namespace watersky
