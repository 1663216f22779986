// SPDX-License-Identifier: MIT
#include "watersky/vision/mask.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace watersky {
namespace {

TEST(Mask, IsZeroWhereThePictureIsNotToBeUsed) {
  cv::Mat mask(40, 60, CV_8UC3, cv::Scalar(0, 0, 7));
  mask(cv::Rect(0, 30, 60, 10)) = cv::Scalar::all(0);
  const cv::Mat valid = valid_from_mask(mask, {60, 40}).value();
  EXPECT_EQ(valid.type(), CV_8UC1);
  EXPECT_EQ(cv::countNonZero(valid), 60 * 30);
  EXPECT_EQ(valid.at<uchar>(29, 5), 255);
  EXPECT_EQ(valid.at<uchar>(30, 5), 0);
}

TEST(Mask, OfAReducedImageLeavesOutWhatItTouches) {
  for (const int reduction : {2, 4, 8}) {
    cv::Mat mask(450, 610, CV_16U, cv::Scalar(65535));
    mask.at<ushort>(217, 333) = 0;
    mask.at<ushort>(0, 0) = 0;
    mask.at<ushort>(449, 609) = 0;
    const cv::Size size((610 + reduction - 1) / reduction, (450 + reduction - 1) / reduction);
    const cv::Mat valid = valid_from_mask(mask, size).value();
    ASSERT_EQ(valid.size(), size);
    EXPECT_EQ(valid.at<uchar>(217 / reduction, 333 / reduction), 0);
    EXPECT_EQ(valid.at<uchar>(0, 0), 0);
    EXPECT_EQ(valid.at<uchar>(449 / reduction, 609 / reduction), 0);
    EXPECT_EQ(cv::countNonZero(valid), size.area() - 3);
  }
}

TEST(Mask, RefusesWhatCannotBeMeant) {
  const cv::Mat mask(400, 600, CV_8U, cv::Scalar(1));
  EXPECT_THAT(valid_from_mask(mask, {600, 300}).error().message,
              testing::HasSubstr("600x400 pixels, the images are 600x300"));
  EXPECT_FALSE(valid_from_mask(mask, {1200, 800}).ok());
  EXPECT_FALSE(valid_from_mask(cv::Mat(), {600, 400}).ok());
  EXPECT_THAT(valid_from_mask(cv::Mat::zeros(400, 600, CV_8U), {600, 400}).error().message,
              testing::HasSubstr("leaves nothing"));
}

TEST(Mask, OfTwoIsValidInBoth) {
  cv::Mat a(4, 4, CV_8U, cv::Scalar(255)), b = a.clone();
  a.row(0) = 0;
  b.col(0) = 0;
  EXPECT_EQ(cv::countNonZero(both_valid(a, b)), 9);
  EXPECT_EQ(both_valid(cv::Mat(), b).data, b.data);
  EXPECT_EQ(both_valid(a, cv::Mat()).data, a.data);
}

}  // namespace
}  // namespace watersky
