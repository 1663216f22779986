// SPDX-License-Identifier: MIT
#include "watersky/vision/watershed.hpp"

#include <gtest/gtest.h>

#include "watersky/vision/detail/test_frames.hpp"
#include "watersky/vision/detail/test_reference.hpp"

namespace watersky {
namespace {

using namespace test;

// tests/reference/local_otsu.py, scikit-image 0.19.3.
TEST(Watershed, FloodsAsScikitImageDoes) {
  const cv::Mat relief = reference("relief");
  cv::Mat markers;
  reference("marker").convertTo(markers, CV_32S);
  flood_from_markers(relief, {}, markers);
  cv::Mat flooded;
  markers.convertTo(flooded, CV_8U);
  EXPECT_EQ(cv::countNonZero(flooded != reference("flooded")), 0);
}

// The ridge at column 5 parts the floods wherever the markers stand.
TEST(Watershed, BordersLieOnTheRidge) {
  cv::Mat relief(8, 11, CV_8U, cv::Scalar(10)), markers(8, 11, CV_32S, cv::Scalar(0));
  relief.col(5).setTo(200);
  markers.at<int>(7, 0) = 1;
  markers.at<int>(0, 6) = 2;
  flood_from_markers(relief, {}, markers);
  EXPECT_EQ(cv::countNonZero(markers.colRange(0, 5) == 1), 5 * 8);
  EXPECT_EQ(cv::countNonZero(markers.colRange(6, 11) == 2), 5 * 8);
}

TEST(Watershed, DoesNotFloodWhatIsNotValid) {
  cv::Mat relief(6, 9, CV_8U, cv::Scalar(0)), valid(6, 9, CV_8U, cv::Scalar(255));
  valid.col(4).setTo(0);
  cv::Mat markers(6, 9, CV_32S, cv::Scalar(0));
  markers.at<int>(2, 1) = 7;
  markers.at<int>(3, 4) = 9;  // on what is not valid
  flood_from_markers(relief, valid, markers);
  EXPECT_EQ(cv::countNonZero(markers.colRange(0, 4) == 7), 4 * 6);
  EXPECT_EQ(cv::countNonZero(markers.colRange(4, 9)), 0);
}

// Single bright pixels on water are noise to a watershed: no flood starts from a slope.
TEST(Watershed, LeavesNoiseOutOfTheIce) {
  cv::RNG rng(3);
  const cv::Mat ice = floes(rng, kFrame, 0.3);
  const cv::Mat image = frame(rng, ice, 90, 32, 8);
  const WatershedSegmenter segmenter({}, {}, IcePolarity::Brighter);
  EXPECT_LT(error(ice_found(segmenter, image), ice), 0.015);
}

}  // namespace
}  // namespace watersky
