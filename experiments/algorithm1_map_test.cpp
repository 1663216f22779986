// SPDX-License-Identifier: MIT
#include "algorithm1_map.hpp"

#include <gtest/gtest.h>

#include "preparations.hpp"
#include "recording.hpp"
#include "watersky/ice/accuracy.hpp"

namespace watersky::study {
namespace {

/// A datum turned and 12 m above the sea: what is taken for north, or for the sea, shows.
TEST(Algorithm1Map, LiesWhereTheIceTrulyIs) {
  sim::Scenario s = sim::scenario_preset("outdoor").value();
  s.datum_x_azimuth_deg = 25.0;
  s.sea.floe_min_m = 10.0;
  s.aircraft.legs = 1;
  s.aircraft.leg_length_m = 120.0;
  s.camera.frame_rate_hz = 1.0;
  s.sensor.supersampling = 1;
  s.navigation.nav_position_sigma_m = s.navigation.nav_attitude_sigma_deg = 0.0;
  const sim::Simulation run = record(s).value();
  const Flight exact = with_true_times_and_mount(run.flight, run.truth).value();
  const auto frames = every(run.flight, 1);
  const Canvas canvas = canvas_over(run, 0.5).value();
  const cv::Mat map = algorithm1_map(exact, frames, segmented(frames).value(), canvas).value();
  const cv::Mat share = true_share(run.truth, canvas);
  EXPECT_GT(ice::compare(map, share).iou, 0.9);
  // All that was seen lies on the canvas, and some of the canvas nobody saw.
  for (const int row : {0, map.rows - 1})
    for (int column = 0; column < map.cols; ++column)
      EXPECT_TRUE(std::isnan(map.at<float>(row, column)));
  // Five metres aside is another place.
  Canvas aside = canvas;
  aside.corner_m.x() += 5.0;
  EXPECT_LT(ice::compare(map, true_share(run.truth, aside)).iou, 0.85);
}

}  // namespace
}  // namespace watersky::study
