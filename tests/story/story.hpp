// SPDX-License-Identifier: MIT
#pragma once
/// Stories: a sea drawn in characters, a flight over it, and the map that comes of it.
///
///   const auto sea = story::sea(R"(
///       ........
///       ..###...
///       ........)", {.cell_m = 10.0});
///   const auto flight = story::survey(sea, {.height_m = 80.0, .seed = 1});
///   const MapRun run = story::map(flight).value();
///
/// What a story cannot tell at all (a drawing that is no rectangle) is thrown and fails its test.
#include <string_view>

#include "watersky/flight/flight.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::story {

struct Drawing {
  double cell_m = 10.0;          ///< the edge of the square that one character stands for
  double isolation_gap_m = 3.0;  ///< what counts as open water around an object
};

/// '#' ice, '.' water; the first line is the northernmost.
[[nodiscard]] sim::Sea sea(std::string_view drawing, const Drawing& scale = {});

/// Legs from south to north and back over the whole sea, in gusts, with exact poses.
struct Survey {
  double height_m = 80.0;
  double tilt_deg = 0.0;     ///< the camera's, from straight down towards the front
  double azimuth_deg = 0.0;  ///< of the first leg
  double drift_north_m_s = 0.0;
  double drift_east_m_s = 0.0;
  double scene_north_m = 0.0;  ///< from the mission datum to the middle of the sea
  double scene_east_m = 0.0;
  bool ice_darker = false;
  int seed = 1;
};

[[nodiscard]] sim::Simulation simulation(const sim::Sea& sea, const Survey& survey = {});
[[nodiscard]] Flight survey(const sim::Sea& sea, const Survey& survey = {});

/// Half-metre cells, no mosaic.
[[nodiscard]] MappingOptions usual_options();
[[nodiscard]] Result<MapRun> map(const Flight& flight,
                                 const MappingOptions& options = usual_options());

/// P(ice) that a map gives to a point of the scene; NaN where it has not seen it.
[[nodiscard]] double p_ice(const MapRun& run, const sim::Truth& truth, double north_m,
                           double east_m);

}  // namespace watersky::story
