// SPDX-License-Identifier: MIT
#include "watersky/vision/learned_segmenter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "watersky/vision/detail/test_frames.hpp"

namespace watersky {
namespace {

using namespace test;
using ::testing::HasSubstr;

LearnedSegmenter make(SegmentationQuality quality = SegmentationQuality::Standard,
                      IcePolarity ice = IcePolarity::Auto, bool ponds_are_ice = false) {
  return LearnedSegmenter({.ponds_are_ice = ponds_are_ice}, quality, ice);
}

class EveryQuality : public ::testing::TestWithParam<SegmentationQuality> {};
INSTANTIATE_TEST_SUITE_P(LearnedSegmenter, EveryQuality,
                         ::testing::Values(SegmentationQuality::Fast, SegmentationQuality::Standard,
                                           SegmentationQuality::Best));

// Nobody tells it which class is ice: few floes on the sea, or hardly a lead in the ice, bright or
// dark.
TEST_P(EveryQuality, FindsThePolarityOfFloesByItself) {
  cv::RNG rng(1);
  const LearnedSegmenter segmenter = make(GetParam());
  for (const double share : {0.05, 0.1, 0.3, 0.5})
    for (const double contrast : {60.0, -60.0}) {
      const cv::Mat ice = floes(rng, kFrame, share);
      const cv::Mat image = frame(rng, ice, 120.0 - 0.5 * contrast, contrast, 8);
      EXPECT_LT(error(ice_found(segmenter, image), ice), 0.03) << share << " " << contrast;
      const Findings found = segmenter.findings_of(image, {});
      ASSERT_TRUE(found.polarity);
      EXPECT_EQ(found.polarity->polarity,
                contrast > 0 ? IcePolarity::Brighter : IcePolarity::Darker);
    }
}

TEST_P(EveryQuality, ANegativeIsTheSameIce) {
  cv::RNG rng(2);
  const LearnedSegmenter segmenter = make(GetParam());
  for (const double share : {0.1, 0.3, 0.5}) {
    const cv::Mat image = frame(rng, floes(rng, kFrame, share), 90, 60, 8);
    const cv::Mat p = segmenter.segment(image, {}).value();
    const cv::Mat negative = segmenter.segment(255 - image, {}).value();
    EXPECT_LT(cv::mean(cv::abs(p - negative))[0], 0.01) << share;
  }
}

// Half of everything, in patches that no one could tell apart: half is what it says.
TEST(LearnedSegmenter, WhereNothingTellsThePolarityIsUnsure) {
  cv::RNG rng(3);
  cv::Mat field(kFrame, CV_32F);
  rng.fill(field, cv::RNG::NORMAL, 0.0, 1.0);
  cv::GaussianBlur(field, field, {}, 6.0);
  const cv::Mat image = frame(rng, field > 0.0, 90, 60, 8);
  const Findings found = make().findings_of(image, {});
  ASSERT_TRUE(found.polarity);
  EXPECT_LT(found.polarity->confidence, kSureOfPolarity);
  EXPECT_THAT(found.notes.at(0), HasSubstr("not sure"));
  const cv::Mat p = make().segment(image, {}).value();
  double lowest = 0.0, highest = 0.0;
  cv::minMaxLoc(p, &lowest, &highest);
  EXPECT_GE(lowest, 0.99 - found.polarity->confidence);
  EXPECT_LE(highest, found.polarity->confidence + 0.01);
}

TEST(LearnedSegmenter, AFlightDecidesForItsFrames) {
  cv::RNG rng(4);
  LearnedSegmenter flight = make();
  for (int i = 0; i < 5; ++i)
    flight.observe(frame(rng, floes(rng, kFrame, 0.2 + 0.05 * i), 150, -50, 6), {});
  EXPECT_EQ(flight.polarity().polarity, IcePolarity::Darker);
  EXPECT_GT(flight.polarity().confidence, kSureOfPolarity);
  // One floe that fills the frame but for a hole: by itself it would be a floe on water.
  cv::Mat hole(kFrame, CV_8U, cv::Scalar(255));
  cv::circle(hole, {160, 128}, 40, 0, -1);
  EXPECT_LT(error(ice_found(flight, frame(rng, hole, 150, -50, 6)), hole), 0.03);
}

// Rough ice that fills a frame has two levels, too, but not the flight's: it is ice.
TEST(LearnedSegmenter, InAFlightRoughIceIsNotSplit) {
  cv::RNG rng(8);
  LearnedSegmenter flight = make();
  for (int i = 0; i < 5; ++i)
    flight.observe(frame(rng, floes(rng, kFrame, 0.2 + 0.05 * i), 60, 100, 6), {});
  const cv::Mat ridges = floes(rng, kFrame, 0.4);
  const cv::Mat rough = frame(rng, ridges, 140, 30, 6);
  EXPECT_GT(fraction(ice_found(flight, rough)), 0.99);
}

TEST(LearnedSegmenter, ClassesAddUpToOneAndAgreeWithPOfIce) {
  cv::RNG rng(5);
  const cv::Mat image = frame(rng, floes(rng, kFrame, 0.3), 90, 60, 8);
  const cv::Mat classes =
      make(SegmentationQuality::Standard, IcePolarity::Brighter).classify(image, {}).value();
  std::vector<cv::Mat> p;
  cv::split(classes, p);
  EXPECT_LT(cv::norm(p[0] + p[1] + p[2], cv::Mat(kFrame, CV_32F, cv::Scalar(1)), cv::NORM_INF),
            5e-3);
  const cv::Mat without =
      make(SegmentationQuality::Standard, IcePolarity::Brighter).segment(image, {}).value();
  const cv::Mat with =
      make(SegmentationQuality::Standard, IcePolarity::Brighter, true).segment(image, {}).value();
  EXPECT_LT(cv::mean(cv::abs(p[1] - without))[0], 0.01);
  EXPECT_LT(cv::mean(cv::abs(p[0] + p[1] - with))[0], 0.01);
  double least = 0.0;
  cv::minMaxLoc(with - without, &least);
  EXPECT_GT(least, -1e-3) << "ponds only add ice";
}

TEST(LearnedSegmenter, IsWhollySureOfNothing) {
  cv::RNG rng(6);
  const cv::Mat image = frame(rng, floes(rng, kFrame, 0.3), 60, 140, 2);
  const cv::Mat p =
      make(SegmentationQuality::Best, IcePolarity::Brighter).segment(image, {}).value();
  double lowest = 0.0, highest = 0.0;
  cv::minMaxLoc(p, &lowest, &highest);
  EXPECT_GT(lowest, 0.0);
  EXPECT_LT(highest, 1.0);
}

// In colour one class is enough: whiteness has a meaning of its own.
TEST(LearnedSegmenter, ASheetOfColourIsWhatItLooksLike) {
  cv::RNG rng(7);
  const auto sheet = [&](const cv::Scalar& colour) {
    cv::Mat image(kFrame, CV_8UC3, colour), noise(kFrame, CV_16SC3), sum;
    rng.fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
    cv::add(image, noise, sum, cv::noArray(), CV_8U);
    return sum;
  };
  EXPECT_LT(fraction(ice_found(make(), sheet({120, 110, 40}))), 0.02) << "teal water";
  EXPECT_LT(fraction(ice_found(make(), sheet({60, 40, 20}))), 0.02) << "dark blue water";
  EXPECT_GT(fraction(ice_found(make(), sheet({245, 240, 235}))), 0.98) << "snow";
}

}  // namespace
}  // namespace watersky
