// SPDX-License-Identifier: MIT
#include "watersky/sim/simulate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>

#include "watersky/geo/rotation.hpp"

#include "support/real_data.hpp"

namespace watersky::sim {
namespace {

constexpr Duration kGap = std::chrono::milliseconds(200);

Scenario quick(std::string_view preset) {
  Scenario s = scenario_preset(preset).value();
  s.sea.extent_north_m = 160.0;
  s.sea.extent_east_m = 120.0;
  s.sea.isolated_count = 5;
  s.sea.isolated_max_m = 6.0;
  s.sea.concentration = 0.3;
  s.sea.floe_max_m = 30.0;
  s.lens.focal_px *= 160.0 / s.lens.width_px;
  s.lens.width_px = 160;
  s.lens.height_px = 128;
  s.lens.centre_right_px = 1.1;
  s.lens.centre_down_px = -0.7;
  s.aircraft.legs = 2;
  s.aircraft.leg_length_m = 100.0;
  return s;
}

TEST(Scenario, NamesEachParameterOnceAndPresetsAreInRange) {
  for (const std::string_view preset : scenario_preset_names()) {
    const Scenario s = scenario_preset(preset).value();
    std::set<std::string> names;
    int count = 0;
    Scenario::describe(s, [&](const auto&, const ParameterInfo& info) {
      names.insert(std::string(info.name));
      ++count;
    });
    EXPECT_EQ(names.size(), static_cast<std::size_t>(count));
    EXPECT_TRUE(validate(s).ok()) << preset << ": " << validate(s).error().message;
  }
  EXPECT_NE(scenario_preset("calm").error().message.find("not_easy"), std::string::npos);
}

TEST(Scenario, TheAcceptanceFlightHasContrastOfFourTimesTheNoise) {
  for (const char* preset : {"not_easy", "not_easy_oblique"}) {
    const Scenario s = scenario_preset(preset).value();
    EXPECT_LE(s.sensor.contrast_counts, 4.0 * s.sensor.noise_counts);
    EXPECT_EQ(s.aircraft.height_m, 100.0);
    EXPECT_NE(s.lens.k1, 0.0);
  }
  EXPECT_EQ(scenario_preset("not_easy_oblique").value().camera.mount_pitch_deg, -60.0);
}

// The recorded poses, mount and gimbal, put together by the flight module, against the exact pose
// of the camera. What remains is interpolation between poses 20 ms apart: with a gust of 2° rms
// below 0.8 Hz (h²/8 times its acceleration) at most 0.15 mrad.
TEST(Simulate, RecordsWhatTheCameraDid) {
  for (const char* preset : {"not_easy", "not_easy_oblique", "far"})
    for (const int gimbal : {0, 1, 2}) {
      Scenario s = quick(preset);
      s.camera.gimbal = gimbal;
      s.camera.mount_roll_deg = 7.0;
      s.camera.mount_yaw_deg = -25.0;
      s.camera.mount_y_m = -0.4;
      s.aircraft.leg_azimuth_deg = 130.0;
      s.camera.images_in_turns = true;
      const Simulation run = simulate(s).value();
      ASSERT_GT(run.flight.frames.size(), 10u);
      for (std::size_t i = 0; i < run.flight.frames.size(); ++i) {
        const auto pose = run.flight.camera_pose(run.flight.frames[i], kGap);
        ASSERT_TRUE(pose.ok()) << pose.error().message;
        const auto& truth = run.truth.frames[i].world_from_camera;
        EXPECT_EQ(pose->time, run.truth.frames[i].captured_at);
        EXPECT_LT((pose->world_from_camera.origin() - truth.origin()).v.norm(), 2e-3)
            << preset << gimbal;
        EXPECT_LT(angle_between(pose->world_from_camera.rotation(), truth.rotation()).radians(),
                  3e-4)
            << preset << gimbal;
      }
    }
}

// The library's own chain from an object in World to a pixel, against where the simulator shows
// it: a bright disc alone on the sea, 40 km from the datum, oblique, distorted, with lever arm.
TEST(Simulate, ShowsAFloe40KmFromTheDatumWhereTheMissionsGeometryExpectsIt) {
  Outline disc;
  for (int k = 0; k < 48; ++k)
    disc.emplace_back(20.0 + 1.5 * std::cos(k * 0.1309), -12.0 + 1.5 * std::sin(k * 0.1309));
  const Sea sea = Sea::from_outlines({disc}, {true}, {200, 200}).value();
  for (const char* preset : {"not_easy", "far"}) {
    Scenario s = quick(preset);
    s.camera.mount_pitch_deg = -65.0;
    s.sensor.contrast_counts = 150.0;
    s.sensor.noise_counts = s.sensor.pattern_counts = 0.0;
    s.sensor.water_texture = s.sensor.ice_texture = s.sensor.floe_variation = 0.0;
    s.sensor.vignetting = 0.0;
    s.camera.frame_rate_hz = 3.0;
    s.aircraft.leg_azimuth_deg = 40.0;
    const Simulation run = simulate(s, sea).value();
    const Point<World> p = run.truth.world({20.0, -12.0});
    if (std::string(preset) == "far") {
      EXPECT_NEAR(p.v.head<2>().norm(), 40000.0, 60.0);
      // The Earth falls away by d²/2R = 125.6 m below the datum's plane.
      EXPECT_NEAR(p.v.z(), 12.0 + 125.6, 0.8);
    }
    EXPECT_NEAR(run.flight.datum.geodetic(p).height_ellipsoid_m, 30.0, 1e-4);
    int compared = 0;
    for (const ImageFrame& frame : run.flight.frames) {
      const auto pose = run.flight.camera_pose(frame, kGap).value();
      const auto pixel = run.flight.camera.project(pose.world_from_camera.inverse() * p);
      if (!pixel || pixel->u < 12 || pixel->v < 12 || pixel->u > 147 || pixel->v > 115) continue;
      cv::Mat image = frame.load({}).value();
      cv::Mat bright;
      cv::subtract(image, 100, bright);
      const cv::Moments m = cv::moments(bright);
      ASSERT_GT(m.m00, 0.0);
      // The middle of the image of a disc of 1.5 m is not the image of its middle: 0.05 px here.
      EXPECT_NEAR(m.m10 / m.m00, pixel->u, 0.12) << preset;
      EXPECT_NEAR(m.m01 / m.m00, pixel->v, 0.12) << preset;
      ++compared;
    }
    EXPECT_GE(compared, 5) << preset;
  }
}

TEST(Simulate, ObjectsOfTheTruthLieOnTheSeaAroundTheScenesAnchor) {
  const Simulation run = simulate(quick("far")).value();
  const Sea& sea = run.truth.sea;
  for (const IceObject& object : sea.objects()) {
    const Geodetic by_scene = sea.geodetic(object.centre_north_east_m);
    const Geodetic by_world =
        run.flight.datum.geodetic(run.truth.world(object.centre_north_east_m));
    EXPECT_NEAR(by_scene.height_ellipsoid_m, 30.0, 1e-5);
    EXPECT_LT((ecef_from(by_scene) - ecef_from(by_world)).v.norm(), 1e-6);
    // Back into the anchor's tangent frame by the library's own way.
    const Point<watersky::Sea> p = ecef_from_sea(sea.anchor()).inverse() * ecef_from(by_scene);
    EXPECT_LT((p.v.head<2>() - object.centre_north_east_m).norm(), 1e-6);
  }
}

TEST(Simulate, IsDeterministicAndRendersInAnyOrder) {
  const Simulation a = simulate(quick("not_easy")).value(), b = simulate(quick("not_easy")).value();
  ASSERT_EQ(a.flight.frames.size(), b.flight.frames.size());
  const std::size_t last = a.flight.frames.size() - 1;
  const cv::Mat a0 = a.flight.frames[0].load({}).value(),
                al = a.flight.frames[last].load({}).value();
  const cv::Mat bl = b.flight.frames[last].load({}).value(),
                b0 = b.flight.frames[0].load({}).value();
  EXPECT_EQ(cv::norm(a0, b0, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(al, bl, cv::NORM_INF), 0.0);
  Scenario other = quick("not_easy");
  other.seed = 2;
  const Simulation c = simulate(other).value();
  EXPECT_GT(cv::norm(a0, c.flight.frames[0].load({}).value(), cv::NORM_INF), 5.0);
  // The seed of the flight leaves the sea as it is.
  EXPECT_EQ(a.truth.sea.pieces()[0], c.truth.sea.pieces()[0]);
}

TEST(Simulate, ReducesImagesByAreaAndInColourToGrey) {
  Scenario s = quick("visible");
  s.lens.width_px = 162;
  const Simulation run = simulate(s).value();
  const ImageLoader& load = run.flight.frames[1].load;
  const cv::Mat full = load({}).value();
  ASSERT_EQ(full.type(), CV_8UC3);
  EXPECT_EQ(full.size(), cv::Size(162, 128));
  EXPECT_EQ(load({.color = false}).value().type(), CV_8UC1);
  for (const int reduction : {2, 4, 8}) {
    const cv::Mat reduced = load({.reduction = reduction}).value();
    EXPECT_EQ(reduced.size(), cv::Size((162 + reduction - 1) / reduction, 128 / reduction));
    EXPECT_NEAR(cv::mean(reduced)[1], cv::mean(full)[1], 0.6);
  }
  EXPECT_FALSE(load({.reduction = 3}).ok());
}

// Real thermal images of sea ice at about 1 m/px with hand-made masks (PANGAEA.971908).
TEST(Simulate, FliesOverARealThermalImage) {
  const auto folder = test::real_data("tir_sea_ice");
  if (!folder) GTEST_SKIP() << "no tir_sea_ice; set WATERSKY_DATA";
  const std::string data = folder->string();
  const cv::Mat picture = cv::imread(data + "/images/train_00.png", cv::IMREAD_GRAYSCALE);
  const cv::Mat classes = cv::imread(data + "/masks/train_00.png", cv::IMREAD_UNCHANGED);
  if (picture.empty() || classes.empty()) GTEST_SKIP() << "no image in " << data;
  const cv::Mat ice = classes == 1;
  const Sea sea = Sea::from_raster(ice, picture, 1.0).value();
  EXPECT_NEAR(sea.concentration(), cv::countNonZero(ice) / (480.0 * 480.0), 1e-9);

  Scenario s = quick("not_easy");
  s.aircraft.height_m = 200.0;
  s.sensor.contrast_counts = 60.0;
  const Simulation run = simulate(s, sea).value();
  // Straight down from the truth's own pose: what is ice in the mask is brighter on average.
  const CameraPose pose = run.flight.camera_pose(run.flight.frames[4], kGap).value();
  const cv::Mat image = run.flight.frames[4].load({}).value();
  double sum[2]{}, count[2]{};
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const Eigen::Vector3d d =
          (pose.sea_from_camera * *run.flight.camera.direction({1.0 * u, 1.0 * v})).v;
      const Eigen::Vector3d o = pose.sea_from_camera.origin().v;
      const Point<watersky::Sea> p{o - o.z() / d.z() * d};
      const Eigen::Vector3d scene =
          (ecef_from_sea(run.truth.sea.anchor()).inverse() * (ecef_from_sea(pose.sea_below) * p)).v;
      const bool is_ice = run.truth.sea.is_ice(scene.x(), scene.y());
      sum[is_ice] += image.at<unsigned char>(v, u);
      ++count[is_ice];
    }
  ASSERT_GT(count[0], 500);
  ASSERT_GT(count[1], 500);
  EXPECT_GT(sum[1] / count[1] - sum[0] / count[0], 25.0);
}

TEST(Simulate, NavigationErrorsAreOffByDefaultAndOfTheirSigmaWhenOn) {
  Scenario s = quick("not_easy");
  s.aircraft.leg_length_m = 2000.0;
  const Simulation exact = simulate(s).value();
  EXPECT_FALSE(exact.flight.trajectory.poses()[0].sigma.has_value());
  s.navigation.nav_position_sigma_m = 0.5;
  s.navigation.nav_attitude_sigma_deg = 0.8;
  s.navigation.nav_correlation_s = 0.0;
  const Simulation noisy = simulate(s).value();
  const auto &a = exact.flight.trajectory.poses(), &b = noisy.flight.trajectory.poses();
  ASSERT_EQ(a.size(), b.size());
  double place = 0.0, turn = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    place += (a[i].world_from_body.origin() - b[i].world_from_body.origin()).v.squaredNorm() / 3.0;
    turn += std::pow(angle_between(a[i].world_from_body.rotation(), b[i].world_from_body.rotation())
                         .degrees(),
                     2) /
            3.0;
  }
  EXPECT_NEAR(std::sqrt(place / static_cast<double>(a.size())), 0.5, 0.015);
  EXPECT_NEAR(std::sqrt(turn / static_cast<double>(a.size())), 0.8, 0.025);
  EXPECT_EQ(b[0].sigma->position_north_east_down_m.x(), 0.5);
  // The truth is not touched.
  EXPECT_EQ(exact.truth.frames[3].world_from_camera.origin().v,
            noisy.truth.frames[3].world_from_camera.origin().v);
}

TEST(Simulate, ANavigationDelayStampsPosesLate) {
  Scenario s = quick("not_easy");
  const Simulation on_time = simulate(s).value();
  s.navigation.nav_delay_s = 0.2;
  const Simulation late = simulate(s).value();
  EXPECT_EQ(late.flight.trajectory.poses()[7].time - on_time.flight.trajectory.poses()[7].time,
            std::chrono::milliseconds(200));
  EXPECT_EQ(late.flight.trajectory.poses()[7].world_from_body.origin().v,
            on_time.flight.trajectory.poses()[7].world_from_body.origin().v);
}

TEST(Simulate, ArrivalComesAfterCaptureAndCaptureCanBeUnrecorded) {
  Scenario s = quick("not_easy");
  s.camera.arrival_delay_s = 0.15;
  s.camera.arrival_jitter_s = 0.02;
  s.camera.capture_recorded = false;
  const Simulation run = simulate(s).value();
  std::set<Duration> delays;
  for (std::size_t i = 0; i < run.flight.frames.size(); ++i) {
    const ImageFrame& frame = run.flight.frames[i];
    EXPECT_FALSE(frame.captured_at.has_value());
    const Duration delay = *frame.received_at - run.truth.frames[i].captured_at;
    EXPECT_GE(delay, std::chrono::milliseconds(150));
    EXPECT_LT(delay, std::chrono::milliseconds(300));
    delays.insert(delay);
    EXPECT_FALSE(run.flight.capture_time(frame).ok());  // time is never guessed
  }
  EXPECT_GT(delays.size(), 5u);
}

TEST(Simulate, NamesTheParameterAtFault) {
  Scenario s = quick("not_easy");
  s.aircraft.height_m = -3.0;
  EXPECT_NE(simulate(s).error().message.find("height_m"), std::string::npos);
  s = quick("not_easy");
  s.sensor.bits = 10;
  EXPECT_NE(simulate(s).error().message.find("bits"), std::string::npos);
  s = quick("not_easy");
  s.sea.concentration = 0.9;
  EXPECT_EQ(simulate(s).error().code, ErrorCode::OutOfRange);
}

}  // namespace
}  // namespace watersky::sim
