// SPDX-License-Identifier: MIT
#include "watersky/map/mosaic.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "watersky/map/detail/test_scene.hpp"

namespace watersky {
namespace {

using test::FlatGrid;

TEST(Mosaic, ColoursLandWhereTheyWereSeen) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  cv::Mat image(120, 160, CV_8UC3, cv::Scalar(10, 20, 30));
  image(cv::Rect(80, 0, 80, 60)).setTo(cv::Scalar(200, 100, 50));  // the north-east quarter
  Mosaic mosaic;
  ASSERT_TRUE(
      mosaic
          .add(test::grid_view(camera, test::pose({0, 0, -40.0}, {0_deg, -90_deg, 0_deg}), grid),
               image)
          .ok());
  const cv::Mat out = mosaic.bgra({0, 0, 260, 170});
  const auto at = [&](double north_m, double east_m) {
    return out.at<cv::Vec4b>(static_cast<int>((37.0 - north_m) / 0.5),
                             static_cast<int>((east_m + 61.0) / 0.5));
  };
  EXPECT_EQ(at(6.0, 8.0), cv::Vec4b(200, 100, 50, 255));
  EXPECT_EQ(at(-6.0, 8.0), cv::Vec4b(10, 20, 30, 255));
  EXPECT_EQ(at(6.0, -8.0), cv::Vec4b(10, 20, 30, 255));
  EXPECT_EQ(at(33.0, 60.0), cv::Vec4b(0, 0, 0, 0));
}

TEST(Mosaic, TheFrameNearestToItsNadirWinsWhateverTheOrder) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  const cv::Mat red(120, 160, CV_8U, cv::Scalar(200)), blue(120, 160, CV_8U, cv::Scalar(50));
  const auto west =
      test::grid_view(camera, test::pose({0, -10, -40.0}, {0_deg, -90_deg, 0_deg}), grid);
  const auto east =
      test::grid_view(camera, test::pose({0, 10, -40.0}, {0_deg, -90_deg, 0_deg}), grid);
  Mosaic one, two;
  ASSERT_TRUE(one.add(west, red).ok() && one.add(east, blue).ok());
  ASSERT_TRUE(two.add(east, blue).ok() && two.add(west, red).ok());
  const cv::Mat a = one.bgra({0, 0, 260, 170}), b = two.bgra({0, 0, 260, 170});
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0.0);
  const int row = static_cast<int>(37.0 / 0.5);
  EXPECT_EQ(a.at<cv::Vec4b>(row, static_cast<int>((61.0 - 3) / 0.5))[0], 200);
  EXPECT_EQ(a.at<cv::Vec4b>(row, static_cast<int>((61.0 + 3) / 0.5))[0], 50);
}

TEST(Mosaic, SixteenBitsAreRefused) {
  const FlatGrid grid;
  Mosaic mosaic;
  EXPECT_FALSE(mosaic
                   .add(test::grid_view(test::pinhole(),
                                        test::pose({0, 0, -40.0}, {0_deg, -90_deg, 0_deg}), grid),
                        cv::Mat(120, 160, CV_16U, cv::Scalar(0)))
                   .ok());
  EXPECT_TRUE(mosaic.empty());
}

}  // namespace
}  // namespace watersky
