// SPDX-License-Identifier: MIT
#include "watersky/vision/polarity.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/vision/otsu.hpp"

#include "support/real_data.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;

const cv::Size kFrame{400, 320};

/// Convex polygons that do not touch: small ones in open water.
cv::Mat open_floes(cv::RNG& rng, double fraction) {
  cv::Mat ice(kFrame, CV_8U, cv::Scalar(0));
  while (cv::countNonZero(ice) < fraction * static_cast<double>(ice.total())) {
    const cv::Point centre(rng.uniform(0, kFrame.width), rng.uniform(0, kFrame.height));
    const int radius = rng.uniform(6, 40);
    std::vector<cv::Point> corners;
    for (int i = 0; i < 9; ++i)
      corners.emplace_back(centre.x + rng.uniform(-radius, radius),
                           centre.y + rng.uniform(-radius, radius));
    std::vector<cv::Point> hull;
    cv::convexHull(corners, hull);
    cv::Mat floe(kFrame, CV_8U, cv::Scalar(0)), wider;
    cv::fillConvexPoly(floe, hull, 255);
    cv::dilate(floe, wider, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
    if (cv::countNonZero(wider & ice) == 0) ice |= floe;
  }
  return ice;
}

/// Pack ice: the Voronoi cells of random points, leads between them.
cv::Mat pack(cv::RNG& rng, int cells, int lead_px) {
  cv::Mat seeds(kFrame, CV_8U, cv::Scalar(255));
  for (int i = 0; i < cells; ++i)
    seeds.at<unsigned char>(rng.uniform(0, kFrame.height), rng.uniform(0, kFrame.width)) = 0;
  cv::Mat distance, labels, ice;
  cv::distanceTransform(seeds, distance, labels, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  labels.convertTo(labels, CV_32F);
  cv::Mat highest, lowest;
  const cv::Mat lead = cv::getStructuringElement(cv::MORPH_ELLIPSE, {lead_px, lead_px});
  cv::dilate(labels, highest, lead);
  cv::erode(labels, lowest, lead);
  return highest == lowest;
}

cv::Mat frame(cv::RNG& rng, const cv::Mat& ice, bool ice_bright) {
  cv::Mat image(ice.size(), CV_32F, cv::Scalar(ice_bright ? 100 : 132)), noise(ice.size(), CV_32F);
  image.setTo(ice_bright ? 132 : 100, ice);
  rng.fill(noise, cv::RNG::NORMAL, 0, 8);  // contrast 4 sigma
  cv::Mat(image + noise).convertTo(image, CV_8U);
  return image;
}

fs::path data_folder() { return test::real_data(".").value_or("no data"); }

TEST(ShapeEvidence, SolidityOfKnownShapes) {
  cv::Mat mask(100, 100, CV_8U, cv::Scalar(0));
  cv::rectangle(mask, {10, 20, 30, 50}, 255, cv::FILLED);
  EXPECT_DOUBLE_EQ(shape_evidence(mask, {}).bright_solidity, 1.0);
  EXPECT_DOUBLE_EQ(shape_evidence(mask, {}).bright_fraction, 0.15);
  EXPECT_DOUBLE_EQ(shape_evidence(mask, {}).dark_solidity, 0.85);  // its hull is the image

  // An L of 40 x 40 less 30 x 30: 700 of a hull of 1600 - 30 * 30 / 2 = 1150.
  cv::Mat corner(100, 100, CV_8U, cv::Scalar(0));
  cv::rectangle(corner, {30, 30, 40, 40}, 255, cv::FILLED);
  cv::rectangle(corner, {40, 30, 30, 30}, 0, cv::FILLED);
  EXPECT_NEAR(shape_evidence(corner, {}).bright_solidity, 700.0 / 1150.0, 1e-12);
}

TEST(ShapeEvidence, SolidityAgreesWithOpenCvsHulls) {
  cv::RNG rng(1);
  for (int i = 0; i < 20; ++i) {
    cv::Mat mask(80, 120, CV_8U, cv::Scalar(0));
    for (int k = 0; k < 6; ++k)
      cv::line(mask, {rng.uniform(0, 120), rng.uniform(0, 80)},
               {rng.uniform(0, 120), rng.uniform(0, 80)}, 255, rng.uniform(1, 12), cv::LINE_4);
    cv::Mat labels, stats, centroids;
    const int n = cv::connectedComponentsWithStats(mask, labels, stats, centroids, 4);
    double weighted = 0, area = 0;
    for (int k = 1; k < n; ++k) {
      std::vector<cv::Point> pixels, corners, hull;
      cv::findNonZero(labels == k, pixels);
      if (pixels.size() < 8) continue;
      for (const auto& p : pixels)
        for (const cv::Point d :
             {cv::Point(0, 0), cv::Point(1, 0), cv::Point(0, 1), cv::Point(1, 1)})
          corners.push_back(p + d);
      cv::convexHull(corners, hull);
      const auto a = static_cast<double>(pixels.size());
      weighted += a * a / cv::contourArea(hull);
      area += a;
    }
    EXPECT_NEAR(shape_evidence(mask, {}).bright_solidity, weighted / area, 1e-12);
  }
}

TEST(ShapeEvidence, ChangesSignWithTheMask) {
  cv::RNG rng(2);
  for (int i = 0; i < 20; ++i) {
    const cv::Mat ice = open_floes(rng, rng.uniform(0.05, 0.3));
    EXPECT_DOUBLE_EQ(shape_evidence(ice, {}).score, -shape_evidence(~ice, {}).score);
    EXPECT_GT(shape_evidence(ice, {}).score, 0.0);
  }
}

TEST(ShapeEvidence, NothingShownSaysNothing) {
  const cv::Mat none(50, 50, CV_8U, cv::Scalar(0));
  EXPECT_EQ(shape_evidence(none, none).score, 0.0);
}

TEST(Polarity, FoundFromFloesInOpenWater) {
  cv::RNG rng(3);
  for (const bool bright : {true, false}) {
    OtsuSegmenter flight;
    int right = 0;
    for (int i = 0; i < 12; ++i) {
      const cv::Mat image = frame(rng, open_floes(rng, 0.05 + 0.03 * i), bright);
      flight.observe(image, {});
      right +=
          (OtsuSegmenter().polarity_of(image, {})->polarity == IcePolarity::Brighter) == bright;
    }
    EXPECT_GE(right, 11);
    EXPECT_EQ(flight.polarity().polarity, bright ? IcePolarity::Brighter : IcePolarity::Darker);
    EXPECT_GT(flight.polarity().confidence, kSureOfPolarity) << flight.polarity().evidence;
  }
}

TEST(Polarity, FoundFromLeadsInPackIce) {
  cv::RNG rng(4);
  for (const bool bright : {true, false}) {
    OtsuSegmenter flight;
    int right = 0;
    for (int i = 0; i < 12; ++i) {
      const cv::Mat image = frame(rng, pack(rng, 20 + 8 * i, 7), bright);
      flight.observe(image, {});
      right +=
          (OtsuSegmenter().polarity_of(image, {})->polarity == IcePolarity::Brighter) == bright;
    }
    EXPECT_GE(right, 11);
    EXPECT_EQ(flight.polarity().polarity, bright ? IcePolarity::Brighter : IcePolarity::Darker);
    EXPECT_GT(flight.polarity().confidence, kSureOfPolarity) << flight.polarity().evidence;
  }
}

TEST(Polarity, OneFrameIsNeverEnoughToBeSure) {
  EXPECT_LT(estimate_polarity({0.3}, 1, false).confidence, kSureOfPolarity);
  EXPECT_GT(estimate_polarity({0.3, 0.3, 0.3}, 3, false).confidence, kSureOfPolarity);
}

TEST(Polarity, ContradictingFramesAreNotSure) {
  EXPECT_LT(estimate_polarity({0.3, -0.3, 0.2, -0.25, 0.1}, 5, false).confidence, kSureOfPolarity);
  EXPECT_EQ(estimate_polarity({}, 9, false).confidence, 0.5);
}

TEST(Polarity, ColourSaysBrighterAndGrayInThreeChannelsSaysNothing) {
  cv::RNG rng(5);
  cv::Mat gray = frame(rng, cv::Mat::zeros(kFrame, CV_8U), true), three, teal;
  cv::cvtColor(gray, three, cv::COLOR_GRAY2BGR);
  cv::multiply(three, cv::Scalar(1.0, 1.0, 0.5), teal);
  OtsuSegmenter segmenter;
  EXPECT_GT(segmenter.polarity_of(teal, {})->confidence, kSureOfPolarity);
  EXPECT_EQ(segmenter.polarity_of(three, {})->confidence, 0.5);
}

TEST(Polarity, GivenIsCertain) {
  const auto given = OtsuSegmenter({}, IcePolarity::Darker).polarity();
  EXPECT_EQ(given.polarity, IcePolarity::Darker);
  EXPECT_EQ(given.confidence, 1.0);
}

// Fram Strait 2022: ice is darker but in train_08 and train_09 (data/README.md).
TEST(Polarity, FoundInRealThermalImages) {
  const fs::path folder = data_folder() / "tir_sea_ice/images";
  if (!fs::exists(folder)) GTEST_SKIP() << "no " << folder;
  OtsuSegmenter darker, brighter;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto stem = entry.path().stem().string();
    const bool bright = stem == "train_08" || stem == "train_09";
    const cv::Mat image = cv::imread(entry.path().string(), cv::IMREAD_UNCHANGED);
    ASSERT_FALSE(image.empty()) << entry.path();
    (bright ? brighter : darker).observe(image, {});
  }
  EXPECT_EQ(darker.polarity().polarity, IcePolarity::Darker) << darker.polarity().evidence;
  EXPECT_GT(darker.polarity().confidence, kSureOfPolarity);
  EXPECT_EQ(brighter.polarity().polarity, IcePolarity::Brighter) << brighter.polarity().evidence;
}

TEST(Polarity, FoundInRealPackIceInGray) {
  const fs::path folder = data_folder() / "hotrax_pack_ice/images";
  if (!fs::exists(folder)) GTEST_SKIP() << "no " << folder;
  OtsuSegmenter flight;
  for (const auto& entry : fs::directory_iterator(folder))
    flight.observe(cv::imread(entry.path().string(), cv::IMREAD_REDUCED_GRAYSCALE_4), {});
  EXPECT_EQ(flight.polarity().polarity, IcePolarity::Brighter) << flight.polarity().evidence;
  EXPECT_GT(flight.polarity().confidence, kSureOfPolarity);
}

}  // namespace
}  // namespace watersky
