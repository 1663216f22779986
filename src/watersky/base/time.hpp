// SPDX-License-Identifier: MIT
#pragma once
/// Time is std::chrono nanoseconds UTC. A flight may count "since any one moment" instead of
/// 1970: only differences matter then.
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

namespace watersky {

using Duration = std::chrono::nanoseconds;
using Time = std::chrono::time_point<std::chrono::system_clock, Duration>;

/// Seconds as the files write them, to the nearest nanosecond the double can carry (a double
/// of 2026's UTC seconds resolves 0.24 µs).
[[nodiscard]] inline Duration seconds(double s) {
  const double whole = std::floor(s);
  return std::chrono::seconds(static_cast<std::int64_t>(whole)) +
         Duration(static_cast<std::int64_t>(std::llround((s - whole) * 1e9)));
}
[[nodiscard]] inline double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }
/// The moment `s` seconds after the epoch; nullopt when it does not fit (not finite, or beyond
/// the year 2262), so that no reader of foreign numbers can overflow.
[[nodiscard]] inline std::optional<Time> time_from_seconds(double s) {
  if (!(std::abs(s) < 9.2e9)) return std::nullopt;
  return Time(seconds(s));
}
[[nodiscard]] inline double to_seconds(Time t) { return to_seconds(t.time_since_epoch()); }

/// The moment that GPS receivers tell as a week since 6 January 1980 and milliseconds in it; UTC
/// lacks the leap seconds since then (18 since 2017).
[[nodiscard]] Time utc_from_gps(int week, std::int64_t week_ms);
/// The inverse, to the nearest millisecond.
struct GpsTime {
  int week = 0;
  std::int64_t week_ms = 0;
};
[[nodiscard]] GpsTime gps_from_utc(Time t);

/// ISO 8601, UTC, milliseconds: "2018-08-05T01:00:44.800Z".
[[nodiscard]] std::string to_iso8601(Time t);

}  // namespace watersky
