// SPDX-License-Identifier: MIT
#include "watersky/vision/opencl.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/vision/detail/test_frames.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky {
namespace {

/// On while it lives, where there is a device.
struct WithOpenCl {
  const Status on = use_opencl(true);
  ~WithOpenCl() { (void)use_opencl(false); }
};

bool there_is_a_device() { return WithOpenCl().on.ok(); }

cv::Mat noise() {
  cv::RNG rng(7);
  cv::Mat level(121, 163, CV_32F);
  rng.fill(level, cv::RNG::UNIFORM, -1.0, 2.0);
  return level;
}

TEST(OpenCl, IsOffUntilAskedFor) {
  EXPECT_FALSE(uses_opencl());
  {
    const WithOpenCl with;
    EXPECT_EQ(uses_opencl(), with.on.ok());
    EXPECT_EQ(cv::ocl::useOpenCL(), with.on.ok()) << "in OpenCV as well";
  }
  EXPECT_FALSE(uses_opencl());
  EXPECT_FALSE(cv::ocl::useOpenCL());
}

TEST(SmoothAndDerive, IsOpenCvsBlurAndSobel) {
  cv::Mat level = noise(), expected, dx, dy, expected_dx, expected_dy;
  cv::GaussianBlur(level, expected, {}, 1.2, 1.2, cv::BORDER_REFLECT);
  cv::Sobel(expected, expected_dx, CV_32F, 1, 0, 3, 0.125, 0, cv::BORDER_REFLECT);
  cv::Sobel(expected, expected_dy, CV_32F, 0, 1, 3, 0.125, 0, cv::BORDER_REFLECT);
  smooth_and_derive(level, 1.2, 0.125, dx, dy);
  EXPECT_EQ(cv::norm(level, expected, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(dx, expected_dx, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(dy, expected_dy, cv::NORM_INF), 0.0);
}

TEST(SmoothAndDerive, OnADeviceAgreesToTheLastBits) {
  if (!there_is_a_device()) GTEST_SKIP() << "no OpenCL device; pocl-opencl-icd is one";
  cv::Mat here = noise(), there = here.clone(), dx, dy, device_dx, device_dy;
  smooth_and_derive(here, 1.2, 0.125, dx, dy);
  const WithOpenCl on;
  smooth_and_derive(there, 1.2, 0.125, device_dx, device_dy);
  EXPECT_LT(cv::norm(here, there, cv::NORM_INF), 1e-5);
  EXPECT_LT(cv::norm(dx, device_dx, cv::NORM_INF), 1e-5);
  EXPECT_LT(cv::norm(dy, device_dy, cv::NORM_INF), 1e-5);
}

// A pixel on the fence may fall to the other side; no more than one in ten thousand does.
TEST(SmoothAndDerive, OnADeviceSegmentsAlike) {
  if (!there_is_a_device()) GTEST_SKIP() << "no OpenCL device; pocl-opencl-icd is one";
  cv::RNG rng(5);
  const cv::Mat image = test::frame(rng, test::floes(rng, {320, 256}, 0.3), 90, 60, 5);
  for (const SegmentationMethod method :
       {SegmentationMethod::Edges, SegmentationMethod::Watershed}) {
    const auto segmenter = make_segmenter(method, {}, IcePolarity::Brighter).value();
    const cv::Mat here = segmenter->segment(image, {}).value() > 0.5;
    const WithOpenCl on;
    const cv::Mat there = segmenter->segment(image, {}).value() > 0.5;
    EXPECT_GT(cv::countNonZero(here), 0) << name_of(method);
    EXPECT_LE(cv::countNonZero(here != there), static_cast<int>(image.total() / 10000))
        << name_of(method);
  }
}

}  // namespace
}  // namespace watersky
