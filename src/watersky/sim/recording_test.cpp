// SPDX-License-Identifier: MIT
/// What a simulated recording holds back: arrival in place of capture, losses, a mount and poses
/// that are off.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "watersky/geo/rotation.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::sim {
namespace {

Scenario laboratory(int seed = 1) {
  Scenario s = scenario_preset("laboratory").value();
  s.seed = seed;
  return s;
}

std::vector<double> delays_s(const Simulation& run) {
  std::vector<double> out;
  for (std::size_t i = 0; i < run.flight.frames.size(); ++i)
    out.push_back(to_seconds(*run.flight.frames[i].received_at - run.truth.frames[i].captured_at));
  return out;
}

double mean(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double value : x) sum += value;
  return sum / static_cast<double>(x.size());
}

double deviation(const std::vector<double>& x) {
  const double middle = mean(x);
  double sum = 0.0;
  for (const double value : x) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(x.size()));
}

// alignment.md's laboratory: 272 ± 54 ms with 4 % drops.
TEST(Recording, TheLaboratorysImagesArriveAsLateAsTheThesiss) {
  std::vector<double> all;
  double lost = 0.0, sent = 0.0;
  for (int seed = 1; seed <= 10; ++seed) {
    const Simulation run = simulate(laboratory(seed)).value();
    const std::vector<double> delays = delays_s(run);
    all.insert(all.end(), delays.begin(), delays.end());
    const auto& frames = run.flight.frames;
    sent += static_cast<double>(*frames.back().counter - *frames.front().counter + 1);
    lost +=
        static_cast<double>(*frames.back().counter - *frames.front().counter + 1 - frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_FALSE(frames[i].captured_at.has_value());
      EXPECT_GE(delays[i], 0.0);
      if (i == 0) continue;
      EXPECT_GT(*frames[i].received_at, *frames[i - 1].received_at);  // in order, always
      EXPECT_GT(*frames[i].counter, *frames[i - 1].counter);
    }
  }
  EXPECT_NEAR(mean(all), 0.272, 0.006);
  EXPECT_NEAR(deviation(all), 0.054, 0.005);
  EXPECT_NEAR(lost / sent, 0.04, 0.006);
}

TEST(Recording, JitterOfBothSidesHasItsSigmaWhereImagesAreFarApart) {
  Scenario s = laboratory();
  s.camera.frame_rate_hz = 1.0;
  s.navigation.pose_rate_hz = 1.0;
  s.aircraft.hover.hover_duration_s = 4000.0;
  s.camera.arrival_drift_s = 0.0;
  s.camera.arrival_delay_s = 0.3;
  s.camera.arrival_jitter_s = 0.05;
  const std::vector<double> both = delays_s(simulate(s).value());
  EXPECT_NEAR(mean(both), 0.3, 0.003);
  EXPECT_NEAR(deviation(both), 0.05, 0.003);
  s.camera.arrival_two_sided = false;
  const std::vector<double> late = delays_s(simulate(s).value());
  EXPECT_GE(*std::min_element(late.begin(), late.end()), 0.3 - 1e-9);
  EXPECT_NEAR(mean(late), 0.3 + 0.05 * std::sqrt(2.0 / 3.14159), 0.003);
}

TEST(Recording, TheDelaysDriftForgetsItselfWithItsTimeConstant) {
  Scenario s = laboratory();
  s.camera.frame_rate_hz = 1.0;
  s.camera.drop_share = 0.0;
  s.navigation.pose_rate_hz = 1.0;
  s.aircraft.hover.hover_duration_s = 20000.0;
  s.camera.arrival_jitter_s = 0.0;
  s.camera.arrival_drift_s = 0.02;
  s.camera.arrival_drift_correlation_s = 20.0;
  const std::vector<double> delays = delays_s(simulate(s).value());
  const double middle = mean(delays), sigma = deviation(delays);
  EXPECT_NEAR(sigma, 0.02, 0.002);
  double product = 0.0;
  for (std::size_t i = 20; i < delays.size(); ++i)
    product += (delays[i] - middle) * (delays[i - 20] - middle);
  EXPECT_NEAR(product / static_cast<double>(delays.size() - 20) / (sigma * sigma), std::exp(-1.0),
              0.1);
}

Scenario with_known_points(double sigma_m, double sigma_px, double drift_m_s = 0.0) {
  Scenario s = scenario_preset("outdoor").value();
  s.sea.concentration = 0.0;
  s.sea.isolated_count = 1;
  s.sea.lead_count = 0;
  s.aircraft.legs = 2;
  s.drift_north_m_s = drift_m_s;
  s.known_points.anchor = true;
  s.known_points.anchor_north_m = 40.0;
  s.known_points.anchor_height_m = 3.0;
  s.known_points.anchor_sigma_m = sigma_m;
  s.known_points.anchor_sigma_px = sigma_px;
  s.known_points.anchor_sightings = 0;
  s.known_points.range_rate_hz = 5.0;
  s.known_points.range_noise_m = 0.0;
  return s;
}

TEST(Recording, AnAnchorIsMarkedWhereTheTrueCameraSeesIt) {
  for (const double drift_m_s : {0.0, 0.4}) {
    const Simulation run = simulate(with_known_points(0.0, 0.0, drift_m_s)).value();
    ASSERT_EQ(run.flight.anchors.size(), 1u);
    const Anchor& anchor = run.flight.anchors[0];
    EXPECT_EQ(anchor.place.has_value(), drift_m_s == 0.0);
    ASSERT_GT(anchor.sightings.size(), 20u);
    for (const AnchorSighting& s : anchor.sightings) {
      std::size_t i = 0;
      while (run.flight.frames[i].name != s.frame) ++i;
      const TrueFrame& frame = run.truth.frames[i];
      const AnchorPlace place = anchor.at(frame.captured_at).value();
      const Geodetic at{place.latitude, place.longitude, place.height_m};
      const auto px =
          run.flight.camera.project(frame.world_from_camera.inverse() * run.flight.datum.world(at));
      ASSERT_TRUE(px);
      EXPECT_NEAR(px->u, s.px.u, 0.01);
      EXPECT_NEAR(px->v, s.px.v, 0.01);
    }
  }
}

TEST(Recording, AnAnchorsErrorsAreThoseAskedFor) {
  const Simulation exact = simulate(with_known_points(0.0, 0.0)).value();
  const Anchor& truth = exact.flight.anchors[0];
  std::vector<double> place, pixel;
  for (int seed = 1; seed <= 20; ++seed) {
    Scenario s = with_known_points(2.0, 0.5);
    s.seed = seed;
    const Anchor anchor = simulate(s).value().flight.anchors.at(0);
    EXPECT_EQ(anchor.sigma_m, 2.0);
    const auto world = [&](const Anchor& a) {
      return exact.flight.datum.world({a.place->latitude, a.place->longitude, a.place->height_m}).v;
    };
    const Eigen::Vector3d off = world(anchor) - world(truth);
    for (const double x : {off.x(), off.y(), off.z()}) place.push_back(x);
    if (seed > 1) continue;  // the gusts of another seed see it elsewhere
    for (std::size_t k = 0; k < truth.sightings.size(); ++k)
      for (const AnchorSighting& m : anchor.sightings)
        if (m.frame == truth.sightings[k].frame) {
          pixel.push_back(m.px.u - truth.sightings[k].px.u);
          pixel.push_back(m.px.v - truth.sightings[k].px.v);
        }
  }
  EXPECT_NEAR(deviation(place), 2.0, 0.5);
  ASSERT_GT(pixel.size(), 40u);
  EXPECT_NEAR(deviation(pixel), 0.5, 0.15);
  Scenario few = with_known_points(0.0, 0.0);
  few.known_points.anchor_sightings = 4;
  EXPECT_EQ(simulate(few).value().flight.anchors.at(0).sightings.size(), 4u);
}

TEST(Recording, RangesAreAlongTheBodysDownAxisToTheSea) {
  const Simulation run = simulate(with_known_points(0.0, 0.0)).value();
  ASSERT_GT(run.flight.ranges.size(), 100u);
  // Poses are exact in this scenario but for the navigation's errors, which are not asked for.
  Scenario exact = with_known_points(0.0, 0.0);
  exact.navigation.nav_position_sigma_m = exact.navigation.nav_attitude_sigma_deg = 0.0;
  const Flight flight = simulate(exact).value().flight;
  const double sea_m = exact.sea_height_ellipsoid_m;
  for (const RangeSample& range : flight.ranges) {
    const auto pose = flight.trajectory.at(range.time, seconds(1.0));
    ASSERT_TRUE(pose);
    const Point<World> hit{(pose->world_from_body * Point<Body>{{0, 0, range.range_m}}).v};
    EXPECT_NEAR(flight.datum.geodetic(hit).height_ellipsoid_m, sea_m, 0.02);
  }
}

TEST(Recording, ABiasedBarometerPutsAllPosesTooHigh) {
  Scenario s = with_known_points(0.0, 0.0);
  const Flight exact = simulate(s).value().flight;
  s.navigation.nav_height_bias_m = 8.0;
  const Flight biased = simulate(s).value().flight;
  for (std::size_t i = 0; i < exact.trajectory.poses().size(); i += 100) {
    const auto height = [&](const Flight& f) {
      return f.datum.geodetic(f.trajectory.poses()[i].world_from_body.origin()).height_ellipsoid_m;
    };
    EXPECT_NEAR(height(biased) - height(exact), 8.0, 1e-6);
  }
}

TEST(Recording, TheCountersCanBeUnrecorded) {
  Scenario s = laboratory();
  s.camera.counter_recorded = false;
  const Simulation run = simulate(s).value();
  for (const ImageFrame& frame : run.flight.frames) EXPECT_FALSE(frame.counter.has_value());
}

TEST(Recording, TheTrueMountIsOffByWhatWasAskedInADirectionOfItsOwn) {
  std::vector<Eigen::Vector3d> axes;
  for (int seed = 1; seed <= 12; ++seed) {
    Scenario s = laboratory(seed);
    s.aircraft.hover.hover_duration_s = 2.0;
    const Simulation run = simulate(s).value();
    const Eigen::Quaterniond off = run.flight.mount.rotation.conjugate() * run.truth.mount.rotation;
    EXPECT_NEAR(angle_between(run.flight.mount.rotation, run.truth.mount.rotation).degrees(), 2.0,
                1e-9);
    EXPECT_NEAR((run.truth.mount.lever_arm_m - run.flight.mount.lever_arm_m).norm(), 0.05, 1e-12);
    axes.push_back(off.vec().normalized());
    // The camera sits as the true mount says.
    for (const TrueFrame& frame : run.truth.frames) {
      const Rigid3<Body, Camera> mount(run.truth.mount.rotation,
                                       Point<Body>{run.truth.mount.lever_arm_m});
      const Rigid3<World, Camera> expected = frame.world_from_body * mount;
      EXPECT_LT((expected.origin() - frame.world_from_camera.origin()).v.norm(), 1e-8);
      EXPECT_LT(angle_between(expected.rotation(), frame.world_from_camera.rotation()).radians(),
                1e-7);
    }
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& axis : axes) sum += axis;
  EXPECT_LT(sum.norm() / 12.0, 0.75);  // 1 for one direction, 0.27 on average for random ones
}

TEST(Recording, AttitudeAndPositionForgetTheirErrorsInTheirOwnTimes) {
  Scenario s = laboratory();
  s.navigation.pose_rate_hz = 2.0;
  s.camera.frame_rate_hz = 0.2;
  s.aircraft.hover.hover_duration_s = 20000.0;
  const Simulation exact = simulate(s).value();
  s.navigation.nav_position_sigma_m = 1.0;
  s.navigation.nav_correlation_s = 60.0;
  s.navigation.nav_attitude_sigma_deg = 0.7;
  s.navigation.nav_attitude_correlation_s = 10.0;
  const Simulation noisy = simulate(s).value();
  const auto &a = exact.flight.trajectory.poses(), &b = noisy.flight.trajectory.poses();
  ASSERT_EQ(a.size(), b.size());
  std::vector<double> north, yaw;
  for (std::size_t i = 0; i < a.size(); ++i) {
    north.push_back((b[i].world_from_body.origin() - a[i].world_from_body.origin()).v.x());
    const Eigen::Quaterniond off =
        a[i].world_from_body.rotation().conjugate() * b[i].world_from_body.rotation();
    yaw.push_back(2.0 * off.z() * (off.w() < 0 ? -1 : 1));
    EXPECT_FALSE(b[i].sigma.has_value());  // the preset records none
  }
  const auto correlation = [](const std::vector<double>& x, std::size_t lag) {
    double product = 0.0, power = 0.0;
    for (std::size_t i = lag; i < x.size(); ++i) {
      product += x[i] * x[i - lag];
      power += x[i] * x[i];
    }
    return product / power;
  };
  EXPECT_NEAR(correlation(north, 120), std::exp(-1.0), 0.15);
  EXPECT_NEAR(correlation(yaw, 20), std::exp(-1.0), 0.1);
  EXPECT_NEAR(deviation(yaw), 0.7 * 3.14159 / 180.0, 0.1 * 0.0122);
}

TEST(Recording, TheTruthKnowsTheNavigationsErrorAtEachFrame) {
  Scenario s = scenario_preset("outdoor").value();
  s.sea.paper_patches = true;  // quicker made than ice
  const Simulation run = simulate(s).value();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TrueFrame& frame : run.truth.frames) {
    const StampedPose recorded =
        run.flight.trajectory.at(frame.captured_at, std::chrono::seconds(1)).value();
    const Eigen::Vector3d error =
        recorded.world_from_body.origin().v - frame.world_from_body.origin().v;
    EXPECT_LT((error - frame.navigation_error_m).norm(), 1e-12);
    sum += error;
  }
  EXPECT_LT(
      (sum / static_cast<double>(run.truth.frames.size()) - run.truth.mean_navigation_error_m())
          .norm(),
      1e-9);
  EXPECT_GT(run.truth.mean_navigation_error_m().norm(), 0.1);
  EXPECT_NEAR(to_seconds(run.truth.frames.back().captured_at - run.truth.start), 135.0, 15.0);
}

TEST(Recording, TheMissionFrameMayBeTurnedFromNorth) {
  Scenario s = laboratory();
  s.camera.capture_recorded = true;
  s.camera.mount_error_deg = s.camera.lever_error_m = 0.0;
  const Simulation run = simulate(s).value();
  EXPECT_EQ(run.flight.datum.x_azimuth().degrees(), 37.0);
  for (std::size_t i = 0; i < run.flight.frames.size(); i += 100) {
    const auto pose =
        run.flight.camera_pose(run.flight.frames[i], std::chrono::milliseconds(200)).value();
    const auto& truth = run.truth.frames[i].world_from_camera;
    EXPECT_LT((pose.world_from_camera.origin() - truth.origin()).v.norm(), 1e-4);
    EXPECT_LT(angle_between(pose.world_from_camera.rotation(), truth.rotation()).radians(), 1e-4);
    EXPECT_NEAR(pose.camera.height_ellipsoid_m - 75.0, 1.5, 0.6);
  }
}

TEST(Recording, CompressionTouchesThePictureAndNothingElse) {
  Scenario s = laboratory();
  const Simulation compressed = simulate(s).value();
  s.sensor.jpeg_quality = 0;
  const Simulation plain = simulate(s).value();
  const cv::Mat a = plain.flight.frames[40].load({}).value(),
                b = compressed.flight.frames[40].load({}).value();
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.type(), b.type());
  const double rms = cv::norm(a, b, cv::NORM_L2) / std::sqrt(static_cast<double>(a.total()));
  EXPECT_GT(rms, 0.5);
  EXPECT_LT(rms, 5.0);
  s.sensor.jpeg_quality = 70;
  s.sensor.bits = 16;
  EXPECT_NE(simulate(s).error().message.find("jpeg_quality"), std::string::npos);
}

}  // namespace
}  // namespace watersky::sim
