// SPDX-License-Identifier: MIT
#include "watersky/evaluation/segmentation_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

namespace watersky {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

cv::Mat row(const std::vector<float>& values) { return cv::Mat(values, true).reshape(1, 1); }
cv::Mat mask(const std::vector<unsigned char>& values) {
  return cv::Mat(values, true).reshape(1, 1);
}

TEST(SegmentationScore, CountsByHand) {
  const auto s = score_segmentation(row({0.9F, 0.8F, 0.6F, 0.2F, 0.1F, 0.4F, kNaN, 0.7F}),
                                    mask({1, 1, 0, 0, 0, 1, 1, 1}))
                     .value();
  EXPECT_EQ(s.pixels, 8u);
  EXPECT_DOUBLE_EQ(s.unknown_share, 1.0 / 8);
  EXPECT_DOUBLE_EQ(s.accuracy, 5.0 / 8);       // wrong: the third, the sixth, the unknown one
  EXPECT_DOUBLE_EQ(s.iou, 3.0 / 6);            // both: 1, 2, 8; any: those, 3, 6, 7
  EXPECT_DOUBLE_EQ(s.concentration, 4.0 / 7);  // of the known
  EXPECT_DOUBLE_EQ(s.true_concentration, 5.0 / 8);
  EXPECT_DOUBLE_EQ(s.p_ice_if_ice, 3.0 / 4);
  EXPECT_DOUBLE_EQ(s.p_ice_if_water, 1.0 / 3);
  EXPECT_NEAR(s.brier, (0.01 + 0.04 + 0.36 + 0.04 + 0.01 + 0.36 + 0.25 + 0.09) / 8, 1e-7);
}

TEST(SegmentationScore, OfTheTruthItselfIsPerfectAndOfItsOppositeNil) {
  cv::RNG rng(1);
  for (int i = 0; i < 20; ++i) {
    cv::Mat ice(rng.uniform(1, 40), rng.uniform(1, 40), CV_8U), p;
    rng.fill(ice, cv::RNG::UNIFORM, 0, 2);
    if (cv::countNonZero(ice) == 0) ice.at<unsigned char>(0, 0) = 1;
    ice.convertTo(p, CV_32F);
    const auto same = score_segmentation(p, ice).value();
    EXPECT_EQ(same.accuracy, 1.0);
    EXPECT_EQ(same.iou, 1.0);
    EXPECT_EQ(same.brier, 0.0);
    EXPECT_EQ(same.calibration_error(), 0.0);
    EXPECT_EQ(same.concentration_error(), 0.0);
    const auto opposite = score_segmentation(1.0 - p, ice).value();
    EXPECT_EQ(opposite.accuracy, 0.0);
    EXPECT_EQ(opposite.iou, 0.0);
    EXPECT_EQ(opposite.brier, 1.0);
    EXPECT_EQ(opposite.calibration_error(), 1.0);
  }
}

// Pixels that are ice exactly as often as said: calibrated whatever the probabilities.
TEST(SegmentationScore, CalibrationErrorIsThatOfTheProbabilitiesNotOfTheClasses) {
  cv::RNG rng(2);
  cv::Mat p(400, 500, CV_32F), ice(p.size(), CV_8U);
  for (int y = 0; y < p.rows; ++y)
    for (int x = 0; x < p.cols; ++x) {
      p.at<float>(y, x) = rng.uniform(0.0F, 1.0F);
      ice.at<unsigned char>(y, x) = rng.uniform(0.0F, 1.0F) < p.at<float>(y, x);
    }
  const auto calibrated = score_segmentation(p, ice).value();
  EXPECT_LT(calibrated.calibration_error(), 0.01);
  EXPECT_NEAR(calibrated.accuracy, 0.75, 0.01);
  // Half as far from one half as it should be.
  cv::Mat timid;
  p.convertTo(timid, CV_32F, 0.5, 0.25);
  const auto shy = score_segmentation(timid, ice).value();
  EXPECT_NEAR(shy.calibration_error(), 0.125, 0.01);  // mean of |p - 1/2| / 2
  EXPECT_EQ(shy.accuracy, calibrated.accuracy);
}

TEST(SegmentationScore, SilenceRaisesNoScore) {
  cv::RNG rng(3);
  cv::Mat p(60, 60, CV_32F), ice(p.size(), CV_8U);
  rng.fill(p, cv::RNG::UNIFORM, 0.0, 1.0);
  rng.fill(ice, cv::RNG::UNIFORM, 0, 2);
  const auto all = score_segmentation(p, ice).value();
  p.rowRange(0, 30).setTo(kNaN);
  const auto half = score_segmentation(p, ice).value();
  EXPECT_DOUBLE_EQ(half.unknown_share, 0.5);
  EXPECT_LE(half.accuracy, all.accuracy);
  EXPECT_LE(half.iou, all.iou);
  p.setTo(kNaN);
  const auto none = score_segmentation(p, ice).value();
  EXPECT_EQ(none.accuracy, 0.0);
  EXPECT_EQ(none.brier, 0.25);
  EXPECT_TRUE(std::isnan(none.concentration));
  EXPECT_TRUE(std::isnan(none.p_ice_if_ice));
  EXPECT_NEAR(none.concentration_error(), std::abs(0.5 - none.true_concentration), 1e-12);
}

TEST(SegmentationScore, WithoutIceAnywhereIsRight) {
  const auto s = score_segmentation(row({0.1F, 0.2F}), mask({0, 0})).value();
  EXPECT_EQ(s.accuracy, 1.0);
  EXPECT_EQ(s.iou, 1.0);
  EXPECT_EQ(s.concentration, 0.0);
  EXPECT_TRUE(std::isnan(s.p_ice_if_ice));
}

TEST(SegmentationScore, JudgesOnlyWhatItIsAsked) {
  const auto s =
      score_segmentation(row({0.9F, 0.9F, kNaN}), mask({1, 0, 0}), mask({1, 0, 0})).value();
  EXPECT_EQ(s.pixels, 1u);
  EXPECT_EQ(s.accuracy, 1.0);
}

TEST(SegmentationScore, RefusesWhatDoesNotFit) {
  EXPECT_EQ(score_segmentation(row({0.9F}), mask({1, 0})).error().code, ErrorCode::InvalidInput);
  EXPECT_EQ(score_segmentation(mask({1}), mask({1})).error().code, ErrorCode::InvalidInput);
  EXPECT_EQ(score_segmentation(row({0.9F}), mask({1}), mask({0})).error().code,
            ErrorCode::InvalidInput);
  EXPECT_EQ(score_segmentation({}, {}).error().code, ErrorCode::InvalidInput);
}

TEST(SegmentationScore, MeansWeighImagesAlikeAndPoolTheirPixels) {
  const auto small = score_segmentation(row({0.9F, 0.1F}), mask({1, 1})).value();
  const auto large =
      score_segmentation(row({0.9F, 0.9F, 0.9F, 0.1F, 0.1F, 0.1F}), mask({1, 1, 1, 0, 0, 0}))
          .value();
  const auto mean = mean_score({small, large});
  EXPECT_EQ(mean.images, 2u);
  EXPECT_DOUBLE_EQ(mean.accuracy, 0.75);
  EXPECT_DOUBLE_EQ(mean.worst_accuracy, 0.5);
  EXPECT_DOUBLE_EQ(mean.p_ice_if_ice, 1.0);
  EXPECT_DOUBLE_EQ(mean.p_ice_if_water, 0.25);  // one of four
  EXPECT_EQ(mean.reliability.pixels(), 8u);
  EXPECT_EQ(mean_score({}).images, 0u);
}

}  // namespace
}  // namespace watersky
