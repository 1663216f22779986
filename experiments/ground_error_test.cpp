// SPDX-License-Identifier: MIT
#include "ground_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "preparations.hpp"

namespace watersky::study {
namespace {

/// Outdoors with exact navigation, over a scene that is quick to make.
sim::Simulation exact_flight(const std::function<void(sim::Scenario&)>& change = {}) {
  sim::Scenario s = sim::scenario_preset("outdoor").value();
  s.sea.concentration = 0.0;
  s.sea.isolated_count = 1;
  s.sea.lead_count = 0;
  s.camera.frame_rate_hz = 1.0;
  s.navigation.nav_position_sigma_m = s.navigation.nav_attitude_sigma_deg = 0.0;
  if (change) change(s);
  return sim::simulate(s).value();
}

TEST(GroundError, IsNoneForTheTruthAndTheWholeMoveOfAMovedFlight) {
  const sim::Simulation run = exact_flight();
  const Flight exact = with_true_times_and_mount(run.flight, run.truth).value();
  const GroundErrors none = ground_errors(exact, run);
  EXPECT_GT(none.of_frame_m.size(), 40u);
  EXPECT_LT(none.of_frame_m.size(), run.flight.frames.size());  // turns are not judged
  EXPECT_EQ(none.frames_left_out(), 0u);
  EXPECT_LT(judge(none).absolute_m, 0.02);  // interpolation between poses 20 ms apart

  Flight moved = exact;
  std::vector<StampedPose> poses = exact.trajectory.poses();
  for (StampedPose& pose : poses) {
    const Point<World> p{pose.world_from_body.origin().v + Eigen::Vector3d(3.0, -4.0, 0.0)};
    pose.world_from_body = Rigid3<World, Body>(pose.world_from_body.rotation(), p);
  }
  moved.trajectory = Trajectory::make(std::move(poses)).value();
  const GroundAccuracy off = judge(ground_errors(moved, run, 2));
  EXPECT_NEAR(off.absolute_m, 5.0, 0.02);
  EXPECT_LT(off.shape_m, 0.03);
}

TEST(GroundError, ADelayIsTheWayFlownMeanwhile) {
  const sim::Simulation run = exact_flight([](sim::Scenario& s) {
    s.aircraft.legs = 1;
    s.aircraft.gust_roll_deg = s.aircraft.gust_pitch_deg = s.aircraft.gust_yaw_deg = 0.0;
    s.aircraft.gust_aside_m = s.aircraft.gust_height_m = 0.0;
  });
  Flight late = with_true_times_and_mount(run.flight, run.truth).value();
  for (ImageFrame& frame : late.frames) *frame.captured_at += seconds(0.2);
  const GroundAccuracy off = judge(ground_errors(late, run));
  EXPECT_NEAR(off.absolute_m, 3.0, 0.02);  // at 15 m/s
  EXPECT_LT(off.shape_m, 0.05);            // on one leg the same for all
}

TEST(GroundError, NobodyWinsByLeavingOutFrames) {
  const sim::Simulation run = exact_flight();
  const Flight exact = with_true_times_and_mount(run.flight, run.truth).value();
  Flight fewer = exact;
  fewer.frames.resize(fewer.frames.size() / 2);
  GroundErrors all = ground_errors(exact, run), half = ground_errors(fewer, run);
  EXPECT_EQ(all.frames_left_out(), 0u);
  EXPECT_GT(half.frames_left_out(), all.of_frame_m.size() / 3);
  keep_common({&all, &half});
  EXPECT_EQ(all.frames_left_out(), half.frames_left_out());
  EXPECT_DOUBLE_EQ(judge(all).absolute_m, judge(half).absolute_m);

  fewer.frames.clear();
  GroundErrors nothing = ground_errors(fewer, run);
  EXPECT_TRUE(std::isnan(judge(nothing).absolute_m));
}

}  // namespace
}  // namespace watersky::study
