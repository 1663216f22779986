// SPDX-License-Identifier: MIT
#include "watersky/align/alignment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "watersky/align/detail/test_flight.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

using test::small_flight;

/// How far the sea point in a picture's middle lies from where it is, root mean square.
double error_m(const Flight& flight, const sim::Simulation& simulation) {
  double square = 0.0;
  int n = 0;
  for (const ImageFrame& frame : flight.frames) {
    const auto same = std::find_if(simulation.flight.frames.begin(), simulation.flight.frames.end(),
                                   [&](const ImageFrame& f) { return f.name == frame.name; });
    const auto& truth =
        simulation.truth.frames[static_cast<std::size_t>(same - simulation.flight.frames.begin())];
    const auto pose = flight.camera_pose(frame, std::chrono::seconds(1));
    if (!pose) continue;
    const auto hit = [](const Rigid3<Sea, Camera>& sea_from_camera) -> Eigen::Vector2d {
      const Eigen::Vector3d ray = sea_from_camera.rotation() * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d& p = sea_from_camera.origin().v;
      return (p - p.z() / ray.z() * ray).head<2>();
    };
    const Rigid3<Sea, World> sea_from_world =
        ecef_from_sea(pose->sea_below).inverse() * flight.datum.ecef_from_world();
    square +=
        (hit(pose->sea_from_camera) - hit(sea_from_world * truth.world_from_camera)).squaredNorm();
    ++n;
  }
  return n == 0 ? std::numeric_limits<double>::infinity() : std::sqrt(square / n);
}

const sim::Simulation& flown() {
  static const sim::Simulation simulation = test::simulated(small_flight());
  return simulation;
}

const Alignment& found() {
  static const Alignment alignment = align_flight(flown().flight, {}).value();
  return alignment;
}

TEST(AlignFlight, FindsDelayAndMountAndPutsTheSeaWhereItIs) {
  const Alignment& alignment = found();
  EXPECT_EQ(alignment.method, AlignMethod::Full) << alignment.method_reason;
  EXPECT_LT(alignment.after.median_m, 0.3 * alignment.constant_delay.median_m);
  const auto corrected = aligned(flown().flight, alignment);
  ASSERT_TRUE(corrected) << corrected.error().message;
  double worst_s = 0.0;
  for (const AlignedFrame& f : alignment.frames)
    worst_s = std::max(
        worst_s, std::abs(to_seconds(f.captured - flown().truth.frames[f.index].captured_at)));
  EXPECT_LT(worst_s, 0.06);
  Flight constant = flown().flight;
  constant.delay_s = 0.25;
  // What is left is the mean error of the navigation, which no image shows.
  EXPECT_LT(error_m(*corrected, flown()), 0.6 * error_m(constant, flown()));
  // In half a minute the attitude's own error of 0.7° hardly averages out.
  EXPECT_LT(angle_between(corrected->mount.rotation, flown().truth.mount.rotation).degrees(), 1.7);
}

TEST(AlignFlight, IsTheSameEachTime) {
  const auto again = align_flight(flown().flight, {});
  ASSERT_TRUE(again);
  ASSERT_EQ(again->frames.size(), found().frames.size());
  for (std::size_t i = 0; i < again->frames.size(); ++i)
    EXPECT_EQ(again->frames[i].captured, found().frames[i].captured);
}

TEST(AlignFlight, KeepsCaptureTimesThatAreKnown) {
  Flight flight = flown().flight;
  for (std::size_t i = 0; i < flight.frames.size(); ++i)
    flight.frames[i].captured_at = flown().truth.frames[i].captured_at;
  const auto alignment = align_flight(flight, {});
  ASSERT_TRUE(alignment) << alignment.error().message;
  EXPECT_FALSE(alignment->delay_estimated);
  for (const AlignedFrame& f : alignment->frames)
    EXPECT_EQ(f.captured, *flight.frames[f.index].captured_at);
}

TEST(AlignFlight, CovariancesAreThoseOfTheErrors) {
  const Alignment& alignment = found();
  const Flight corrected = aligned(flown().flight, alignment).value();
  // Of a flight of half a minute under errors of a minute the offset is nearly all there is.
  const double said_m = std::sqrt(alignment.shared_covariance_m2.trace());
  const double is_m = error_m(corrected, flown());
  EXPECT_GT(said_m, 0.3);
  EXPECT_LT(is_m, 3.0 * said_m);
}

TEST(AlignFlight, PosesStandAtTheFramesOwnTimesAndSpanTheReadout) {
  sim::Scenario scenario = small_flight();
  scenario.sensor.readout_s = 0.02;
  scenario.aircraft.legs = 1;
  const auto simulation = sim::simulate(scenario).value();
  const auto alignment = align_flight(simulation.flight, {}).value();
  const Flight corrected = aligned(simulation.flight, alignment).value();
  ASSERT_FALSE(corrected.frames.empty());
  for (const ImageFrame& f : corrected.frames) {
    ASSERT_TRUE(f.captured_at);
    const auto at = corrected.trajectory.at(*f.captured_at, Duration(0));
    ASSERT_TRUE(at) << at.error().message;
    EXPECT_TRUE(at->covariance);
    for (const double half_s : {-0.01, 0.01})
      EXPECT_TRUE(corrected.trajectory.at(*f.captured_at + seconds(half_s), seconds(0.011)));
  }
}

TEST(AlignFlight, SaysWhatItCannotDoAndStillAnswers) {
  {  // one frame
    Flight flight = flown().flight;
    flight.frames.resize(1);
    const auto alignment = align_flight(flight, {});
    ASSERT_TRUE(alignment);
    EXPECT_EQ(alignment->method, AlignMethod::AsGiven);
    EXPECT_FALSE(alignment->method_reason.empty());
  }
  {  // nothing to hold on to
    sim::Scenario scenario = small_flight();
    scenario.aircraft.legs = 1;
    scenario.sensor.water_texture = 0;
    const auto water = sim::Sea::from_outlines({}, {}, {400, 300});
    ASSERT_TRUE(water) << water.error().message;
    const auto simulation = sim::simulate(scenario, *water).value();
    const auto alignment = align_flight(simulation.flight, {});
    ASSERT_TRUE(alignment) << alignment.error().message;
    EXPECT_EQ(alignment->method, AlignMethod::AsGiven);
    EXPECT_FALSE(alignment->method_reason.empty());
  }
  {  // images that cannot be read
    Flight flight = flown().flight;
    for (ImageFrame& f : flight.frames)
      f.load = [](const ImageRequest&) {
        return Result<cv::Mat>(Error{ErrorCode::NotFound, "gone"});
      };
    const auto alignment = align_flight(flight, {});
    ASSERT_TRUE(alignment) << alignment.error().message;
    EXPECT_EQ(alignment->method, AlignMethod::AsGiven);
    EXPECT_FALSE(alignment->method_reason.empty());
  }
  {  // the height of the sea is never guessed
    Flight flight = flown().flight;
    flight.sea_level.reset();
    const auto alignment = align_flight(flight, {});
    ASSERT_FALSE(alignment);
    EXPECT_EQ(alignment.error().code, ErrorCode::NotFound);
  }
}

TEST(AlignFlight, ParametersOutOfRangeAreRefused) {
  AlignOptions options;
  options.parameters.tracked_points = 1;
  const auto alignment = align_flight(flown().flight, options);
  ASSERT_FALSE(alignment);
  EXPECT_EQ(alignment.error().code, ErrorCode::Usage);
}

/// What `flown` knows from outside when asked for more: the same sea, aircraft and camera.
sim::Simulation flown_with(const std::function<void(sim::Scenario&)>& more) {
  sim::Scenario scenario = small_flight();
  more(scenario);
  sim::Simulation made = sim::simulate(scenario).value();
  for (std::size_t i = 0; i < made.flight.frames.size(); ++i)
    made.flight.frames[i].load = flown().flight.frames[i].load;
  return made;
}

void with_anchor(sim::Scenario& s) {
  s.known_points.anchor = true;
  s.known_points.anchor_north_m = 25.0;
  s.known_points.anchor_east_m = -10.0;
}

TEST(AlignWithKnownPoints, OneAnchorPutsTheWholeFlightWhereItIs) {
  const sim::Simulation simulation = flown_with(with_anchor);
  ASSERT_EQ(simulation.flight.anchors.size(), 1u);
  ASSERT_EQ(simulation.flight.anchors[0].sightings.size(), 5u);
  const auto alignment = align_flight(simulation.flight, {});
  ASSERT_TRUE(alignment) << alignment.error().message;
  EXPECT_EQ(alignment->method, AlignMethod::Full) << alignment->method_reason;
  const Flight corrected = aligned(simulation.flight, *alignment).value();
  const Flight without = aligned(flown().flight, found()).value();
  EXPECT_LT(error_m(corrected, simulation), 0.5);
  EXPECT_LT(error_m(corrected, simulation), error_m(without, flown()));
  // Half of what an anchor of 0.1 m and pixels of 0.35 m can tell is already much better known.
  EXPECT_LT(alignment->shared_covariance_m2.trace(), 0.2 * found().shared_covariance_m2.trace());
  ASSERT_EQ(alignment->anchors.size(), 1u);
  const AnchorOutcome& anchor = alignment->anchors[0];
  EXPECT_EQ(anchor.used, 5u);
  EXPECT_LT(anchor.after_rms_m, 0.4);
  EXPECT_GT(anchor.as_given_rms_m, 2.0 * anchor.after_rms_m);
  EXPECT_THAT(alignment->notes, Contains(HasSubstr("Anchor anchor was used, seen in 5 frames")));
  // They are kept for whoever reads the corrected flight.
  EXPECT_EQ(corrected.anchors.size(), 1u);
}

TEST(AlignWithKnownPoints, AMarkInOneFrameIsEnough) {
  sim::Simulation simulation = flown_with(with_anchor);
  simulation.flight.anchors[0].sightings.resize(1);
  const auto alignment = align_flight(simulation.flight, {});
  ASSERT_TRUE(alignment) << alignment.error().message;
  EXPECT_LT(error_m(aligned(simulation.flight, *alignment).value(), simulation), 0.6);
}

TEST(AlignWithKnownPoints, AWrongPlaceAndAWrongPixelAreNamedAndSpoilNothing) {
  sim::Simulation simulation = flown_with(with_anchor);
  Anchor& anchor = simulation.flight.anchors[0];
  const Anchor right = anchor;
  anchor.place->latitude = Angle::degrees(anchor.place->latitude.degrees() + 40.0 / 111'660.0);
  const auto wrong = align_flight(simulation.flight, {});
  ASSERT_TRUE(wrong) << wrong.error().message;
  EXPECT_THAT(wrong->notes, Contains(AllOf(HasSubstr("Anchor anchor: left out"),
                                           HasSubstr("where the navigation puts it"))));
  EXPECT_EQ(wrong->anchors.at(0).used, 0u);
  ASSERT_EQ(wrong->frames.size(), found().frames.size());
  for (std::size_t i = 0; i < wrong->frames.size(); ++i)
    EXPECT_LT((wrong->frames[i].pose.world_from_body.origin().v -
               found().frames[i].pose.world_from_body.origin().v)
                  .norm(),
              1e-9);

  anchor = right;
  anchor.sightings[1].px.v += 30.0;  // 10 m
  const auto pixel = align_flight(simulation.flight, {});
  ASSERT_TRUE(pixel) << pixel.error().message;
  EXPECT_EQ(pixel->anchors.at(0).used, 4u);
  EXPECT_THAT(pixel->notes, Contains(AllOf(HasSubstr("1 of its 5 sightings left out"),
                                           HasSubstr(anchor.sightings[1].frame))));
  EXPECT_LT(error_m(aligned(simulation.flight, *pixel).value(), simulation), 0.5);
}

// Frames that agree as they are still lie elsewhere as a whole.
TEST(AlignWithKnownPoints, AFlightThatAgreesWithItselfIsShiftedAllTheSame) {
  sim::Simulation simulation = flown_with([](sim::Scenario& s) {
    with_anchor(s);
    s.camera.mount_error_deg = s.camera.lever_error_m = 0.0;
    s.navigation.nav_position_sigma_m = s.navigation.nav_attitude_sigma_deg = 0.0;
  });
  std::vector<StampedPose> poses = simulation.flight.trajectory.poses();
  for (StampedPose& p : poses)
    p.world_from_body =
        Rigid3<World, Body>(p.world_from_body.rotation(),
                            Point<World>{p.world_from_body.origin().v + Eigen::Vector3d(3, -2, 0)});
  simulation.flight.trajectory = Trajectory::make(std::move(poses)).value();
  for (std::size_t i = 0; i < simulation.flight.frames.size(); ++i) {
    // Another mount: the pictures are rendered anew.
    simulation.flight.frames[i].captured_at = simulation.truth.frames[i].captured_at;
  }
  const sim::Simulation rendered = sim::simulate([] {
                                     sim::Scenario s = small_flight();
                                     s.camera.mount_error_deg = s.camera.lever_error_m = 0.0;
                                     return s;
                                   }())
                                       .value();
  for (std::size_t i = 0; i < simulation.flight.frames.size(); ++i)
    simulation.flight.frames[i].load = rendered.flight.frames[i].load;
  const auto alignment = align_flight(simulation.flight, {});
  ASSERT_TRUE(alignment) << alignment.error().message;
  EXPECT_EQ(alignment->method, AlignMethod::Full) << alignment->method_reason;
  EXPECT_LT(error_m(aligned(simulation.flight, *alignment).value(), simulation), 0.4);

  // Even where no picture can be tied to another.
  for (ImageFrame& f : simulation.flight.frames)
    f.load = [](const ImageRequest&) { return Result<cv::Mat>(cv::Mat(192, 240, CV_8U, 90)); };
  const auto plain = align_flight(simulation.flight, {});
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(plain->method, AlignMethod::Full) << plain->method_reason;
  EXPECT_LT(error_m(aligned(simulation.flight, *plain).value(), simulation), 1.0);
}

TEST(AlignWithKnownPoints, ARangeFinderMendsBiasedHeights) {
  const auto biased = [](sim::Scenario& s) { s.navigation.nav_height_bias_m = 8.0; };
  const sim::Simulation without = flown_with(biased);
  const sim::Simulation with = flown_with([&](sim::Scenario& s) {
    biased(s);
    s.known_points.range_rate_hz = 10.0;
  });
  ASSERT_GT(with.flight.ranges.size(), 100u);
  const auto height_error_m = [](const Flight& flight, const sim::Simulation& simulation) {
    double sum = 0.0;
    for (const ImageFrame& frame : flight.frames) {
      const auto at = std::find_if(simulation.flight.frames.begin(), simulation.flight.frames.end(),
                                   [&](const ImageFrame& f) { return f.name == frame.name; });
      const auto& truth =
          simulation.truth.frames[static_cast<std::size_t>(at - simulation.flight.frames.begin())];
      const auto pose = flight.camera_pose(frame, std::chrono::seconds(1)).value();
      sum += pose.camera.height_ellipsoid_m -
             flight.datum.geodetic(truth.world_from_camera.origin()).height_ellipsoid_m;
    }
    return sum / static_cast<double>(flight.frames.size());
  };
  const auto blind = align_flight(without.flight, {});
  const auto seeing = align_flight(with.flight, {});
  ASSERT_TRUE(blind) << blind.error().message;
  ASSERT_TRUE(seeing) << seeing.error().message;
  const Flight before = aligned(without.flight, *blind).value(),
               after = aligned(with.flight, *seeing).value();
  // Pictures over a known way flown show height as well, but not as well.
  EXPECT_LT(std::abs(height_error_m(after, with)), 0.4);
  EXPECT_LT(std::abs(height_error_m(after, with)), 0.5 * std::abs(height_error_m(before, without)));
  EXPECT_LT(seeing->ranges.as_given_m, -5.0);
  EXPECT_LT(std::abs(seeing->ranges.after_m), 0.3);
  EXPECT_THAT(seeing->notes, Contains(HasSubstr("too high")));
}

}  // namespace
}  // namespace watersky
