// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "preparations.hpp"
#include "study.hpp"

namespace watersky::study {
namespace {

/// The outdoor flight with exact navigation, over a scene that is quick to make.
sim::Simulation exact_flight() {
  sim::Scenario s = sim::scenario_preset("outdoor").value();
  s.sea.concentration = 0.0;
  s.sea.isolated_count = 1;
  s.sea.lead_count = 0;
  s.camera.frame_rate_hz = 1.0;
  s.navigation.nav_position_sigma_m = s.navigation.nav_attitude_sigma_deg = 0.0;
  return sim::simulate(s).value();
}

Flight moved(const Flight& flight, const std::function<Eigen::Vector2d(std::size_t)>& by_m) {
  Flight out = flight;
  std::vector<StampedPose> poses = flight.trajectory.poses();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Eigen::Vector3d p = poses[i].world_from_body.origin().v;
    p.head<2>() += by_m(i);
    poses[i].world_from_body =
        Rigid3<World, Body>(poses[i].world_from_body.rotation(), Point<World>{p});
  }
  out.trajectory = Trajectory::make(std::move(poses)).value();
  return out;
}

TEST(OutdoorJudge, TheTruthIsWithoutErrorAndAMovedFlightIsOffByThatOnly) {
  const sim::Simulation run = exact_flight();
  const Flight exact = with_true_times_and_mount(run.flight, run.truth).value();
  const Looks looks = look_at_points(exact, run, true);
  EXPECT_GT(looks.looks.size(), 2000u);
  EXPECT_EQ(looks.frames_left_out, 0u);
  EXPECT_LT(judge(looks).absolute_m, 0.02);  // interpolation between poses 20 ms apart
  const Accuracy off = judge(look_at_points(
      moved(exact, [](std::size_t) { return Eigen::Vector2d(3.0, -4.0); }), run, true));
  EXPECT_NEAR(off.absolute_m, 5.0, 0.02);
  EXPECT_LT(off.shape_m, 0.03);
  EXPECT_LT(off.sharpness_m, 0.03);
  EXPECT_LT(off.anchored_m, 0.03);
}

TEST(OutdoorJudge, WhatChangesFromLookToLookIsLostSharpness) {
  const sim::Simulation run = exact_flight();
  const Flight exact = with_true_times_and_mount(run.flight, run.truth).value();
  // Poses come at 50 Hz and swing by 1 m with a period of 3.1 s: 0.71 m on average.
  const Accuracy swinging = judge(
      look_at_points(moved(exact,
                           [](std::size_t i) {
                             return Eigen::Vector2d(0, std::sin(0.0405 * static_cast<double>(i)));
                           }),
                     run, false));
  EXPECT_NEAR(swinging.absolute_m, 0.71, 0.05);
  EXPECT_NEAR(swinging.sharpness_m, 0.65, 0.1);
  // A mount in which nobody believes turns all looks, and opposite legs the other way.
  const Accuracy nominal =
      judge(look_at_points(with_true_times(run.flight, run.truth).value(), run, false));
  EXPECT_GT(nominal.absolute_m, 1.0);
  EXPECT_LT(nominal.absolute_m, 5.0);
}

TEST(OutdoorJudge, TheFloorIsNoughtForExactNavigationAndASimilaritysOwnErrorElse) {
  sim::Simulation run = exact_flight();
  const Flight exact = with_true_times_and_mount(run.flight, run.truth).value();
  const Looks looks = look_at_points(exact, run, false);
  EXPECT_LT(floor_m(looks, run.truth), 1e-3);
  // Recorded 1 % too large: the fit cannot know, and the points are off as much.
  for (sim::TrueFrame& frame : run.truth.frames)
    frame.navigation_error_m = 0.01 * frame.world_from_body.origin().v;
  double sum = 0.0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Look& look : looks.looks)
    mean += looks.points_m[look.point] / static_cast<double>(looks.looks.size());
  for (const Look& look : looks.looks)
    sum += (0.01 * (looks.points_m[look.point] - mean)).squaredNorm();
  EXPECT_NEAR(floor_m(looks, run.truth), std::sqrt(sum / static_cast<double>(looks.looks.size())),
              1e-3);
}

}  // namespace
}  // namespace watersky::study
