// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "study.hpp"
#include "watersky/align/metadata_check.hpp"

namespace watersky::study {
namespace {

constexpr int kWidth = 803, kHeight = 601;

CameraModel camera() {
  Eigen::Matrix3d matrix;
  matrix << 700, 0, 401, 0, 700, 300, 0, 0, 1;
  return CameraModel::make(LensModel::Pinhole, kWidth, kHeight, matrix).value();
}

ImageFrame frame_of(const cv::Mat& image) {
  ImageFrame frame;
  frame.load = [image](const ImageRequest&) -> Result<cv::Mat> { return image.clone(); };
  return frame;
}

/// Blobs of all sizes.
cv::Mat scene(int width, int height) {
  cv::Mat noise(height, width, CV_8U), fine, coarse;
  cv::theRNG().state = 7;
  cv::randu(noise, 0, 255);
  cv::GaussianBlur(noise, fine, {}, 3.0);
  cv::GaussianBlur(noise, coarse, {}, 9.0);
  cv::Mat out = 0.5 * fine + 0.5 * coarse;
  cv::normalize(out, out, 0, 255, cv::NORM_MINMAX);
  return out;
}

TEST(Checkerboard, ItsTilesAreTheWholeAndBlackOnesAreNotWhite) {
  const Checkerboard board{.image = {kWidth, kHeight}};
  const cv::Mat white = board.white();
  int black_px = 0;
  for (const cv::Rect& tile : board.black(0)) {
    EXPECT_EQ(cv::countNonZero(white(tile)), 0);
    black_px += tile.area();
  }
  EXPECT_EQ(board.black(0).size(), 24u);
  EXPECT_EQ(black_px + cv::countNonZero(white), kWidth * kHeight);
  for (const cv::Rect& tile : board.black(20)) {
    const cv::Rect around(tile.x - 20, tile.y - 20, tile.width + 40, tile.height + 40);
    EXPECT_EQ(cv::countNonZero(white(around)), 0);
  }
}

TEST(Ties, AreWhereThePicturesShowTheSameAndOnlyInBlackTiles) {
  const cv::Mat sea = scene(kWidth + 100, kHeight + 100);
  // A whole tile to the right and one down: black falls on black.
  const Checkerboard board{.image = {kWidth, kHeight}};
  const cv::Mat a = sea(cv::Rect(0, 0, kWidth, kHeight)),
                b = sea(cv::Rect(100, 100, kWidth, kHeight));
  const auto tiles = board.black(10);
  const Keypoints in_a = find_keypoints(frame_of(a), tiles, 1, 100).value(),
                  in_b = find_keypoints(frame_of(b), tiles, 1, 100).value();
  const std::vector<PixelTie> ties = match(in_a, in_b, camera());
  ASSERT_GT(ties.size(), 100u);
  const cv::Mat white = board.white();
  for (const PixelTie& t : ties) {
    EXPECT_NEAR(t.a.x - 100, t.b.x, 1.0);
    EXPECT_NEAR(t.a.y - 100, t.b.y, 1.0);
    EXPECT_EQ(white.at<uchar>(cv::Point(t.a)), 0);
    EXPECT_EQ(white.at<uchar>(cv::Point(t.b)), 0);
  }
}

TEST(Ties, PicturesOfDifferentPlacesHaveNone) {
  const cv::Mat sea = scene(2 * kWidth, kHeight);
  const auto tiles = Checkerboard{.image = {kWidth, kHeight}}.black(10);
  const Keypoints a =
      find_keypoints(frame_of(sea(cv::Rect(0, 0, kWidth, kHeight))), tiles, 1, 100).value();
  const Keypoints b =
      find_keypoints(frame_of(sea(cv::Rect(kWidth, 0, kWidth, kHeight))), tiles, 1, 100).value();
  EXPECT_TRUE(match(a, b, camera()).empty());
}

TEST(Ties, KeypointsOfAReducedPictureAreFullSizePixels) {
  cv::Mat image(kHeight, kWidth, CV_8U, cv::Scalar(30));
  const cv::Point2d at(150.0, 40.0);  // in a black tile
  cv::circle(image, at, 8, cv::Scalar(220), cv::FILLED);
  cv::GaussianBlur(image, image, {}, 2.0);
  const auto tiles = Checkerboard{.image = {kWidth, kHeight}}.black(0);
  for (const int reduction : {1, 2, 4}) {
    const Keypoints found = find_keypoints(frame_of(image), tiles, reduction, 1).value();
    ASSERT_FALSE(found.px.empty());
    // SIFT itself puts a place a quarter of its pixel off.
    EXPECT_LT(cv::norm(found.px[0] - at), 0.5 + 0.4 * reduction) << reduction;
  }
}

// By a loader that stores each photograph turned, which is what mending undoes.
TEST(StoredPixels, AreWhereThePhotographHasThem) {
  for (const int turns : {0, 1, 2, 3}) {
    const bool upright = turns % 2 == 0;
    cv::Mat seen(kHeight, kWidth, CV_8U, cv::Scalar(0)), stored;
    const cv::Point at(200, 77);
    seen.at<uchar>(at) = 255;
    if (turns == 0) stored = seen;
    if (turns == 1) cv::rotate(seen, stored, cv::ROTATE_90_CLOCKWISE);
    if (turns == 2) cv::rotate(seen, stored, cv::ROTATE_180);
    if (turns == 3) cv::rotate(seen, stored, cv::ROTATE_90_COUNTERCLOCKWISE);
    // The camera as it was recorded has the size of what is stored.
    Eigen::Matrix3d matrix;
    matrix << 700, 0, 300, 0, 700, 300, 0, 0, 1;
    Flight recorded(
        "test", Datum({Angle::degrees(78), Angle::degrees(15), 0.0}, {}),
        CameraModel::make(LensModel::Pinhole, stored.cols, stored.rows, matrix).value());
    recorded.frames = {frame_of(stored)};
    const auto mend = [&](Flight flight) -> Result<Flight> {
      for (ImageFrame& frame : flight.frames)
        frame.load = turned_back(frame.load, turns, kWidth, kHeight);
      if (!upright) flight.camera = camera();
      return flight;
    };
    const std::vector<StoredPixels> pixels = stored_pixels(recorded, mend).value();
    ASSERT_EQ(pixels.size(), 1u);
    const Pixel p = pixels[0](cv::Point2d(at));
    EXPECT_EQ(
        stored.at<uchar>(static_cast<int>(std::lround(p.v)), static_cast<int>(std::lround(p.u))),
        255)
        << turns;
  }
}

}  // namespace
}  // namespace watersky::study
