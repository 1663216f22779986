// SPDX-License-Identifier: MIT
#include "watersky/registration/homography.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace watersky {
namespace {

const cv::Size kSize(640, 480);

Eigen::Matrix3d random_homography(std::mt19937& random) {
  std::uniform_real_distribution<> u(-1, 1);
  const double angle = 0.3 * u(random), zoom = 1 + 0.1 * u(random);
  Eigen::Matrix3d h;
  h << zoom * std::cos(angle), -zoom * std::sin(angle), 40 * u(random), zoom * std::sin(angle),
      zoom * std::cos(angle), 40 * u(random), 5e-5 * u(random), 5e-5 * u(random), 1;
  return h;
}

std::vector<PointPair> pairs_under(const Eigen::Matrix3d& h, int n, double noise_px,
                                   std::mt19937& random) {
  std::uniform_real_distribution<> x(0, kSize.width), y(0, kSize.height);
  std::normal_distribution<> noise(0, 1);
  std::vector<PointPair> pairs;
  for (int i = 0; i < n; ++i) {
    const cv::Point2d a(x(random), y(random));
    pairs.push_back({a, apply(h, a) + noise_px * cv::Point2d(noise(random), noise(random))});
  }
  return pairs;
}

TEST(FitHomography, FindsTheOneThatExactPairsObey) {
  std::mt19937 random(1);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Matrix3d truth = random_homography(random);
    const auto fit =
        fit_homography(pairs_under(truth, 12, 0.0, random), Eigen::Matrix3d::Identity(), kSize);
    ASSERT_TRUE(fit);
    EXPECT_LT(corner_error_px(fit->b_from_a, truth, kSize), 1e-6);
  }
}

TEST(FitHomography, ItsCovarianceIsTheScatterOverManyNoises) {
  std::mt19937 random(2);
  for (const int n : {10, 40, 200}) {
    const Eigen::Matrix3d truth = random_homography(random);
    Eigen::Matrix<double, 8, 1> mean_square = Eigen::Matrix<double, 8, 1>::Zero(),
                                predicted = mean_square, of_h = mean_square,
                                predicted_h = mean_square;
    constexpr int kRuns = 400;
    for (int k = 0; k < kRuns; ++k) {
      const auto fit = fit_homography(pairs_under(truth, n, 0.5, random), truth, kSize);
      ASSERT_TRUE(fit);
      for (int c = 0; c < 4; ++c) {
        const cv::Point2d at = corners_of(kSize)[static_cast<std::size_t>(c)];
        const cv::Point2d error = apply(fit->b_from_a, at) - apply(truth, at);
        mean_square(2 * c) += error.x * error.x / kRuns;
        mean_square(2 * c + 1) += error.y * error.y / kRuns;
      }
      predicted += fit->corner_covariance.diagonal() / kRuns;
      predicted_h += fit->covariance.diagonal() / kRuns;
      for (int i = 0; i < 8; ++i)
        of_h(i) += std::pow(fit->b_from_a(i / 3, i % 3) - truth(i / 3, i % 3), 2) / kRuns;
    }
    for (int i = 0; i < 8; ++i) {
      const double ratio = std::sqrt(predicted(i) / mean_square(i));
      EXPECT_GT(ratio, 0.7) << n << " pairs, element " << i;
      EXPECT_LT(ratio, 1.9) << n << " pairs, element " << i;
      const double ratio_h = std::sqrt(predicted_h(i) / of_h(i));
      EXPECT_GT(ratio_h, 0.7) << n << " pairs, element " << i;
      EXPECT_LT(ratio_h, 1.9) << n << " pairs, element " << i;
    }
  }
}

TEST(FitHomography, HeedsWhichPairsAreKnownWell) {
  std::mt19937 random(3);
  double plain = 0, weighted = 0;
  for (int k = 0; k < 100; ++k) {
    const Eigen::Matrix3d truth = random_homography(random);
    auto pairs = pairs_under(truth, 30, 0.1, random);
    auto bad = pairs_under(truth, 30, 3.0, random);
    pairs.insert(pairs.end(), bad.begin(), bad.end());
    plain += corner_error_px(fit_homography(pairs, truth, kSize)->b_from_a, truth, kSize);
    for (std::size_t i = 30; i < 60; ++i) pairs[i].covariance *= 900.0;
    weighted += corner_error_px(fit_homography(pairs, truth, kSize)->b_from_a, truth, kSize);
  }
  EXPECT_LT(weighted, 0.2 * plain);
}

TEST(FitHomography, PairsOnALineOrTooFewOrAtOnePlaceDetermineNothing) {
  std::mt19937 random(4);
  std::vector<PointPair> line, one;
  for (int i = 0; i < 30; ++i)
    line.push_back({cv::Point2d(10.0 * i, 5.0 * i), cv::Point2d(10.0 * i, 5.0 * i)});
  for (int i = 0; i < 30; ++i) one.push_back({cv::Point2d(7, 7), cv::Point2d(9, 9)});
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  EXPECT_FALSE(fit_homography(line, identity, kSize));
  EXPECT_FALSE(fit_homography(one, identity, kSize));
  EXPECT_FALSE(fit_homography(pairs_under(identity, 4, 0, random), identity, kSize));
  EXPECT_FALSE(fit_homography({}, identity, kSize));
}

TEST(Plausible, MirrorsFoldsAndExtremeZoomsAreNoViewsDown) {
  Eigen::Matrix3d h = Eigen::Matrix3d::Identity();
  EXPECT_TRUE(is_plausible(h, kSize));
  h(0, 0) = -1;
  EXPECT_FALSE(is_plausible(h, kSize));
  h = Eigen::Vector3d(3, 3, 1).asDiagonal();
  EXPECT_FALSE(is_plausible(h, kSize));
  EXPECT_TRUE(is_plausible(h, kSize, 3.0));
  h = Eigen::Vector3d(2.5, 1, 1).asDiagonal();
  EXPECT_FALSE(is_plausible(h, kSize));
  h = Eigen::Matrix3d::Identity();
  h(2, 0) = -1.0 / 300;  // the horizon runs through the picture
  EXPECT_FALSE(is_plausible(h, kSize));
  h.setConstant(std::nan(""));
  EXPECT_FALSE(is_plausible(h, kSize));
}

}  // namespace
}  // namespace watersky
