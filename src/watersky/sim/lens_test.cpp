// SPDX-License-Identifier: MIT
#include "watersky/sim/lens.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {
namespace {

cv::Mat camera_matrix(const LensParameters& p) {
  const Lens lens(p);
  return (cv::Mat_<double>(3, 3) << p.focal_px, 0, lens.u0(), 0, p.focal_px, lens.v0(), 0, 0, 1);
}

cv::Point2d by_opencv(const LensParameters& p, const Eigen::Vector3d& point) {
  const std::vector<cv::Point3d> points{{point.x(), point.y(), point.z()}};
  const cv::Vec3d none(0, 0, 0);
  std::vector<cv::Point2d> pixels;
  if (p.fisheye) {
    cv::fisheye::projectPoints(points, pixels, none, none, camera_matrix(p),
                               cv::Vec4d(p.k1, p.k2, p.k3, p.k4));
  } else {
    const std::vector<double> distortion{p.k1, p.k2, p.p1, p.p2, p.k3, p.k4, p.k5, p.k6};
    cv::projectPoints(points, none, none, camera_matrix(p), distortion, pixels);
  }
  return pixels[0];
}

LensParameters random_lens(Random& random, int kind) {
  LensParameters p;
  p.width_px = 640;
  p.height_px = 480;
  p.focal_px = random.uniform(300.0, 900.0);
  p.centre_right_px = random.uniform(-20.0, 20.0);
  p.centre_down_px = random.uniform(-20.0, 20.0);
  p.fisheye = kind == 2;
  p.k1 = random.uniform(-0.25, 0.1);
  p.k2 = random.uniform(-0.02, 0.06);
  p.k3 = random.uniform(-0.01, 0.01);
  if (kind == 2) {
    p.k4 = random.uniform(-0.002, 0.002);
    p.k1 *= 0.2;
  } else {
    p.p1 = random.uniform(-1e-3, 1e-3);
    p.p2 = random.uniform(-1e-3, 1e-3);
  }
  if (kind == 1) {
    p.k4 = random.uniform(-0.05, 0.2);
    p.k5 = random.uniform(-0.02, 0.05);
    p.k6 = random.uniform(-0.005, 0.01);
  }
  return p;
}

class EveryLens : public ::testing::TestWithParam<int> {};

TEST_P(EveryLens, ProjectsAsOpenCvDoes) {
  Random random(11);
  for (int trial = 0; trial < 40; ++trial) {
    const LensParameters p = random_lens(random, GetParam());
    const Lens lens(p);
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d point(random.uniform(-0.5, 0.5) * 20.0,
                                  random.uniform(-0.4, 0.4) * 20.0, random.uniform(12.0, 40.0));
      const auto pixel = lens.pixel(point);
      ASSERT_TRUE(pixel);
      const cv::Point2d expected = by_opencv(p, point);
      EXPECT_NEAR(pixel->x(), expected.x, 1e-6);
      EXPECT_NEAR(pixel->y(), expected.y, 1e-6);
    }
  }
}

TEST_P(EveryLens, SeesThroughAPixelWhatOpenCvProjectsOntoIt) {
  Random random(12);
  int seen = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const LensParameters p = random_lens(random, GetParam());
    const Lens lens(p);
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d pixel(random.uniform(-0.5, 639.5), random.uniform(-0.5, 479.5));
      const auto direction = lens.direction(pixel);
      if (!direction) continue;  // beyond the fold of this lens
      ++seen;
      EXPECT_NEAR(direction->norm(), 1.0, 1e-12);
      if (direction->z() < 0.05) continue;  // OpenCV's fisheye takes tan, not the angle
      const cv::Point2d back = by_opencv(p, *direction);
      EXPECT_NEAR(back.x, pixel.x(), 1e-6);
      EXPECT_NEAR(back.y, pixel.y(), 1e-6);
    }
  }
  EXPECT_GT(seen, 1900);
}

INSTANTIATE_TEST_SUITE_P(PinholeOfFivePinholeOfEightFisheye, EveryLens, ::testing::Values(0, 1, 2));

// By hand: x = 0.2, y = 0.1, r² = 0.05, 1 + k1 r² = 0.99: u = 319.5 + 500 · 0.198.
TEST(Lens, ShowsAPointWhereAHandCalculationPutsIt) {
  LensParameters p;
  p.width_px = 640;
  p.height_px = 480;
  p.focal_px = 500.0;
  p.k1 = -0.2;
  const auto pixel = Lens(p).pixel({2.0, 1.0, 10.0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 319.5 + 99.0, 1e-12);
  EXPECT_NEAR(pixel->y(), 239.5 + 49.5, 1e-12);
}

// k1 = -0.3 folds where 1 - 0.9 r² = 0, at r = 1.0541: what lies further out must not show.
TEST(Lens, ShowsNoGhostsBeyondTheFold) {
  LensParameters p;
  p.focal_px = 100.0;
  p.k1 = -0.3;
  const Lens lens(p);
  EXPECT_TRUE(lens.pixel({1.04, 0.0, 1.0}));
  EXPECT_FALSE(lens.pixel({1.07, 0.0, 1.0}));
  EXPECT_FALSE(lens.pixel({0.1, 0.0, -1.0}));
  // The image's radius at the fold is 100 · 1.0541 · (1 - 0.3333) = 70.27 px.
  EXPECT_TRUE(lens.direction({lens.u0() + 69.9, lens.v0()}));
  EXPECT_FALSE(lens.direction({lens.u0() + 70.6, lens.v0()}));
}

TEST(Lens, FisheyeSeesBehindItself) {
  LensParameters p;
  p.fisheye = true;
  p.focal_px = 100.0;
  const Lens lens(p);
  const auto pixel = lens.pixel({std::sin(2.0), 0.0, std::cos(2.0)});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x() - lens.u0(), 200.0, 1e-9);
  EXPECT_NEAR(lens.direction(*pixel)->z(), std::cos(2.0), 1e-12);
}

}  // namespace
}  // namespace watersky::sim
