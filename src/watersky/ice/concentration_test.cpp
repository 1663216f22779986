// SPDX-License-Identifier: MIT
#include "watersky/ice/concentration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "watersky/ice/size_class.hpp"

namespace watersky::ice {
namespace {

const float kUnseen = std::nanf("");

TEST(Concentration, WhatWasNotSeenIsNeitherIceNorWater) {
  const cv::Mat p = (cv::Mat_<float>(2, 3) << 0.9F, 0.1F, kUnseen, 0.6F, kUnseen, kUnseen);
  const Concentration c = concentration(p, 2.0);
  EXPECT_EQ(c.seen_cells, 3u);
  EXPECT_DOUBLE_EQ(c.seen_area_m2, 12.0);
  EXPECT_NEAR(c.expected, (0.9 + 0.1 + 0.6) / 3, 1e-7);
  EXPECT_NEAR(c.thresholded, 2.0 / 3, 1e-12);
  EXPECT_NEAR(concentration(p, 2.0, 0.7).thresholded, 1.0 / 3, 1e-12);
}

TEST(Concentration, NothingSeenHasNoConcentration) {
  EXPECT_TRUE(std::isnan(concentration(cv::Mat(3, 3, CV_32F, cv::Scalar(kUnseen)), 1.0).expected));
  EXPECT_TRUE(std::isnan(concentration({}, 1.0).thresholded));
}

TEST(Concentration, BlocksNeedEnoughOfTheirCellsSeen) {
  const cv::Mat p = (cv::Mat_<float>(2, 5) << 1, 0, kUnseen, kUnseen, 0.5F,  //
                     1, 0, kUnseen, 0.8F, 0.7F);
  const cv::Mat b = concentration_blocks(p, 2);
  ASSERT_EQ(b.size(), cv::Size(3, 1));
  EXPECT_FLOAT_EQ(b.at<float>(0, 0), 0.5F);
  EXPECT_TRUE(std::isnan(b.at<float>(0, 1)));  // one of four
  EXPECT_FLOAT_EQ(b.at<float>(0, 2), 0.6F);    // a cut block counts the cells it has
  EXPECT_FLOAT_EQ(concentration_blocks(p, 2, 0.25).at<float>(0, 1), 0.8F);
}

TEST(SizeClass, WordsChangeWhereTheConventionsSay) {
  EXPECT_EQ(iceberg_size_class(4.99), "growler");
  EXPECT_EQ(iceberg_size_class(5.0), "bergy bit");
  EXPECT_EQ(iceberg_size_class(15.0), "small iceberg");
  EXPECT_EQ(iceberg_size_class(61.0), "medium iceberg");
  EXPECT_EQ(iceberg_size_class(121.0), "large iceberg");
  EXPECT_EQ(iceberg_size_class(200.1), "very large iceberg");
  EXPECT_EQ(floe_size_class(1.9), "small ice cake");
  EXPECT_EQ(floe_size_class(19.9), "ice cake");
  EXPECT_EQ(floe_size_class(99.0), "small floe");
  EXPECT_EQ(floe_size_class(499.0), "medium floe");
  EXPECT_EQ(floe_size_class(1999.0), "big floe");
  EXPECT_EQ(floe_size_class(9999.0), "vast floe");
  EXPECT_EQ(floe_size_class(10001.0), "giant floe");
}

}  // namespace
}  // namespace watersky::ice
