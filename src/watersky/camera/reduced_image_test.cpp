// SPDX-License-Identifier: MIT
#include "watersky/camera/reduced_image.hpp"

#include <gtest/gtest.h>

#include "watersky/camera/camera_model.hpp"

namespace watersky {
namespace {

TEST(ReducedImage, HasTheSizeThatTheReducedCameraHas) {
  Eigen::Matrix3d matrix;
  matrix << 500, 0, 30, 0, 500, 20, 0, 0, 1;
  for (const int width : {61, 62, 63, 64, 65})
    for (const int n : {1, 2, 3, 4, 8}) {
      const CameraModel camera =
          CameraModel::make(LensModel::Pinhole, width, 40, matrix).value().reduced_by(n);
      const cv::Mat image = reduced_by(cv::Mat::zeros(40, width, CV_8UC3), n);
      EXPECT_EQ(image.cols, camera.width_px());
      EXPECT_EQ(image.rows, camera.height_px());
      EXPECT_EQ(image.type(), CV_8UC3);
    }
}

TEST(ReducedImage, IsTheMeanOfWholeBlocksAndTheEdgeFillsTheLast) {
  const cv::Mat image = (cv::Mat_<float>(2, 3) << 1, 3, 10, 5, 7, 20);
  const cv::Mat half = reduced_by(image, 2);
  ASSERT_EQ(half.size(), cv::Size(2, 1));
  EXPECT_FLOAT_EQ(half.at<float>(0, 0), 4.0F);
  EXPECT_FLOAT_EQ(half.at<float>(0, 1), 15.0F);
  // Whoever draws into what he was given does not draw into the original.
  reduced_by(image, 1).setTo(0);
  EXPECT_FLOAT_EQ(image.at<float>(1, 2), 20.0F);
}

}  // namespace
}  // namespace watersky
