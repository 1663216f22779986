// SPDX-License-Identifier: MIT
#pragma once
/// The simulated flight of the alignment's tests.
#include "watersky/sim/simulate.hpp"

namespace watersky::test {

/// Small pictures of a short flight over ice: two legs that overlap, and the turn between them.
inline sim::Scenario small_flight() {
  sim::Scenario s = sim::scenario_preset("outdoor").value();
  s.lens.width_px = 240;
  s.lens.height_px = 192;
  s.lens.focal_px = 285;
  s.sensor.supersampling = 1;
  s.sensor.noise_counts = 3;
  s.sea.extent_north_m = 400;
  s.sea.extent_east_m = 300;
  s.aircraft.legs = 2;
  s.aircraft.leg_length_m = 90;
  s.camera.frame_rate_hz = 3;
  return s;
}

/// Its pictures rendered once, not each time somebody looks.
inline sim::Simulation simulated(const sim::Scenario& scenario) {
  sim::Simulation made = sim::simulate(scenario).value();
  for (ImageFrame& f : made.flight.frames)
    f.load = [image = f.load({}).value()](const ImageRequest&) { return Result<cv::Mat>(image); };
  return made;
}

}  // namespace watersky::test
