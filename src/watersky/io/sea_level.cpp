// SPDX-License-Identifier: MIT
#include "watersky/io/sea_level.hpp"

#include <cmath>
#include <cstdio>

#include "watersky/geodesy/projection.hpp"
#include "watersky/io/csv.hpp"

namespace watersky {

namespace {

std::string metres(const char* pattern, double x) {
  char text[96];
  std::snprintf(text, sizeof text, pattern, x);
  return text;
}

std::function<Result<double>(const Geodetic&)> along_geoid(double above_m) {
  return [above_m](const Geodetic& place) -> Result<double> {
    WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(place.latitude, place.longitude));
    return geoid_m + above_m;
  };
}

}  // namespace

Result<SeaLevelOption> parse_sea_level_option(std::string_view text) {
  const Error usage{
      ErrorCode::Usage,
      "--sea-level \"" + std::string(text.substr(0, 60)) +
          "\" is none of takeoff:M, geoid:M, ellipsoid:M with M in metres, e.g. takeoff:-40"};
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return usage;
  const std::string_view name = text.substr(0, colon);
  const auto height = parse_number(text.substr(colon + 1));
  // No sea lies farther than this from any of the three.
  if (!height || std::abs(*height) > 10'000) return usage;
  if (name == "takeoff") return SeaLevelOption{SeaReference::TakeOff, *height};
  if (name == "geoid") return SeaLevelOption{SeaReference::Geoid, *height};
  if (name == "ellipsoid") return SeaLevelOption{SeaReference::Ellipsoid, *height};
  return usage;
}

std::string explain_sea_level() {
  return "the height of the sea is not known and is never guessed; give it with --sea-level as the "
         "height of the sea above one of: takeoff:M (takeoff:-40 is 40 m below the take-off point; "
         "the "
         "best choice where take-off was near), geoid:M (geoid:0 is mean sea level, EGM96), or "
         "ellipsoid:M (WGS-84)";
}

Result<SeaLevel> make_sea_level(const SeaLevelOption& option,
                                const std::optional<TakeOff>& takeoff) {
  const double m = option.height_m;
  switch (option.reference) {
    case SeaReference::TakeOff:
      if (!takeoff)
        return Error{ErrorCode::NotFound,
                     "the flight does not record its height above take-off; give the sea as "
                     "geoid:M or ellipsoid:M"};
      return SeaLevel{
          along_geoid(takeoff->height_geoid_m + m),
          metres(m > 0 ? "%.2f m above take-off" : "%.2f m below take-off", std::abs(m)) +
              (takeoff->height_known
                   ? metres(" (nominally %.2f m above mean sea level)", takeoff->height_geoid_m + m)
                   : std::string()),
          0.0};
    case SeaReference::Geoid:
    case SeaReference::Ellipsoid: break;
  }
  if (takeoff && !takeoff->height_known)
    return Error{ErrorCode::NotFound,
                 "the flight records only heights above take-off; give the sea as takeoff:M"};
  if (option.reference == SeaReference::Geoid)
    return SeaLevel{along_geoid(m), metres("%.2f m above mean sea level (EGM96)", m), 0.0};
  return SeaLevel{[m](const Geodetic&) -> Result<double> { return m; },
                  metres("%.2f m above the ellipsoid (WGS-84)", m), 0.0};
}

}  // namespace watersky
