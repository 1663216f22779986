// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <random>

#include "watersky/geo/rigid3.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky {
namespace {

static_assert(CanChain<Rigid3<World, Body>, Rigid3<Body, Camera>>);
static_assert(!CanChain<Rigid3<World, Body>, Rigid3<World, Camera>>);
static_assert(CanChain<Rigid3<World, Body>, Point<Body>>);
static_assert(!CanChain<Rigid3<World, Body>, Point<World>>);
static_assert(std::is_default_constructible_v<Rigid3<World, World>>);
static_assert(!std::is_default_constructible_v<Rigid3<World, Body>>);

class RandomRotations : public ::testing::Test {
 protected:
  Eigen::Vector3d unit() {
    return Eigen::Vector3d(normal_(rng_), normal_(rng_), normal_(rng_)).normalized();
  }
  Eigen::Quaterniond rotation() {
    return Eigen::Quaterniond(normal_(rng_), normal_(rng_), normal_(rng_), normal_(rng_))
        .normalized();
  }
  Eigen::Vector3d position() { return 1000.0 * Eigen::Vector3d(unit()); }
  std::mt19937 rng_{7};
  std::normal_distribution<double> normal_;
};

TEST_F(RandomRotations, InverseUndoesAndChainsAssociate) {
  for (int i = 0; i < 1000; ++i) {
    const Rigid3<World, Body> world_from_body(rotation(), {position()});
    const Rigid3<Body, Gimbal> body_from_gimbal(rotation(), {position()});
    const Rigid3<Gimbal, Camera> gimbal_from_camera(rotation(), {position()});
    const Point<Camera> p{position()};
    const Point<World> w = (world_from_body * body_from_gimbal) * gimbal_from_camera * p;
    EXPECT_LT((w - (world_from_body * (body_from_gimbal * (gimbal_from_camera * p)))).v.norm(),
              1e-9);
    EXPECT_LT((world_from_body.inverse() * (world_from_body * Point<Body>{p.v}) - Point<Body>{p.v})
                  .v.norm(),
              1e-9);
    const Eigen::Vector4d h = world_from_body.matrix() * p.v.homogeneous();
    EXPECT_LT((h.head<3>() - (world_from_body * Point<Body>{p.v}).v).norm(), 1e-9);
  }
}

TEST_F(RandomRotations, AngleAxisMatrixAndQuaternionAgree) {
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d axis = unit(), v = position();
    const Angle angle = Angle::degrees(10.0 * normal_(rng_) * 18.0);
    const Eigen::Vector3d by_matrix = rotation_matrix(angle, axis) * v;
    EXPECT_LT((by_matrix - quaternion(angle, axis) * v).norm(), 1e-9);
    EXPECT_LT((skew(axis) * v - axis.cross(v)).norm(), 1e-12);
  }
}

TEST_F(RandomRotations, YawPitchRollComesBackAlsoStraightDown) {
  std::uniform_real_distribution<double> turn(-180, 180);
  for (int i = 0; i < 2000; ++i) {
    const double pitch = i % 4 == 0 ? -90.0 : i % 4 == 1 ? 90.0 : turn(rng_) / 2;
    const Eigen::Quaterniond q = rotation_from(
        {Angle::degrees(turn(rng_)), Angle::degrees(pitch), Angle::degrees(turn(rng_))});
    EXPECT_LT(angle_between(q, rotation_from(yaw_pitch_roll(q))).degrees(), 1e-6);
  }
}

// A gimbal that looks down is within a hundredth of a degree of the singularity, never on it.
TEST_F(RandomRotations, YawPitchRollComesBackNextToStraightDown) {
  std::uniform_real_distribution<double> turn(-180, 180), digits(-12, -2);
  for (int i = 0; i < 2000; ++i) {
    const double pitch = -90.0 + std::pow(10.0, digits(rng_));
    const Eigen::Quaterniond q = rotation_from(
        {Angle::degrees(turn(rng_)), Angle::degrees(pitch), Angle::degrees(turn(rng_))});
    EXPECT_LT(angle_between(q, rotation_from(yaw_pitch_roll(q))).radians(), 2e-9) << pitch;
  }
}

TEST(YawPitchRoll, ReadsTheAnglesItWasMadeOf) {
  const YawPitchRoll angles = yaw_pitch_roll(rotation_from({40_deg, 10_deg, 8_deg}));
  EXPECT_NEAR(angles.yaw.degrees(), 40.0, 1e-12);
  EXPECT_NEAR(angles.pitch.degrees(), 10.0, 1e-12);
  EXPECT_NEAR(angles.roll.degrees(), 8.0, 1e-12);
}

TEST(Rigid3, NoseEastPutsAForwardCameraEastOfTheDrone) {
  const Rigid3<World, Body> world_from_body(heading(90_deg), {{100.0, 0.0, -80.0}});
  const Rigid3<Body, Camera> body_from_camera(camera_rotation({0_deg, -90_deg, 0_deg}),
                                              {{0.5, 0.0, 0.0}});
  const Point<World> p = (world_from_body * body_from_camera).origin();
  EXPECT_NEAR(p.v.x(), 100.0, 1e-12);
  EXPECT_NEAR(p.v.y(), 0.5, 1e-12);
  EXPECT_NEAR(p.v.z(), -80.0, 1e-12);
}

TEST(CameraRotation, PitchMinus90LooksDownWithTheImageTopForward) {
  const Eigen::Quaterniond q = camera_rotation({0_deg, -90_deg, 0_deg});
  EXPECT_TRUE((q * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d(0, 0, 1), 1e-12));
  EXPECT_TRUE((q * -Eigen::Vector3d::UnitY()).isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
  EXPECT_TRUE((q * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(0, 1, 0), 1e-12));
}

TEST(CameraRotation, YawMinus90WithItPutsTheImageTopToTheLeft) {
  const Eigen::Quaterniond q = camera_rotation({-90_deg, -90_deg, 0_deg});
  EXPECT_TRUE((q * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d(0, 0, 1), 1e-12));
  EXPECT_TRUE((q * -Eigen::Vector3d::UnitY()).isApprox(Eigen::Vector3d(0, -1, 0), 1e-12));
}

TEST(CameraRotation, ZeroLooksForwardWithTheImageTopUp) {
  const Eigen::Quaterniond q = camera_rotation({});
  EXPECT_TRUE((q * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
  EXPECT_TRUE((q * -Eigen::Vector3d::UnitY()).isApprox(Eigen::Vector3d(0, 0, -1), 1e-12));
}

// (3.1), (3.2): the motion capture's z-up frames against north-east-down are diag(1, -1, -1).
TEST(Quaternion, HalfTurnAboutXIsDiagOneMinusOneMinusOne) {
  const Eigen::Matrix3d r = quaternion(180_deg, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_TRUE(r.isApprox(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), 1e-12));
}

}  // namespace
}  // namespace watersky
