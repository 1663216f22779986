// SPDX-License-Identifier: MIT
#include "watersky/align/detail/capture_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace watersky::align {
namespace {

TEST(CaptureClock, LiesUnderTheArrivalsOfCountedFrames) {
  std::mt19937 random(1);
  std::exponential_distribution<double> late(1 / 0.03);
  std::vector<std::uint64_t> counters;
  std::vector<double> received;
  for (std::uint64_t k = 0; k < 900; ++k) {
    if (random() % 20 == 0) continue;  // lost
    counters.push_back(5000 + k);
    received.push_back(12.0 + 0.0333 * static_cast<double>(k) + 0.2 + late(random));
  }
  const auto clock = fit_capture_clock(counters, received);
  ASSERT_TRUE(clock);
  EXPECT_NEAR(clock->period_s, 0.0333, 1e-5);
  // Even to within a few milliseconds at both ends; the constant delay stays in it.
  const double first = clock->start_s + clock->period_s * 5000.0 - 12.0;
  const double last = clock->start_s + clock->period_s * 5899.0 - (12.0 + 0.0333 * 899);
  EXPECT_NEAR(first, last, 0.006);
  EXPECT_NEAR(first, 0.2, 0.01);
}

TEST(CaptureClock, SaysHowFarItsPeriodMayBeOff) {
  std::vector<double> share;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    std::exponential_distribution<double> late(1 / 0.035);
    std::normal_distribution<double> normal;
    std::vector<std::uint64_t> counters;
    std::vector<double> received;
    double wander_s = 0.0;  // the delay's own, over a minute
    for (std::uint64_t k = 0; k < 600; ++k) {
      wander_s += 2e-4 * normal(random);
      counters.push_back(k);
      received.push_back(static_cast<double>(k) / 30.0 + wander_s + late(random));
    }
    const auto clock = fit_capture_clock(counters, received);
    ASSERT_TRUE(clock);
    share.push_back(std::abs(clock->period_s * 30.0 - 1.0) / clock->rate_sigma);
  }
  std::sort(share.begin(), share.end());
  EXPECT_LT(share.back(), 4.0);
  EXPECT_GT(share[share.size() / 2], 0.1) << "so much room says nothing";
}

TEST(CaptureClock, RefusesCountersThatDoNotRiseAndTooFewFrames) {
  EXPECT_FALSE(fit_capture_clock({1, 2, 3}, {0.1, 0.2, 0.3}));
  EXPECT_FALSE(fit_capture_clock({1, 2, 3, 4, 4, 5, 6, 7, 8}, {1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST(CaptureClock, EvenTimesFollowALineThroughTheArrivals) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  std::vector<double> received;
  for (int k = 0; k < 200; ++k) received.push_back(0.1 * k + 0.02 * normal(random));
  const auto even = even_times(received);
  double square = 0.0;
  for (int k = 0; k < 200; ++k)
    square += std::pow(even[static_cast<std::size_t>(k)] - 0.1 * k, 2) / 200;
  EXPECT_LT(std::sqrt(square), 0.008);
  for (std::size_t k = 1; k < even.size(); ++k) EXPECT_GT(even[k], even[k - 1]);
}

TEST(FindSlots, PutsEveryFrameIntoItsOwnSlot) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> estimated, sigma;
  std::vector<std::int64_t> truth;
  for (int k = 0; k < 1000; ++k) {
    if (random() % 25 == 0) continue;  // lost
    // Stretches in which nothing was seen, so that times are known by arrival only.
    const bool blind = k % 100 > 70;
    truth.push_back(k);
    estimated.push_back(3.0 + 0.0333 * k + (blind ? 0.012 : 0.001) * normal(random));
    sigma.push_back(blind ? std::numeric_limits<double>::infinity() : 0.001);
  }
  const auto slots = find_slots(estimated, sigma);
  ASSERT_TRUE(slots);
  EXPECT_NEAR(slots->clock.period_s, 0.0333, 1e-6);
  EXPECT_LT(slots->residual_s, 0.002);
  std::size_t wrong_seen = 0, wrong_blind = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool wrong = slots->slot[i] - slots->slot[0] != truth[i] - truth[0];
    (std::isfinite(sigma[i]) ? wrong_seen : wrong_blind) += wrong ? 1 : 0;
    if (i > 0) {
      EXPECT_GT(slots->slot[i], slots->slot[i - 1]);
    }
  }
  EXPECT_EQ(wrong_seen, 0U);
  EXPECT_LT(wrong_blind, truth.size() / 20);
}

TEST(FindSlots, RefusesTimesThatLieOnNoGrid) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> step(0.02, 0.05);
  std::vector<double> estimated{1.0}, sigma{0.001};
  for (int k = 0; k < 500; ++k) {
    estimated.push_back(estimated.back() + step(random));
    sigma.push_back(0.001);
  }
  EXPECT_FALSE(find_slots(estimated, sigma));
}

TEST(ArrivalClock, FindsTheRegularClockOfCountedFramesAsTheyComeIn) {
  std::mt19937 random(5);
  std::exponential_distribution<double> late(1.0 / 0.04);
  ArrivalClock clock;
  EXPECT_FALSE(clock.settled());
  double received = 0.0, worst = 0.0, start = std::nan("");
  for (std::uint64_t k = 0; k < 600; ++k) {
    received = std::max(received + 1e-4, 0.0333 * static_cast<double>(k) + 0.2 + late(random));
    clock.add(received, k);
    if (k < 300) continue;
    ASSERT_TRUE(clock.regular());
    EXPECT_EQ(clock.jitter_s(), 0.0);
    const double off = clock.base_s(received, k) - 0.0333 * static_cast<double>(k);
    if (std::isnan(start)) start = off;
    worst = std::max(worst, std::abs(off - start));
  }
  EXPECT_LT(worst, 0.004);
}

TEST(ArrivalClock, WithoutACounterTellsHowUnevenlyFramesArrive) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 0.01);
  ArrivalClock clock;
  for (int k = 0; k < 120; ++k) clock.add(0.1 * k + normal(random), std::nullopt);
  EXPECT_TRUE(clock.settled());
  EXPECT_FALSE(clock.regular());
  EXPECT_GT(clock.jitter_s(), 0.006);
  EXPECT_LT(clock.jitter_s(), 0.02);
  EXPECT_EQ(clock.base_s(12.5, std::nullopt), 12.5);
}

TEST(ArrivalClock, ACounterThatFallsIsNoClock) {
  ArrivalClock clock;
  for (std::uint64_t k = 0; k < 90; ++k)
    clock.add(0.1 * static_cast<double>(k), k < 45 ? k : k - 45);  // the camera started anew
  EXPECT_FALSE(clock.regular());
}

}  // namespace
}  // namespace watersky::align
