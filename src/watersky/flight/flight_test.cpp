// SPDX-License-Identifier: MIT
#include "watersky/flight/flight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/matchers.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky {
namespace {

using test::fails_with;
using test::IsNear;
using test::succeeds;

// What a mount is and what a pose is, the compiler knows.
static_assert(!std::is_convertible_v<Rigid3<World, Body>, Rigid3<World, Camera>>);
static_assert(!std::is_assignable_v<decltype(CameraPose::world_from_camera)&, Rigid3<World, Body>>);
static_assert(!std::is_assignable_v<decltype(CameraPose::sea_from_camera)&, Rigid3<World, Camera>>);
static_assert(!CanChain<Rigid3<Sea, Camera>, Point<World>>);
static_assert(!std::is_default_constructible_v<Flight>);

constexpr Duration kMaxGap = std::chrono::seconds(1);

Time at(double s) { return time_from_seconds(s).value(); }

Geodetic geodetic(double lat_deg, double lon_deg, double height_m) {
  return {Angle::degrees(lat_deg), Angle::degrees(lon_deg), height_m};
}

CameraModel camera() {
  Eigen::Matrix3d a;
  a << 500, 0, 319.5, 0, 500, 239.5, 0, 0, 1;
  return CameraModel::make(LensModel::Pinhole, 640, 480, a).value();
}

SeaLevel sea_at(double height_ellipsoid_m) {
  return {[=](const Geodetic&) -> Result<double> { return height_ellipsoid_m; }, "given", 0.0};
}

ImageFrame frame_at(double captured_s) {
  ImageFrame frame;
  frame.name = "a.jpg";
  frame.captured_at = at(captured_s);
  return frame;
}

const Geodetic kDatum = geodetic(78.9, 11.9, 30);
const Eigen::Quaterniond kLooksDown = camera_rotation({0_deg, -90_deg, 0_deg});

/// A body that stands still at `position` from 0 to 1 s.
Flight hovering(const Eigen::Quaterniond& world_from_body, const Point<World>& position) {
  Flight flight("hovering", Datum(kDatum), camera());
  const Rigid3<World, Body> pose(world_from_body, position);
  flight.trajectory =
      Trajectory::make({{at(0), pose, std::nullopt}, {at(1), pose, std::nullopt}}).value();
  flight.mount.rotation = kLooksDown;
  flight.sea_level = sea_at(30);
  return flight;
}

double degrees_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return angle_between(a, b).degrees();
}

TEST(CameraPose, OverTheDatumItIsTheBodyTimesTheMount) {
  Flight flight = hovering(heading(90_deg), {{0, 0, -100}});
  flight.mount.lever_arm_m = {2, 0, 0.5};  // forward and below
  const CameraPose pose = flight.camera_pose(frame_at(0.5), kMaxGap).value();
  // Nose east: the camera is 2 m east of the body, its image top points east.
  EXPECT_THAT(pose.world_from_camera.origin(), IsNear(Point<World>{{0, 2, -99.5}}, 1e-9));
  EXPECT_LT(
      (pose.world_from_camera.rotation() * -Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitY())
          .norm(),
      1e-9);
  EXPECT_LT(
      (pose.world_from_camera.rotation() * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ())
          .norm(),
      1e-9);
  EXPECT_EQ(pose.time, at(0.5));
  EXPECT_NEAR(pose.camera.height_ellipsoid_m, 129.5, 1e-5);
  EXPECT_NEAR(pose.sea_below.height_ellipsoid_m, 30.0, 1e-12);
  EXPECT_THAT(pose.sea_from_camera.origin(), IsNear(Point<Sea>{{0, 0, -99.5}}, 1e-5));
  EXPECT_FALSE(pose.sigma);
}

TEST(CameraPose, InterpolatesTheBody) {
  Flight flight = hovering(heading({}), {});
  flight.trajectory = Trajectory::make({{at(0), {heading(0_deg), {{0, 0, -50}}}, std::nullopt},
                                        {at(1), {heading(40_deg), {{20, 0, -50}}}, std::nullopt}})
                          .value();
  const CameraPose pose = flight.camera_pose(frame_at(0.25), kMaxGap).value();
  EXPECT_THAT(pose.world_from_camera.origin(), IsNear(Point<World>{{5, 0, -50}}, 1e-6));
  EXPECT_LT(degrees_between(pose.world_from_camera.rotation(), heading(10_deg) * kLooksDown), 1e-7);
}

TEST(CameraPose, AGimbalOnTheBodyStandsBetweenBodyAndCamera) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> turn(-60, 60);
  for (int i = 0; i < 100; ++i) {
    const auto random = [&] {
      return rotation_from(
          {Angle::degrees(turn(rng)), Angle::degrees(turn(rng)), Angle::degrees(turn(rng))});
    };
    const Eigen::Quaterniond body = random(), gimbal = random(), mount = random() * kLooksDown;
    Flight flight = hovering(body, {{10, -20, -100}});
    flight.gimbal_reference = GimbalReference::Body;
    flight.gimbal = RotationTrack::make({{at(0), gimbal}, {at(1), gimbal}}).value();
    flight.mount.rotation = mount;
    flight.mount.lever_arm_m = {0.1, 0.2, 0.3};
    const CameraPose pose = flight.camera_pose(frame_at(0.5), kMaxGap).value();
    EXPECT_LT(degrees_between(pose.world_from_camera.rotation(), body * gimbal * mount), 1e-6);
    // The lever arm turns with the gimbal.
    const Eigen::Vector3d expected =
        Eigen::Vector3d(10, -20, -100) + body * (gimbal * Eigen::Vector3d(0.1, 0.2, 0.3));
    EXPECT_THAT(pose.world_from_camera.origin(), IsNear(Point<World>{expected}, 1e-9));
  }
}

/// Where a body over 78.9 N 13.76 E, 130 m above the ellipsoid, is in the World of kDatum: 40 km
/// east of it (tests/reference/wgs84_world.csv).
const Point<World> kFortyKilometresEast{{636.939691081, 39985.386845558, 24.962599217}};

// The gimbal holds the camera level against the local north, whatever the body does; so in the
// sea's own frame the camera looks straight down with the image top north, exactly.
TEST(CameraPose, AGimbalsNorthIsTheNorthUnderTheAircraft) {
  Flight flight = hovering(rotation_from({70_deg, 12_deg, -20_deg}), kFortyKilometresEast);
  flight.gimbal_reference = GimbalReference::NorthEastDown;
  flight.gimbal = RotationTrack::make({{at(0), rotation_from({0_deg, -90_deg, 0_deg})},
                                       {at(1), rotation_from({0_deg, -90_deg, 0_deg})}})
                      .value();
  flight.mount.rotation = camera_rotation({});  // on the gimbal it looks along its forward axis
  flight.sea_level = sea_at(25);
  const CameraPose pose = flight.camera_pose(frame_at(0.5), kMaxGap).value();
  EXPECT_NEAR(pose.camera.latitude.degrees(), 78.9, 1e-11);
  EXPECT_NEAR(pose.camera.longitude.degrees(), 13.76, 1e-10);
  EXPECT_NEAR(pose.camera.height_ellipsoid_m, 130.0, 1e-6);
  EXPECT_NEAR(pose.sea_below.height_ellipsoid_m, 25.0, 1e-12);
  EXPECT_THAT(pose.sea_from_camera.origin(), IsNear(Point<Sea>{{0, 0, -105}}, 1e-6));
  EXPECT_LT(degrees_between(pose.sea_from_camera.rotation(), kLooksDown), 1e-7);
  // In the datum's axes it is turned by the convergence of the meridians and tilted by the Earth.
  EXPECT_GT(degrees_between(pose.world_from_camera.rotation(), kLooksDown), 1.8);
}

// The same place, worked out by hand in ECEF: the body is level in the datum's axes, the camera
// looks along the datum's down, so over the local sea it is tilted by the Earth's curvature and
// turned by the convergence.
TEST(CameraPose, FortyKilometresAwayAgreesWithEcefByHand) {
  Flight flight = hovering(Eigen::Quaterniond::Identity(), kFortyKilometresEast);
  flight.sea_level = sea_at(25);
  const CameraPose pose = flight.camera_pose(frame_at(0.5), kMaxGap).value();

  constexpr double kDegree = std::numbers::pi / 180;
  const auto ned_in_ecef = [&](double lat_deg, double lon_deg) {
    const double sp = std::sin(lat_deg * kDegree), cp = std::cos(lat_deg * kDegree);
    const double sl = std::sin(lon_deg * kDegree), cl = std::cos(lon_deg * kDegree);
    Eigen::Matrix3d rows;  // north, east, down
    rows << -sp * cl, -sp * sl, cp, -sl, cl, 0, -cp * cl, -cp * sl, -sp;
    return rows;
  };
  const Eigen::Matrix3d here_from_ecef = ned_in_ecef(78.9, 13.76),
                        datum_from_ecef = ned_in_ecef(78.9, 11.9);
  // Columns of the camera in the datum's axes: right is east, down is south, forward is down.
  Eigen::Matrix3d world_from_camera;
  world_from_camera << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d expected = here_from_ecef * datum_from_ecef.transpose() * world_from_camera;
  EXPECT_LT((pose.sea_from_camera.rotation().toRotationMatrix() - expected).cwiseAbs().maxCoeff(),
            1e-11);
  EXPECT_THAT(pose.sea_from_camera.origin(), IsNear(Point<Sea>{{0, 0, -105}}, 1e-6));
  // Where its axis meets the sea: the Earth's 0.358° of tilt, 105 m up, lie to the west.
  const auto hit = expected.col(2) * (105 / expected(2, 2));
  EXPECT_NEAR(hit.y(), 105 * std::tan(0.3584 * kDegree), 0.01);
  EXPECT_NEAR(hit.x(), 0.0, 0.02);
}

// A datum whose first axis points elsewhere describes the same flight.
TEST(CameraPose, TheDatumsAzimuthMovesNothing) {
  const Geodetic place = geodetic(79.1, 13.0, 150);
  std::vector<Rigid3<Sea, Camera>> seen;
  for (const Angle azimuth : {0_deg, 75_deg}) {
    const Datum datum(kDatum, azimuth);
    Flight flight("turned", datum, camera());
    const Rigid3<World, Body> pose(
        datum.world_from_ned_rotation(place) * rotation_from({30_deg, 5_deg, -3_deg}),
        datum.world(place));
    flight.trajectory = Trajectory::make({{at(0), pose, std::nullopt}}).value();
    flight.mount.rotation = kLooksDown;
    flight.sea_level = sea_at(40);
    seen.push_back(flight.camera_pose(frame_at(0), kMaxGap).value().sea_from_camera);
  }
  EXPECT_THAT(seen[0].origin(), IsNear(Point<Sea>{{0, 0, -110}}, 1e-5));
  EXPECT_THAT(seen[1].origin(), IsNear(seen[0].origin(), 1e-6));
  EXPECT_LT(degrees_between(seen[0].rotation(), seen[1].rotation()), 1e-9);
  EXPECT_LT(
      degrees_between(seen[0].rotation(), rotation_from({30_deg, 5_deg, -3_deg}) * kLooksDown),
      1e-7);
}

TEST(CameraPose, TheSeaIsTheOneUnderTheCamera) {
  Flight flight = hovering(heading({}), {{0, 0, -100}});
  flight.mount.lever_arm_m = {50, 0, 0};
  Geodetic asked;
  // A sea that rises to the north by a metre in 100.
  flight.sea_level =
      SeaLevel{[&](const Geodetic& place) -> Result<double> {
                 asked = place;
                 return 30 + (place.latitude - kDatum.latitude).radians() * 6.4e6 / 100;
               },
               "rises", 0.0};
  const CameraPose pose = flight.camera_pose(frame_at(0.5), kMaxGap).value();
  EXPECT_EQ(asked.latitude, pose.camera.latitude);
  EXPECT_EQ(asked.longitude, pose.camera.longitude);
  EXPECT_EQ(pose.sea_below.latitude, pose.camera.latitude);
  EXPECT_EQ(pose.sea_below.longitude, pose.camera.longitude);
  EXPECT_NEAR(pose.sea_below.height_ellipsoid_m, 30.5, 0.01);
  EXPECT_THAT(pose.sea_from_camera.origin(), IsNear(Point<Sea>{{0, 0, -99.5}}, 0.01));
}

TEST(CameraPose, FramesWithTheirOwnPoseNeedNoTrajectoryAndNoTime) {
  Flight flight("photographs", Datum(kDatum), camera());
  flight.mount.rotation = kLooksDown;
  flight.sea_level = sea_at(30);
  ImageFrame frame;
  frame.own_pose =
      StampedPose{at(77), {heading(25_deg), {{1, 2, -60}}}, PoseSigma{{1, 1, 2}, {0.1, 0.1, 0.2}}};
  const auto pose = flight.camera_pose(frame, kMaxGap);
  ASSERT_TRUE(succeeds(pose));
  EXPECT_EQ(pose->time, at(77));
  EXPECT_THAT(pose->world_from_camera.origin(), IsNear(Point<World>{{1, 2, -60}}, 1e-12));
  ASSERT_TRUE(pose->sigma);
  EXPECT_EQ(pose->sigma->position_north_east_down_m, Eigen::Vector3d(1, 1, 2));

  flight.gimbal_reference = GimbalReference::Body;
  frame.own_gimbal = rotation_from({10_deg, 0_deg, 0_deg});
  const auto turned = flight.camera_pose(frame, kMaxGap);
  ASSERT_TRUE(succeeds(turned));
  EXPECT_LT(degrees_between(turned->world_from_camera.rotation(), heading(35_deg) * kLooksDown),
            1e-7);

  // Without its own gimbal attitude the track must tell, and for that the frame needs a time.
  frame.own_gimbal.reset();
  EXPECT_TRUE(fails_with(flight.camera_pose(frame, kMaxGap), ErrorCode::OutOfRange, {"neither"}));
  frame.captured_at = at(0.5);
  EXPECT_TRUE(fails_with(flight.camera_pose(frame, kMaxGap), ErrorCode::OutOfRange,
                         {"no recorded gimbal attitude"}));
}

TEST(CameraPose, TheFramesOwnPoseWinsOverTheTrajectory) {
  Flight flight = hovering(heading({}), {{0, 0, -100}});
  ImageFrame frame = frame_at(0.5);
  frame.own_pose = StampedPose{at(0.5), {heading({}), {{7, 0, -100}}}, std::nullopt};
  EXPECT_NEAR(flight.camera_pose(frame, kMaxGap)->world_from_camera.origin().v.x(), 7.0, 1e-12);
}

TEST(CameraPose, AnOwnGimbalOfAnyLengthIsARotation) {
  Flight flight = hovering(heading({}), {{0, 0, -100}});
  flight.gimbal_reference = GimbalReference::Body;
  flight.mount.lever_arm_m = {1, 0, 0};
  ImageFrame frame = frame_at(0.5);
  frame.own_gimbal = Eigen::Quaterniond(2, 0, 0, 0);
  EXPECT_THAT(flight.camera_pose(frame, kMaxGap)->world_from_camera.origin(),
              IsNear(Point<World>{{1, 0, -100}}, 1e-9));
}

TEST(CameraPose, RefusesWhatIsNotAPose) {
  Flight flight = hovering(heading({}), {{0, 0, -100}});
  ImageFrame frame = frame_at(0.5);
  frame.own_pose = StampedPose{at(0.5), {heading({}), {{0, std::nan(""), -100}}}, std::nullopt};
  EXPECT_TRUE(
      fails_with(flight.camera_pose(frame, kMaxGap), ErrorCode::InvalidInput, {"not a number"}));
  frame.own_pose.reset();
  flight.gimbal_reference = GimbalReference::Body;
  frame.own_gimbal = Eigen::Quaterniond(0, 0, 0, 0);
  EXPECT_TRUE(fails_with(flight.camera_pose(frame, kMaxGap), ErrorCode::InvalidInput, {"zeros"}));
}

TEST(CameraPose, WithoutASeaLevelThereIsNone) {
  Flight flight = hovering(heading({}), {{0, 0, -100}});
  flight.sea_level.reset();
  EXPECT_TRUE(fails_with(flight.camera_pose(frame_at(0.5), kMaxGap), ErrorCode::NotFound,
                         {"height of the sea"}));
  flight.sea_level = SeaLevel{};
  EXPECT_TRUE(fails_with(flight.camera_pose(frame_at(0.5), kMaxGap), ErrorCode::NotFound,
                         {"height of the sea"}));
  flight.sea_level = sea_at(std::nan(""));
  EXPECT_TRUE(fails_with(flight.camera_pose(frame_at(0.5), kMaxGap), ErrorCode::NotFound,
                         {"height of the sea"}));
  flight.sea_level = SeaLevel{[](const Geodetic&) -> Result<double> {
                                return Error{ErrorCode::NotFound, "no geoid"};
                              },
                              "", 0.0};
  EXPECT_TRUE(
      fails_with(flight.camera_pose(frame_at(0.5), kMaxGap), ErrorCode::NotFound, {"no geoid"}));
}

TEST(CameraPose, OutsideTheTrajectoryTheReasonIsSaid) {
  const Flight flight = hovering(heading({}), {{0, 0, -100}});
  EXPECT_TRUE(fails_with(flight.camera_pose(frame_at(3), kMaxGap), ErrorCode::OutOfRange,
                         {"2.000 s after the last recorded pose"}));
  EXPECT_TRUE(fails_with(flight.camera_pose(frame_at(0.5), seconds(0.9)), ErrorCode::OutOfRange,
                         {"gap of 1.000 s"}));
}

TEST(CaptureTime, IsTheFramesOwnOrItsArrivalLessTheDelay) {
  Flight flight = hovering(heading({}), {});
  ImageFrame frame;
  EXPECT_TRUE(fails_with(flight.capture_time(frame), ErrorCode::OutOfRange, {"neither"}));
  frame.received_at = at(1533430844.8);
  EXPECT_TRUE(fails_with(flight.capture_time(frame), ErrorCode::OutOfRange, {"delay_s"}));
  flight.delay_s = 0.272;
  EXPECT_EQ(flight.capture_time(frame).value(),
            *frame.received_at - std::chrono::milliseconds(272));
  flight.delay_s = 0.0;  // known to be none is not unknown
  EXPECT_EQ(flight.capture_time(frame).value(), *frame.received_at);
  flight.delay_s = 0.272;
  frame.captured_at = at(1533430844.5);
  EXPECT_EQ(flight.capture_time(frame).value(), at(1533430844.5));
}

TEST(CaptureTime, RefusesADelayThatIsNone) {
  Flight flight = hovering(heading({}), {});
  ImageFrame frame;
  frame.received_at = at(9.1e9);
  for (const double delay :
       {std::nan(""), 1e300, -1e300, -9e9, std::numeric_limits<double>::infinity()}) {
    flight.delay_s = delay;
    EXPECT_TRUE(fails_with(flight.capture_time(frame), ErrorCode::OutOfRange, {"delay_s"}))
        << delay;
  }
}

TEST(CameraPose, ArrivalLessDelayPlacesTheCamera) {
  Flight flight = hovering(heading({}), {});
  flight.trajectory = Trajectory::make({{at(0), {heading({}), {{0, 0, -50}}}, std::nullopt},
                                        {at(1), {heading({}), {{20, 0, -50}}}, std::nullopt}})
                          .value();
  flight.delay_s = 0.25;
  ImageFrame frame;
  frame.received_at = at(0.75);
  EXPECT_THAT(flight.camera_pose(frame, kMaxGap)->world_from_camera.origin(),
              IsNear(Point<World>{{10, 0, -50}}, 1e-6));
}

}  // namespace
}  // namespace watersky
