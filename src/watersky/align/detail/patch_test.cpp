// SPDX-License-Identifier: MIT
#include "watersky/align/detail/patch.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

namespace watersky::align {
namespace {

/// Smooth blobs whose value at any real place is known.
double field(double u, double v) {
  return 40 * std::sin(0.31 * u + 0.4) * std::cos(0.23 * v) + 25 * std::sin(0.17 * (u + 1.7 * v)) +
         20 * std::cos(0.41 * u - 0.29 * v);
}

cv::Mat picture(const Eigen::Matrix2d& host_from_picture, const Eigen::Vector2d& shift, double gain,
                double offset) {
  cv::Mat made(120, 160, CV_32F);
  for (int v = 0; v < made.rows; ++v)
    for (int u = 0; u < made.cols; ++u) {
      const Eigen::Vector2d p = host_from_picture * (Eigen::Vector2d(u, v) - shift);
      made.at<float>(v, u) = static_cast<float>(gain * field(p.x(), p.y()) + offset);
    }
  return made;
}

TEST(Patch, IsFoundUnderShiftTurnGainAndOffset) {
  const cv::Mat host = picture(Eigen::Matrix2d::Identity(), {0, 0}, 1, 0);
  for (const double angle : {0.0, 0.3, -0.5}) {
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
    const Eigen::Vector2d shift(11.3, 6.8), at(60, 50);
    const cv::Mat other = picture(turn.transpose(), shift, 0.6, 17.0);
    const auto patch = Patch::cut(host, at, 0.1);
    ASSERT_TRUE(patch);
    const Eigen::Vector2d truth = turn * at + shift;
    const auto found = patch->find(other, truth + Eigen::Vector2d(1.2, -0.9), turn, 3.0);
    ASSERT_TRUE(found) << angle;
    EXPECT_LT((found->at - truth).norm(), 0.05) << angle;
    EXPECT_GT(found->correlation, 0.99);
  }
}

TEST(Patch, ItsCovarianceIsHonest) {
  const cv::Mat clean = picture(Eigen::Matrix2d::Identity(), {0, 0}, 1, 0);
  const Eigen::Vector2d at(70, 60);
  const auto patch = Patch::cut(clean, at, 0.1);
  ASSERT_TRUE(patch);
  cv::RNG random(5);
  double sum = 0.0;
  constexpr int kTrials = 200;
  for (int i = 0; i < kTrials; ++i) {
    cv::Mat noise(clean.size(), CV_32F);
    random.fill(noise, cv::RNG::NORMAL, 0, 4.0);
    const auto found = patch->find(clean + noise, at, Eigen::Matrix2d::Identity(), 3.0);
    ASSERT_TRUE(found);
    const Eigen::Vector2d off = found->at - at;
    sum += off.dot((16.0 * patch->unit_covariance()).inverse() * off) / 2;
  }
  EXPECT_NEAR(sum / kTrials, 1.0, 0.35);
}

TEST(Patch, RefusesNoiseAndEvenSurfaces) {
  cv::Mat noise(60, 60, CV_32F);
  cv::RNG(7).fill(noise, cv::RNG::NORMAL, 0, 5.0);
  const double sigma = pixel_noise(noise);
  EXPECT_NEAR(sigma, 5.0, 0.5);
  cv::GaussianBlur(noise, noise, {}, 1.5);
  EXPECT_FALSE(Patch::cut(noise, {30, 30}, 0.7 * sigma));
  EXPECT_FALSE(Patch::cut(cv::Mat(60, 60, CV_32F, cv::Scalar(3)), {30, 30}, 0.0));
}

TEST(Patch, LeavesThePictureNowhere) {
  const cv::Mat host = picture(Eigen::Matrix2d::Identity(), {0, 0}, 1, 0);
  EXPECT_FALSE(Patch::cut(host, {4, 50}, 0.1));
  const auto patch = Patch::cut(host, {60, 50}, 0.1);
  ASSERT_TRUE(patch);
  for (const Eigen::Vector2d& start : {Eigen::Vector2d(3, 50), Eigen::Vector2d(158, 118)})
    EXPECT_FALSE(patch->find(host, start, Eigen::Matrix2d::Identity(), 3.0));
}

}  // namespace
}  // namespace watersky::align
