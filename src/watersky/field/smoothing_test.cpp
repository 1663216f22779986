// SPDX-License-Identifier: MIT
#include "watersky/field/smoothing.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <opencv2/core.hpp>
#include <random>

#include "support/small_fields.hpp"

namespace watersky::field {
namespace {

/// A half plane of ice whose evidence is weak and noisy.
cv::Mat noisy_edge(unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat l = test::random_field(80, 100, 1.0, 0.05, random);
  l.colRange(0, 50) -= 0.6;
  l.colRange(50, 100) += 0.6;
  return l;
}

int wrong(const cv::Mat& ice) {
  return cv::countNonZero(ice.colRange(0, 50)) + 80 * 50 - cv::countNonZero(ice.colRange(50, 100));
}

TEST(Smoothing, RemovesSpecksFromANoisyMap) {
  const cv::Mat l = noisy_edge(1);
  const auto raw = smooth(l, {.coupling = 0.0}), smoothed = smooth(l);
  ASSERT_TRUE(raw && smoothed);
  EXPECT_FALSE(raw->best_foretelling);
  EXPECT_TRUE(smoothed->best_foretelling);
  EXPECT_GT(smoothed->coupling, 0.0);
  const int raw_wrong = wrong(raw->most_likely == 1);
  EXPECT_LT(wrong(smoothed->most_likely == 1), raw_wrong / 2);
  EXPECT_LT(wrong(smoothed->probability > 0.5), 3 * raw_wrong / 4);
}

TEST(Smoothing, WithoutCouplingChangesNothing) {
  const cv::Mat l = noisy_edge(2);
  const auto raw = smooth(l, {.coupling = 0.0});
  ASSERT_TRUE(raw);
  for (int r = 0; r < l.rows; ++r)
    for (int c = 0; c < l.cols; ++c) {
      const float x = l.at<float>(r, c);
      EXPECT_EQ(raw->most_likely.at<std::uint8_t>(r, c), x != x ? kUnseen : x > 0 ? 1 : 0);
      const float p = raw->probability.at<float>(r, c);
      EXPECT_TRUE(x != x ? p != p : p == 1.0F / (1.0F + std::exp(-x)));
    }
}

TEST(Smoothing, IsTheSameEachTime) {
  const cv::Mat l = noisy_edge(3);
  const auto a = smooth(l), b = smooth(l);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->coupling, b->coupling);
  EXPECT_EQ(a->iterations, b->iterations);
  EXPECT_EQ(std::memcmp(a->probability.data, b->probability.data, 4 * l.total()), 0);
  EXPECT_EQ(std::memcmp(a->most_likely.data, b->most_likely.data, l.total()), 0);
}

TEST(Smoothing, RefusesParametersOutOfTheirRange) {
  EXPECT_EQ(smooth(noisy_edge(4), {.coupling = 9.0}).error().code, ErrorCode::Usage);
  EXPECT_EQ(smooth(noisy_edge(4), {.smoothing_iterations = 0}).error().code, ErrorCode::Usage);
  EXPECT_EQ(smooth(cv::Mat(2, 2, CV_8U)).error().code, ErrorCode::InvalidInput);
}

}  // namespace
}  // namespace watersky::field
