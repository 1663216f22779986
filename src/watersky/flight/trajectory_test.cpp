// SPDX-License-Identifier: MIT
#include "watersky/flight/trajectory.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/matchers.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky {
namespace {

using test::fails_with;
using test::IsNear;
using test::succeeds;

constexpr Duration kAnyGap = Duration::max();

Time at(double s) { return time_from_seconds(s).value(); }

StampedPose level(double time_s, const Point<World>& position = {}, Angle yaw = {}) {
  return {at(time_s), {heading(yaw), position}, std::nullopt};
}

class RandomTrajectories : public ::testing::Test {
 protected:
  double normal() { return std::normal_distribution<double>()(rng_); }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  StampedPose random_pose(double time_s) {
    return {at(time_s),
            {Eigen::Quaterniond(normal(), normal(), normal(), normal()),
             Point<World>{{100 * normal(), 100 * normal(), 100 * normal()}}},
            std::nullopt};
  }
  std::vector<StampedPose> random_poses(int count) {
    std::vector<StampedPose> poses;
    double t = 1.5e9;
    for (int i = 0; i < count; ++i) poses.push_back(random_pose(t += uniform(0.01, 2)));
    return poses;
  }
  std::mt19937 rng_{6};
};

TEST_F(RandomTrajectories, IsExactAtItsPoses) {
  const auto poses = random_poses(100);
  const auto trajectory = Trajectory::make(poses).value();
  for (const auto& pose : poses) {
    const auto there = trajectory.at(pose.time, Duration(0));  // no gap is bridged
    ASSERT_TRUE(succeeds(there));
    EXPECT_EQ(there->time, pose.time);
    EXPECT_EQ(there->world_from_body.origin().v, pose.world_from_body.origin().v);
    EXPECT_EQ(there->world_from_body.rotation().coeffs(), pose.world_from_body.rotation().coeffs());
  }
}

TEST_F(RandomTrajectories, GoesStraightAndTurnsEvenlyAboutOneAxis) {
  for (int i = 0; i < 300; ++i) {
    const StampedPose a = random_pose(10), b = random_pose(14);
    const auto trajectory = Trajectory::make({a, b}).value();
    const double f = uniform(0.001, 0.999);
    const auto p = trajectory.at(at(10 + 4 * f), kAnyGap).value();
    EXPECT_EQ(p.time, at(10 + 4 * f));
    const Eigen::Vector3d expected =
        (1 - f) * a.world_from_body.origin().v + f * b.world_from_body.origin().v;
    EXPECT_THAT(p.world_from_body.origin(), IsNear(Point<World>{expected}, 1e-6));
    // The same axis and the fraction of the angle, the short way round.
    const auto &qa = a.world_from_body.rotation(), &qb = b.world_from_body.rotation();
    const double whole = angle_between(qa, qb).radians();
    EXPECT_LE(whole, std::numbers::pi);
    EXPECT_NEAR(angle_between(qa, p.world_from_body.rotation()).radians(), f * whole, 1e-8);
    EXPECT_NEAR(angle_between(p.world_from_body.rotation(), qb).radians(), (1 - f) * whole, 1e-8);
    EXPECT_NEAR(p.world_from_body.rotation().norm(), 1.0, 1e-12);
  }
}

TEST(Trajectory, TurnsTheShortWayThroughNorth) {
  const auto trajectory =
      Trajectory::make({level(0, {{0, 0, 0}}, 350_deg), level(2, {{4, 0, -8}}, 30_deg)}).value();
  const auto middle = trajectory.at(at(1), kAnyGap).value();
  EXPECT_NEAR(yaw_pitch_roll(middle.world_from_body.rotation()).yaw.degrees(), 10.0, 1e-9);
  EXPECT_THAT(middle.world_from_body.origin(), IsNear(Point<World>{{2, 0, -4}}, 1e-12));
}

TEST(Trajectory, AQuaternionAndItsNegativeAreOneAttitude) {
  const Eigen::Quaterniond q = heading(40_deg);
  const Eigen::Quaterniond minus_q(-q.w(), -q.x(), -q.y(), -q.z());
  const auto trajectory =
      Trajectory::make({{at(0), {q, {}}, std::nullopt}, {at(1), {minus_q, {}}, std::nullopt}})
          .value();
  for (const double t : {0.0, 0.1, 0.5, 0.9, 1.0})
    EXPECT_LT(angle_between(trajectory.at(at(t), kAnyGap)->world_from_body.rotation(), q).radians(),
              1e-9);
}

TEST(Trajectory, PicksTheBracketingPair) {
  const auto trajectory = Trajectory::make({level(0, {{0, 0, 0}}), level(1, {{10, 0, 0}}),
                                            level(3, {{10, 20, 0}}), level(4, {{0, 20, 0}})})
                              .value();
  const auto position = [&](double t) {
    return trajectory.at(at(t), kAnyGap)->world_from_body.origin();
  };
  EXPECT_THAT(position(0.25), IsNear(Point<World>{{2.5, 0, 0}}, 1e-9));
  EXPECT_THAT(position(1.5), IsNear(Point<World>{{10, 5, 0}}, 1e-9));
  EXPECT_THAT(position(3.9), IsNear(Point<World>{{1, 20, 0}}, 1e-9));
}

TEST(Trajectory, NeverExtrapolates) {
  const auto trajectory = Trajectory::make({level(10), level(11, {{1, 0, 0}})}).value();
  EXPECT_TRUE(succeeds(trajectory.at(at(10), kAnyGap)));
  EXPECT_TRUE(succeeds(trajectory.at(at(11), kAnyGap)));
  EXPECT_TRUE(fails_with(trajectory.at(at(10) - Duration(1), kAnyGap), ErrorCode::OutOfRange,
                         {"before the first"}));
  EXPECT_TRUE(fails_with(trajectory.at(at(11) + Duration(1), kAnyGap), ErrorCode::OutOfRange,
                         {"after the last"}));
  EXPECT_TRUE(fails_with(trajectory.at(at(7.5), kAnyGap), ErrorCode::OutOfRange,
                         {"2.500 s before the first recorded pose"}));
  EXPECT_TRUE(fails_with(trajectory.at(at(12.25), kAnyGap), ErrorCode::OutOfRange,
                         {"1.250 s after the last recorded pose"}));
  EXPECT_TRUE(
      fails_with(Trajectory{}.at(at(0), kAnyGap), ErrorCode::OutOfRange, {"no recorded pose"}));
  const auto alone = Trajectory::make({level(10)}).value();
  EXPECT_TRUE(succeeds(alone.at(at(10), kAnyGap)));
  EXPECT_FALSE(alone.at(at(10.001), kAnyGap).ok());
  EXPECT_FALSE(alone.at(at(9.999), kAnyGap).ok());
}

TEST(Trajectory, BridgesNoGapLongerThanAllowed) {
  const auto trajectory = Trajectory::make({level(0), level(0.5), level(2)}).value();
  const Duration half = seconds(0.5);
  EXPECT_TRUE(succeeds(trajectory.at(at(0.25), half)));  // exactly as long is allowed
  EXPECT_FALSE(trajectory.at(at(0.25), half - Duration(1)).ok());
  EXPECT_TRUE(fails_with(trajectory.at(at(0.75), half), ErrorCode::OutOfRange,
                         {"gap of 1.500 s", "0.500 s"}));
  EXPECT_TRUE(succeeds(trajectory.at(at(0.5), half)));  // on a pose beside the gap
  EXPECT_TRUE(succeeds(trajectory.at(at(2), half)));
}

// A difference that does not fit 64 bits of nanoseconds is a long gap, not a negative one.
TEST(Trajectory, CenturiesApartIsAGapToo) {
  const auto trajectory = Trajectory::make({level(-9.1e9), level(9.1e9)}).value();
  EXPECT_TRUE(fails_with(trajectory.at(at(0), seconds(0.5)), ErrorCode::OutOfRange, {"gap"}));
  EXPECT_TRUE(fails_with(Trajectory::make({level(9.1e9), level(-9.1e9)}), ErrorCode::InvalidInput,
                         {"pose 2", "earlier"}));
  const auto late = Trajectory::make({level(9.1e9)}).value();
  EXPECT_TRUE(fails_with(late.at(at(-9.1e9), seconds(0.5)), ErrorCode::OutOfRange, {"before"}));
}

TEST(Trajectory, RefusesUnsortedAndDuplicateTimesNamingTheFirst) {
  const auto code = ErrorCode::InvalidInput;
  EXPECT_TRUE(fails_with(Trajectory::make({level(0), level(2), level(1), level(1)}), code,
                         {"pose 3", "1.000 s earlier"}));
  EXPECT_TRUE(
      fails_with(Trajectory::make({level(0), level(1), level(1)}), code, {"pose 3", "same time"}));
  EXPECT_TRUE(succeeds(Trajectory::make({})));
}

TEST(Trajectory, RefusesPosesThatAreNoneNamingTheFirst) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const auto code = ErrorCode::InvalidInput;
  EXPECT_TRUE(fails_with(Trajectory::make({level(0), level(1, {{0, nan, 0}})}), code,
                         {"pose 2", "not a number"}));
  EXPECT_TRUE(
      fails_with(Trajectory::make({level(0, {{inf, 0, 0}})}), code, {"pose 1", "not a number"}));
  EXPECT_TRUE(fails_with(Trajectory::make({level(0, {}, Angle::radians(nan))}), code,
                         {"pose 1", "not a number"}));
  const StampedPose zeros{at(5), {Eigen::Quaterniond(0, 0, 0, 0), {}}, std::nullopt};
  EXPECT_TRUE(fails_with(Trajectory::make({level(0), zeros}), code, {"pose 2", "zeros"}));
}

TEST(Trajectory, SigmaIsTheLargerOfTheTwoNeighbours) {
  StampedPose a = level(0), b = level(1), c = level(2);
  a.sigma = PoseSigma{{1, 5, 2}, {0.1, 0.2, 0.3}};
  b.sigma = PoseSigma{{3, 4, 2}, {0.3, 0.1, 0.3}};
  const auto trajectory = Trajectory::make({a, b, c}).value();
  const auto between = trajectory.at(at(0.1), kAnyGap)->sigma;
  ASSERT_TRUE(between);
  EXPECT_EQ(between->position_north_east_down_m, Eigen::Vector3d(3, 5, 2));
  EXPECT_EQ(between->roll_pitch_yaw_rad, Eigen::Vector3d(0.3, 0.2, 0.3));
  EXPECT_EQ(trajectory.at(at(0), kAnyGap)->sigma->position_north_east_down_m,
            Eigen::Vector3d(1, 5, 2));
  EXPECT_FALSE(trajectory.at(at(1.5), kAnyGap)->sigma);  // one neighbour's is not known
}

TEST(RotationTrack, KeepsTheSameRules) {
  const auto track =
      RotationTrack::make({{at(0), heading(350_deg)}, {at(2), heading(30_deg)}}).value();
  EXPECT_NEAR(yaw_pitch_roll(track.at(at(0.5), kAnyGap).value()).yaw.degrees(), 0.0, 1e-9);
  EXPECT_NEAR(yaw_pitch_roll(track.at(at(2), Duration(0)).value()).yaw.degrees(), 30.0, 1e-9);
  EXPECT_TRUE(fails_with(track.at(at(-1), kAnyGap), ErrorCode::OutOfRange,
                         {"1.000 s before", "gimbal attitude"}));
  EXPECT_TRUE(fails_with(track.at(at(3), kAnyGap), ErrorCode::OutOfRange,
                         {"1.000 s after", "gimbal attitude"}));
  EXPECT_TRUE(fails_with(track.at(at(1), seconds(1)), ErrorCode::OutOfRange, {"gap of 2.000 s"}));
  EXPECT_TRUE(fails_with(RotationTrack{}.at(at(0), kAnyGap), ErrorCode::OutOfRange,
                         {"no recorded gimbal attitude"}));
  const auto code = ErrorCode::InvalidInput;
  const Eigen::Quaterniond nan(std::nan(""), 0, 0, 0), zeros(0, 0, 0, 0);
  EXPECT_TRUE(fails_with(RotationTrack::make({{at(0), heading({})}, {at(0), heading({})}}), code,
                         {"attitude 2", "same time"}));
  EXPECT_TRUE(fails_with(RotationTrack::make({{at(1), heading({})}, {at(0), heading({})}}), code,
                         {"attitude 2", "earlier"}));
  EXPECT_TRUE(
      fails_with(RotationTrack::make({{at(0), nan}}), code, {"attitude 1", "not a number"}));
  EXPECT_TRUE(fails_with(RotationTrack::make({{at(0), heading({})}, {at(1), zeros}}), code,
                         {"attitude 2", "zeros"}));
}

TEST(RotationTrack, MakesUnitQuaternions) {
  const Eigen::Quaterniond q = heading(40_deg), tripled(3 * q.w(), 3 * q.x(), 3 * q.y(), 3 * q.z());
  const auto track = RotationTrack::make({{at(0), tripled}, {at(1), heading(60_deg)}}).value();
  EXPECT_NEAR(track.at(at(0), kAnyGap)->norm(), 1.0, 1e-12);
  EXPECT_NEAR(yaw_pitch_roll(track.at(at(0.5), kAnyGap).value()).yaw.degrees(), 50.0, 1e-9);
}

}  // namespace
}  // namespace watersky
