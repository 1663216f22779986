// SPDX-License-Identifier: MIT
#include "watersky/field/marginals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <random>

#include "support/small_fields.hpp"

namespace watersky::field {
namespace {

cv::Mat p_ice(const cv::Mat& log_odds, double coupling, int iterations = 1000) {
  const auto found = marginals(log_odds, coupling, iterations, 1e-6);
  EXPECT_TRUE(found) << (found ? "" : found.error().message);
  return found ? found->probability : cv::Mat();
}

double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  double most = 0.0;
  for (int r = 0; r < a.rows; ++r)
    for (int c = 0; c < a.cols; ++c) {
      const float x = a.at<float>(r, c), y = b.at<float>(r, c);
      EXPECT_EQ(std::isnan(x), std::isnan(y));
      if (!std::isnan(x)) most = std::max(most, static_cast<double>(std::abs(x - y)));
    }
  return most;
}

/// Mean and largest error on random fields of 4 x 4 cells.
std::pair<double, double> errors(double scale, double coupling, int trials) {
  std::mt19937 random(7);
  double sum = 0.0, most = 0.0;
  for (int trial = 0; trial < trials; ++trial) {
    const cv::Mat l = test::random_field(4, 4, scale, 0.0, random);
    const std::vector<double> exact = test::enumerate(l, coupling).p_ice;
    const cv::Mat p = p_ice(l, coupling);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double error = std::abs(
          static_cast<double>(p.at<float>(static_cast<int>(i) / 4, static_cast<int>(i) % 4)) -
          exact[i]);
      sum += error / (16.0 * trials);
      most = std::max(most, error);
    }
  }
  return {sum, most};
}

TEST(Marginals, AreNearTheExactOnesOf4x4CellsWhereTheCouplingIsWeak) {
  const auto [mean, most] = errors(1.0, 0.2, 20);
  EXPECT_LT(mean, 0.005);
  EXPECT_LT(most, 0.02);
  // And farther off where it is strong, which is why the documents do not say "exact".
  EXPECT_LT(errors(2.0, 0.6, 10).first, 0.1);
}

TEST(Marginals, AreExactWithoutLoops) {
  std::mt19937 random(8);
  const cv::Mat l = test::random_field(1, 14, 1.5, 0.0, random);
  const std::vector<double> exact = test::enumerate(l, 1.3).p_ice;
  const cv::Mat p = p_ice(l, 1.3);
  for (std::size_t i = 0; i < exact.size(); ++i)
    EXPECT_NEAR(p.at<float>(0, static_cast<int>(i)), exact[i], 1e-5);
}

TEST(Marginals, WithoutCouplingAreTheRawMapToTheBit) {
  std::mt19937 random(9);
  const cv::Mat l = test::random_field(20, 30, 3.0, 0.1, random);
  const cv::Mat p = p_ice(l, 0.0);
  for (int r = 0; r < l.rows; ++r)
    for (int c = 0; c < l.cols; ++c)
      if (const float x = l.at<float>(r, c); std::isnan(x))
        EXPECT_TRUE(std::isnan(p.at<float>(r, c)));
      else
        EXPECT_EQ(p.at<float>(r, c), 1.0F / (1.0F + std::exp(-x)));
  EXPECT_LT(largest_difference(p_ice(l, 1e-6), p), 1e-4) << "and there is no jump at 0";
}

TEST(Marginals, TurnAndFlipWithTheirEvidence) {
  std::mt19937 random(10);
  const cv::Mat l = test::random_field(21, 26, 1.0, 0.1, random);
  const cv::Mat p = p_ice(l, 0.3);
  cv::Mat turned_l, turned;
  cv::rotate(l, turned_l, cv::ROTATE_90_CLOCKWISE);
  cv::rotate(p, turned, cv::ROTATE_90_CLOCKWISE);
  EXPECT_LT(largest_difference(p_ice(turned_l, 0.3), turned), 1e-4);
  EXPECT_LT(largest_difference(p_ice(-l, 0.3), cv::Mat(1.0 - p)), 1e-4);
}

TEST(Marginals, CellsNeverSeenSayNothing) {
  std::mt19937 random(11);
  const cv::Mat l = test::random_field(9, 9, 1.0, 0.0, random);
  cv::Mat apart(9, 20, CV_32F, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  l.copyTo(apart.colRange(0, 9));
  apart.colRange(11, 20).setTo(20.0);
  EXPECT_LT(largest_difference(p_ice(apart, 0.5).colRange(0, 9), p_ice(l, 0.5)), 1e-5);
}

TEST(Marginals, MoreEvidenceOfIceNeverMakesLessIce) {
  std::mt19937 random(12);
  std::uniform_int_distribution<int> place(0, 19);
  cv::Mat l = test::random_field(20, 20, 1.0, 0.05, random);
  cv::Mat before = p_ice(l, 0.8);
  for (int k = 0; k < 20; ++k) {
    l.at<float>(place(random), place(random)) += 1.5F;
    const cv::Mat after = p_ice(l, 0.8);
    for (int r = 0; r < l.rows; ++r)
      for (int c = 0; c < l.cols; ++c)
        EXPECT_FALSE(after.at<float>(r, c) < before.at<float>(r, c) - 1e-4F);
    before = after;
  }
}

TEST(Marginals, StayFiniteAtTheEndsOfTheirRange) {
  cv::Mat l(12, 12, CV_32F, cv::Scalar(std::numeric_limits<float>::infinity()));
  l.colRange(6, 12).setTo(-1e30);
  l.at<float>(3, 3) = -1e30F;
  const cv::Mat p = p_ice(l, kMaxCoupling, 50);
  for (const float x : cv::Mat_<float>(p)) EXPECT_TRUE(x >= 0.0F && x <= 1.0F);
  EXPECT_GT(p.at<float>(0, 0), 0.999F);
  EXPECT_LT(p.at<float>(0, 11), 0.001F);
  EXPECT_FALSE(marginals(l, -1.0));
  EXPECT_FALSE(marginals(cv::Mat(2, 2, CV_8U), 1.0));
}

}  // namespace
}  // namespace watersky::field
