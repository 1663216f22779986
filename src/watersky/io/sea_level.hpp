// SPDX-License-Identifier: MIT
#pragma once
/// Where the sea is, as a person says it on the command line.
#include <optional>
#include <string>
#include <string_view>

#include "watersky/flight/flight.hpp"

namespace watersky {

enum class SeaReference { TakeOff, Geoid, Ellipsoid };

/// `takeoff:-40`: the sea lies 40 m below the take-off point. Heights of the sea above the
/// reference, metres; the geoid is EGM96.
struct SeaLevelOption {
  SeaReference reference = SeaReference::Geoid;
  double height_m = 0.0;
};

/// Usage, with the choices, for anything else than takeoff:M, geoid:M or ellipsoid:M.
[[nodiscard]] Result<SeaLevelOption> parse_sea_level_option(std::string_view text);

/// What to tell somebody whose flight has no sea level: the choices, on one line.
[[nodiscard]] std::string explain_sea_level();

/// Where a flight began, as far as its recording says.
struct TakeOff {
  /// Above EGM96. Consumer drones are metres off here: it enters only where the sea is given
  /// against geoid or ellipsoid, for heights above take-off are barometric and trustworthy.
  double height_geoid_m = 0.0;
  bool height_known = false;  ///< otherwise 0 stands in and only takeoff:M makes sense
};

/// The sea as a surface: along the geoid for TakeOff and Geoid, along the ellipsoid otherwise.
/// NotFound when `takeoff` lacks what the option needs.
[[nodiscard]] Result<SeaLevel> make_sea_level(const SeaLevelOption& option,
                                              const std::optional<TakeOff>& takeoff);

}  // namespace watersky
