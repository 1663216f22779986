// SPDX-License-Identifier: MIT
#include <cmath>

#include "study.hpp"

namespace watersky::study {

sim::Scenario laboratory(int seed) {
  // The preset is the simulator's own: it is there.
  sim::Scenario scenario = sim::scenario_preset("laboratory").value();
  scenario.seed = scenario.sea.sea_seed = seed;
  return scenario;
}

Eigen::Vector2d scene_from_room(const Datum& datum, double x_m, double y_m) {
  // World is (x, -y), turned by its azimuth from the scene's north and east.
  const double c = std::cos(datum.x_azimuth().radians()), s = std::sin(datum.x_azimuth().radians());
  return {c * x_m + s * y_m, s * x_m - c * y_m};
}

Eigen::Vector2d room_from_scene(const Datum& datum, const Eigen::Vector2d& p) {
  const double c = std::cos(datum.x_azimuth().radians()), s = std::sin(datum.x_azimuth().radians());
  return {c * p.x() + s * p.y(), s * p.x() - c * p.y()};
}

}  // namespace watersky::study
