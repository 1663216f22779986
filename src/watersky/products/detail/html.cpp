// SPDX-License-Identifier: MIT
#include "watersky/products/detail/html.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "watersky/base/time.hpp"

namespace watersky::detail {

namespace {

std::string degrees_minutes(Angle angle, int degree_digits, int decimals, const char* positive,
                            const char* negative) {
  // Rounded before it is taken apart, so that no 60.000′ appears.
  const double unit = std::pow(10.0, decimals);
  const double minutes = std::round(std::abs(angle.degrees()) * 60 * unit) / unit;
  const double whole = std::floor(minutes / 60);
  const double rest = std::max(0.0, minutes - 60 * whole);
  char text[64];
  std::snprintf(text, sizeof text, "%0*.0f°%0*.*f′ %s", degree_digits, whole,
                decimals > 0 ? decimals + 3 : 2, decimals, rest,
                angle.radians() < 0 ? negative : positive);
  return text;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&': safe += "&amp;"; break;
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default: safe += c;
    }
  }
  return safe;
}

std::string number(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::string rounded(double value) {
  if (!std::isfinite(value)) return "–";
  const double magnitude = std::abs(value) > 0 ? std::floor(std::log10(std::abs(value))) : 0;
  std::string text = number(value, std::clamp(2 - static_cast<int>(magnitude), 0, 6));
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::size_t first_digit = text[0] == '-' ? 1 : 0;
  for (std::size_t i = point; i > first_digit + 3;) {
    i -= 3;
    text.insert(i, "\u2009");
  }
  return text;
}

std::string metres(double value_m) {
  if (std::abs(value_m) > 0 && std::abs(value_m) < 0.1) return rounded(value_m * 100) + " cm";
  return std::abs(value_m) >= 10000 ? rounded(value_m / 1000) + " km" : rounded(value_m) + " m";
}

std::string square_metres(double value_m2) {
  return std::abs(value_m2) >= 1e5 ? rounded(value_m2 / 1e6) + " km²" : rounded(value_m2) + " m²";
}

std::string percent(double fraction) {
  return std::isfinite(fraction) ? number(100 * fraction, 1) + " %" : "–";
}

std::string latitude(Angle angle, int decimals) {
  return degrees_minutes(angle, 2, decimals, "N", "S");
}
std::string longitude(Angle angle, int decimals) {
  return degrees_minutes(angle.wrapped(), 3, decimals, "E", "W");
}

std::string moment(double seconds_utc, bool is_utc) {
  const auto time = time_from_seconds(seconds_utc);
  if (!time) return "–";
  if (std::abs(seconds_utc) < 1e8) return number(seconds_utc, 1) + " s";
  std::string text = to_iso8601(*time).substr(0, 19);
  text[10] = ' ';
  return text + (is_utc ? " UTC" : " (camera's clock)");
}

}  // namespace watersky::detail
