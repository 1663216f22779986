// SPDX-License-Identifier: MIT
#include "statistics.hpp"

#include <gtest/gtest.h>

namespace watersky::study {
namespace {

const double kNone = std::nan("");

TEST(Statistics, QuantilesLieBetweenTheFiniteValues) {
  EXPECT_DOUBLE_EQ(median({3.0, 1.0, 2.0}), 2.0);
  EXPECT_DOUBLE_EQ(median({4.0, kNone, 1.0}), 2.5);
  EXPECT_DOUBLE_EQ(quantile({0.0, 10.0, 20.0}, 0.9), 18.0);
  EXPECT_DOUBLE_EQ(quantile({7.0}, 0.9), 7.0);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(Statistics, TheWorstOfWhatCouldNotBeDoneIsNotANumber) {
  EXPECT_DOUBLE_EQ(largest({1.0, 3.0, -4.0}), 3.0);
  EXPECT_DOUBLE_EQ(smallest({1.0, 3.0, -4.0}), -4.0);
  EXPECT_TRUE(std::isnan(largest({1.0, kNone})));
  EXPECT_TRUE(std::isnan(smallest({kNone, 1.0})));
  EXPECT_TRUE(std::isnan(largest({})));
}

}  // namespace
}  // namespace watersky::study
