// SPDX-License-Identifier: MIT
#include "watersky/field/coupling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <random>

#include "support/small_fields.hpp"

namespace watersky::field {
namespace {

/// A sea of broad floes; each cell says what it is with log-odds ±strength, wrong as often as that
/// says.
cv::Mat told(const cv::Mat& ice, double strength, unsigned seed) {
  std::mt19937 random(seed);
  std::bernoulli_distribution right(1 / (1 + std::exp(-strength)));
  cv::Mat l(ice.size(), CV_32F);
  for (int r = 0; r < l.rows; ++r)
    for (int c = 0; c < l.cols; ++c)
      l.at<float>(r, c) = static_cast<float>(
          (ice.at<std::uint8_t>(r, c) != 0) == right(random) ? strength : -strength);
  return l;
}

cv::Mat broad_floes(int rows, int columns) {
  cv::Mat ice(rows, columns, CV_8U);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      ice.at<std::uint8_t>(r, c) = std::sin(0.15 * r) + std::cos(0.11 * c) > 0.3 ? 1 : 0;
  return ice;
}

TEST(Coupling, IsNoneWhereCellsHaveNothingToDoWithEachOther) {
  cv::Mat ice(120, 120, CV_8U);
  std::mt19937 random(1);
  for (std::uint8_t& x : cv::Mat_<std::uint8_t>(ice)) x = random() % 2;
  const auto estimate = estimate_coupling(told(ice, 2.0, 2));
  ASSERT_TRUE(estimate);
  EXPECT_LT(estimate->coupling, 0.02);
  EXPECT_LT(estimate->best_foretelling, 0.1);
  EXPECT_EQ(estimate->cells, 120u * 120u);
}

TEST(Coupling, IsFoundWhereFloesAreBroad) {
  for (const double strength : {0.5, 1.0, 3.0}) {
    const auto estimate = estimate_coupling(told(broad_floes(120, 120), strength, 3));
    ASSERT_TRUE(estimate);
    EXPECT_GT(estimate->best_foretelling, 0.3) << strength;
    EXPECT_GT(estimate->coupling, 0.02) << strength;
    EXPECT_LT(estimate->coupling, estimate->best_foretelling) << strength;
  }
}

TEST(Coupling, WindowsOfALargeMapSayWhatAllOfItSays) {
  const cv::Mat l = told(broad_floes(512, 600), 1.0, 4);
  const auto large = estimate_coupling(l);
  const auto part = estimate_coupling(l(cv::Rect(0, 0, 128, 256)).clone());
  ASSERT_TRUE(large && part);
  EXPECT_EQ(large->cells, 16u * 128u * 128u);
  EXPECT_NEAR(large->coupling, part->coupling, 0.03);
}

TEST(Coupling, OfNothingIsNone) {
  for (const cv::Mat& l :
       {cv::Mat(),
        cv::Mat(300, 300, CV_32F, cv::Scalar(std::numeric_limits<float>::quiet_NaN()))}) {
    const auto estimate = estimate_coupling(l);
    ASSERT_TRUE(estimate);
    EXPECT_EQ(estimate->coupling, 0.0);
    EXPECT_EQ(estimate->cells, 0u);
  }
  EXPECT_FALSE(estimate_coupling(cv::Mat(3, 3, CV_64F, cv::Scalar(0))));
}

}  // namespace
}  // namespace watersky::field
