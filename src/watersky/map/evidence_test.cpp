// SPDX-License-Identifier: MIT
#include "watersky/map/evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "watersky/map/detail/evidence_levels.hpp"
#include "watersky/map/log_odds.hpp"

namespace watersky {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

TEST(Evidence, OfThresholdsIsEquation231LessThePrior) {
  const EvidenceTable t = threshold_evidence(100, 0.7, 0.4, 0.3);
  EXPECT_FLOAT_EQ(t[100], static_cast<float>(log_odds(0.4) - log_odds(0.3)));
  EXPECT_FLOAT_EQ(t[101], static_cast<float>(log_odds(0.7) - log_odds(0.3)));
}

TEST(Evidence, OfProbabilitiesIsNeverInfinite) {
  const EvidenceTable t = probability_evidence(0.5);
  for (int l = 1; l < 255; ++l)
    EXPECT_NEAR(t[static_cast<std::size_t>(l)], log_odds(l / 255.0), 1e-5);
  EXPECT_FLOAT_EQ(t[255], -t[0]);
  EXPECT_NEAR(t[255], log_odds(509.0 / 510), 1e-5);
}

TEST(Evidence, OfTheWrongTypeOrSizeIsRefused) {
  const cv::Mat levels(4, 5, CV_8U, cv::Scalar(0)), floats(4, 5, CV_32F, cv::Scalar(0));
  const EvidenceTable table{};
  EXPECT_TRUE(Evidence::of_levels(levels, table).check().ok());
  EXPECT_TRUE(Evidence::of_levels(levels, table, levels).check().ok());
  EXPECT_TRUE(Evidence::of_log_odds(floats).check().ok());
  EXPECT_FALSE(Evidence::of_levels(floats, table).check().ok());
  EXPECT_FALSE(Evidence::of_log_odds(levels).check().ok());
  EXPECT_FALSE(Evidence::of_log_odds({}).check().ok());
  EXPECT_FALSE(Evidence::of_levels(levels, table, cv::Mat(4, 4, CV_8U)).check().ok());
  EXPECT_FALSE(Evidence::of_levels(levels, table, floats).check().ok());
}

// Every way to average, of levels and of log-odds, with and without unknown pixels, is the mean of
// the pixels it stands for.
TEST(EvidenceLevels, EveryPixelIsTheMeanOfWhatItStandsFor) {
  std::mt19937 rng(3);
  const auto pick = [&](int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(rng);
  };
  const detail::UpdateKernels& kernels = detail::update_kernels();
  for (int round = 0; round < 60; ++round) {
    const int kind = round % 4;  // a threshold, a table, a table with unknown levels, log-odds
    // Also sizes at which a piece holds nothing but the edge.
    cv::Mat levels(pick(1, 60), round % 3 == 0 ? pick(1020, 1026) : pick(1, 170), CV_8U);
    for (auto& l : cv::Mat_<std::uint8_t>(levels)) l = static_cast<std::uint8_t>(pick(0, 255));
    EvidenceTable table = threshold_evidence(pick(0, 255), 0.7, 0.4, 0.5);
    if (kind != 0)
      for (float& e : table) e = static_cast<float>(pick(-3000, 3000)) / 1000.0F;
    if (kind >= 2)
      for (int l = 0; l < 256; l += 3) table[static_cast<std::size_t>(l)] = kNothing;
    cv::Mat valid;
    if (round % 8 == 2) valid = levels < 200;
    cv::Mat_<float> truth(levels.size());
    for (int v = 0; v < levels.rows; ++v)
      for (int u = 0; u < levels.cols; ++u)
        truth(v, u) = !valid.empty() && valid.at<std::uint8_t>(v, u) == 0
                          ? kNothing
                          : table[levels.at<std::uint8_t>(v, u)];
    detail::EvidenceLevels all(kernels);
    all.begin(kind == 3 ? Evidence::of_log_odds(truth) : Evidence::of_levels(levels, table, valid));
    for (const int shrink : {1, 2, 3, 5, 16})
      for (const bool doubled : {false, true}) {
        auto& level = all.level({shrink, doubled});
        all.make(level, -1, -1, level.width, level.height);
        /// The mean of a group of pixels of the image, or NaN.
        const auto group = [&](int gu, int gv) {
          gu = std::clamp(gu, 0, level.width - 1);
          gv = std::clamp(gv, 0, level.height - 1);
          double sum = 0;
          int known = 0, pixels = 0;
          for (int v = gv * shrink; v < std::min((gv + 1) * shrink, truth.rows); ++v)
            for (int u = gu * shrink; u < std::min((gu + 1) * shrink, truth.cols); ++u) {
              ++pixels;
              if (std::isnan(truth(v, u))) continue;
              sum += truth(v, u);
              ++known;
            }
          return known > 0 && 2 * known >= pixels ? sum / known
                                                  : std::numeric_limits<double>::quiet_NaN();
        };
        for (int v = -1; v <= level.height; ++v)
          for (int u = -1; u <= level.width; ++u) {
            double expected = group(u, v);
            if (doubled) {
              double sum = 0;
              int known = 0;
              for (const double g :
                   {group(u, v), group(u + 1, v), group(u, v + 1), group(u + 1, v + 1)})
                if (!std::isnan(g)) sum += g, ++known;
              expected = known >= 2 ? sum / known : std::numeric_limits<double>::quiet_NaN();
            }
            const std::int16_t is = *level.at(u, v);
            ASSERT_EQ(std::isnan(expected), is == detail::kUnknownPixel)
                << kind << " " << shrink << " " << doubled << " at " << u << "," << v;
            if (std::isnan(expected)) continue;
            ASSERT_NEAR(static_cast<double>(is) / (1 << (10 + all.finer_bits())), expected,
                        1.6 / (1 << (10 + all.finer_bits())))
                << kind << " " << shrink << " " << doubled << " at " << u << "," << v;
          }
      }
  }
}

}  // namespace
}  // namespace watersky
