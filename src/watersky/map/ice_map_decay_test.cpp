// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "watersky/map/detail/test_scene.hpp"
#include "watersky/map/ice_map.hpp"

namespace watersky {
namespace {

using test::FlatGrid;

GridView some_view(double north_m = 0.0) {
  return test::grid_view(test::pinhole(), test::pose({north_m, 0, -40.0}, {0_deg, -90_deg, 0_deg}),
                         FlatGrid());
}
cv::Mat saying(double log_odds) { return cv::Mat(120, 160, CV_32F, cv::Scalar(log_odds)); }
Time at(double s) { return *time_from_seconds(s); }

TEST(IceMapDecay, IsOffUntilAskedForAndThenSeen) {
  IceMap map = IceMap::make({.prior = 0.25}).value();
  EXPECT_FALSE(map.decay().has_value());
  ASSERT_TRUE(map.update(some_view(), saying(2.0), at(100)).ok());
  map.predict(at(1e6));
  const cv::Mat l = map.log_odds({120, 74, 1, 1});
  EXPECT_NEAR(l.at<float>(0, 0), 2.0 + log_odds(0.25), 1e-3);
  const auto dynamics = CellDynamics::make(0.97, 0.01, 10.0, 0.25).value();
  ASSERT_TRUE(map.forget(dynamics, at(200)).ok());
  ASSERT_TRUE(map.decay().has_value());
  EXPECT_EQ(map.decay()->from, at(200));
}

TEST(IceMapDecay, ForgetsTowardsThePriorAndLeavesTheUnseenAlone) {
  IceMap map = IceMap::make({.prior = 0.25}).value();
  ASSERT_TRUE(map.update(some_view(), saying(2.0), at(100)).ok());
  const auto dynamics = CellDynamics::make(0.97, 0.01, 10.0, 0.25).value();
  const cv::Mat before = map.probability({120, 74, 1, 1}).clone();
  ASSERT_TRUE(map.forget(dynamics, Time{}).ok());
  map.predict(at(135));
  const cv::Mat after = map.probability({120, 74, 1, 1});
  EXPECT_NEAR(after.at<float>(0, 0), dynamics.predict(before.at<float>(0, 0), 35.0), 1e-5);
  const cv::Mat l = map.log_odds({0, 0, 1, 1});
  EXPECT_NEAR(l.at<float>(0, 0), log_odds(0.25), 1e-6);
}

TEST(IceMapDecay, OnlyTimeAfterItBeganCounts) {
  IceMap map = IceMap::make({.prior = 0.25}).value();
  ASSERT_TRUE(map.update(some_view(), saying(2.0), at(100)).ok());
  const auto dynamics = CellDynamics::make(0.97, 0.01, 10.0, 0.25).value();
  const cv::Mat before = map.probability({120, 74, 1, 1}).clone();
  ASSERT_TRUE(map.forget(dynamics, at(120)).ok());
  map.predict(at(135));
  const cv::Mat after = map.probability({120, 74, 1, 1});
  EXPECT_NEAR(after.at<float>(0, 0), dynamics.predict(before.at<float>(0, 0), 15.0), 1e-5);
}

TEST(IceMapDecay, DynamicsWithAnotherPriorAreRefused) {
  IceMap map = IceMap::make({.prior = 0.5}).value();
  EXPECT_FALSE(map.forget(CellDynamics::make(0.97, 0.01, 10.0, 0.25).value(), Time{}).ok());
}

// Cells that are brought forward when they are looked at, against a filter that predicts all of
// them at every frame: each of up to n looks rounds twice by less than 1/1024, and forgetting
// only makes such errors smaller. The mean over cells shows that rounding does not bias.
TEST(IceMapDecay, LazyEqualsEagerToTheRoundingOfItsLooks) {
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> uniform(0, 1);
  const double prior = 0.3;
  for (const double step_s : {1.0, 60.0, 3600.0}) {
    const double p_iw = 0.002, p_ii = 1 - p_iw * (1 - prior) / prior;
    const auto dynamics = CellDynamics::make(p_ii, p_iw, step_s, prior).value();
    IceMap map = IceMap::make({.prior = prior}).value();
    ASSERT_TRUE(map.forget(dynamics, Time{}).ok());
    const CellBox box{60, 0, 120, 170};
    cv::Mat eager(box.rows, box.columns, CV_64F, cv::Scalar(0));  // log-odds less the prior's
    const double limit = log_odds(0.999);
    double time_s = 0.0;
    constexpr int kLooks = 60;
    for (int look = 0; look < kLooks; ++look) {
      const double elapsed_s = 0.033 + (look % 10 == 0 ? 20.0 * uniform(rng) : 0.0);
      time_s += elapsed_s;
      const double e = 2.0 * uniform(rng) - 0.9;
      IceMap once = IceMap::make({.prior = prior}).value();
      const GridView view = some_view(30 * uniform(rng) - 15);
      ASSERT_TRUE(once.update(view, saying(e), at(time_s)).ok());
      ASSERT_TRUE(map.update(view, saying(e), at(time_s)).ok());
      const cv::Mat seen = once.looks(box), known = map.looks(box);
      for (int r = 0; r < box.rows; ++r)
        for (int c = 0; c < box.columns; ++c) {
          double& l = eager.at<double>(r, c);
          if (known.at<std::uint16_t>(r, c) > 0 && l != 0)
            l = log_odds(dynamics.predict(probability(l + log_odds(prior)), elapsed_s)) -
                log_odds(prior);
          if (seen.at<std::uint16_t>(r, c) > 0)
            l = std::clamp(l + e, -limit - log_odds(prior), limit - log_odds(prior));
        }
    }
    const cv::Mat lazy = map.log_odds(box), looks = map.looks(box);
    double worst = 0, sum = 0;
    int n = 0;
    for (int r = 0; r < box.rows; ++r)
      for (int c = 0; c < box.columns; ++c) {
        const int k = looks.at<std::uint16_t>(r, c);
        if (k == 0) continue;
        const double error = lazy.at<float>(r, c) - log_odds(prior) - eager.at<double>(r, c);
        worst = std::max(worst, std::abs(error) * 1024 / (2.0 * k));
        sum += error;
        ++n;
      }
    ASSERT_GT(n, 10000);
    EXPECT_LT(worst, 1.0) << step_s;
    EXPECT_LT(std::abs(sum / n), 1.0 / 1024) << step_s;
  }
}

}  // namespace
}  // namespace watersky
