// SPDX-License-Identifier: MIT
#include "watersky/map/log_odds.hpp"

#include <gtest/gtest.h>

#include <random>

namespace watersky {
namespace {

TEST(LogOdds, ProbabilityUndoesItAndNeverOverflows) {
  for (double p = 0.001; p < 1; p += 0.001) EXPECT_NEAR(probability(log_odds(p)), p, 1e-12);
  EXPECT_EQ(probability(1e6), 1.0);
  EXPECT_EQ(probability(-1e6), 0.0);
}

// (2.21) written out as the sum over both states, step by step.
TEST(CellDynamics, WholeStepsAreTheSumOverTheTransitionMatrix) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 500; ++i) {
    const double stay = 0.5 + 0.5 * uniform(rng), turn = uniform(rng) * stay;
    if (stay - turn > 0.999) continue;
    const double prior = turn / (1 - (stay - turn));
    const auto dynamics = CellDynamics::make(stay, turn, 2.0, prior);
    ASSERT_TRUE(dynamics.ok()) << dynamics.error().message;
    double p = uniform(rng), stepped = p;
    for (int k = 0; k < 3; ++k) stepped = stay * stepped + turn * (1 - stepped);
    EXPECT_NEAR(dynamics->predict(p, 6.0), stepped, 1e-12);
    // Two halves are the whole: elapsed time is what counts.
    EXPECT_NEAR(dynamics->predict(dynamics->predict(p, 2.3), 3.7), stepped, 1e-12);
    EXPECT_NEAR(dynamics->predict(prior, 1e4), prior, 1e-9);
  }
}

TEST(CellDynamics, APriorThatIsNotStationaryIsRefusedWithTheOneThatIs) {
  const auto refused = CellDynamics::make(0.9, 0.2, 1.0, 0.5);  // stationary: 0.2 / 0.3
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("0.666667"), std::string::npos) << refused.error().message;
  EXPECT_TRUE(CellDynamics::make(0.9, 0.2, 1.0, 2.0 / 3).ok());
  EXPECT_TRUE(CellDynamics::make(1.0, 0.0, 1.0, 0.3).ok()) << "a still sea keeps any prior";
  EXPECT_FALSE(CellDynamics::make(1.2, 0.2, 1.0, 0.5).ok());
  EXPECT_FALSE(CellDynamics::make(0.9, 0.1, 0.0, 0.5).ok());
  EXPECT_FALSE(CellDynamics::make(0.2, 0.9, 1.0, 0.53).ok());
}

}  // namespace
}  // namespace watersky
