// SPDX-License-Identifier: MIT
#include "watersky/vision/local_otsu.hpp"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>

#include "watersky/vision/detail/test_frames.hpp"
#include "watersky/vision/detail/test_reference.hpp"
#include "watersky/vision/otsu.hpp"

namespace watersky {
namespace {

using namespace test;

/// Levels of the window around a pixel, counted one by one.
std::array<std::uint32_t, 256> window_levels(const cv::Mat& gray, const cv::Mat& valid,
                                             cv::Point at, const LocalWindow& window) {
  std::array<std::uint32_t, 256> counts{};
  for (int y = 0; y < gray.rows; ++y)
    for (int x = 0; x < gray.cols; ++x) {
      const int dx = x - at.x, dy = y - at.y, r = window.radius_px;
      const bool inside =
          window.square ? std::max(std::abs(dx), std::abs(dy)) <= r : dx * dx + dy * dy <= r * r;
      if (inside && (valid.empty() || valid.at<unsigned char>(y, x)))
        ++counts[gray.at<unsigned char>(y, x)];
    }
  return counts;
}

/// Between-class variance of the split above `level`, times the number of pixels squared.
double between(const std::array<std::uint32_t, 256>& counts, int level) {
  double n[2] = {}, sum[2] = {};
  for (int i = 0; i < 256; ++i) {
    n[i > level] += counts[static_cast<std::size_t>(i)];
    sum[i > level] += i * static_cast<double>(counts[static_cast<std::size_t>(i)]);
  }
  if (n[0] == 0.0 || n[1] == 0.0) return 0.0;
  return n[0] * n[1] * std::pow(sum[0] / n[0] - sum[1] / n[1], 2);
}

// tests/reference/local_otsu.py, scikit-image 0.19.3.
TEST(LocalOtsu, IsScikitImagesRankOtsu) {
  const cv::Mat image = reference("level");
  ASSERT_EQ(image.size(), cv::Size(44, 36));
  const cv::Mat mask = reference("valid");
  struct Case {
    const char* column;
    LocalWindow window;
    cv::Mat valid;
  };
  for (const Case& c : {Case{"disk", {6, false}, {}}, Case{"square", {6, true}, {}},
                        Case{"masked", {6, false}, mask}}) {
    const cv::Mat theirs = reference(c.column);
    const cv::Mat ours = local_otsu_thresholds(image, c.valid, c.window).level;
    int equal = 0;
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) {
        const int a = ours.at<unsigned char>(y, x), b = theirs.at<unsigned char>(y, x);
        equal += a == b;
        // Another name for the same split, or one that is as good to rounding.
        const auto counts = window_levels(image, c.valid, {x, y}, c.window);
        std::uint32_t between = 0;
        for (int level = std::min(a, b) + 1; level <= std::max(a, b); ++level)
          between += counts[static_cast<std::size_t>(level)];
        EXPECT_EQ(between, 0u) << c.column << " " << x << "," << y << ": " << a << " and " << b;
      }
    EXPECT_GT(equal, 0.95 * static_cast<double>(image.total())) << c.column;
  }
}

TEST(LocalOtsu, IsOtsuOfEachWindow) {
  cv::RNG rng(1);
  for (int i = 0; i < 30; ++i) {
    cv::Mat gray(rng.uniform(1, 40), rng.uniform(1, 40), CV_8U), valid;
    rng.fill(gray, cv::RNG::UNIFORM, 0, rng.uniform(1, 256));
    if (i % 3 == 0) {
      valid.create(gray.size(), CV_8U);
      rng.fill(valid, cv::RNG::UNIFORM, 0, 2);
    }
    const LocalWindow window{rng.uniform(0, 50), i % 2 == 0};
    const int stride = rng.uniform(1, 5);
    const auto local = local_otsu_thresholds(gray, valid, window, stride);
    ASSERT_EQ(local.level.size(),
              cv::Size((gray.cols + stride - 1) / stride, (gray.rows + stride - 1) / stride));
    for (int row = 0; row < local.level.rows; ++row)
      for (int col = 0; col < local.level.cols; ++col) {
        const auto counts = window_levels(gray, valid, {col * stride, row * stride}, window);
        const OtsuThreshold otsu = otsu_threshold(counts);
        const int level = local.level.at<unsigned char>(row, col);
        if (level == otsu.level) {
          EXPECT_NEAR(local.contrast.at<float>(row, col),
                      otsu.separability > 0.0 ? otsu.bright_mean - otsu.dark_mean : 0.0, 1e-3);
        } else {  // two maxima, equal to rounding
          EXPECT_NEAR(between(counts, level) / between(counts, otsu.level), 1.0, 1e-12);
        }
      }
  }
}

// Water at the right edge is as bright as ice at the left: no one threshold tells them apart.
TEST(LocalOtsu, SeesThroughShadingThatOneThresholdCannot) {
  cv::RNG rng(2);
  const cv::Mat ice = floes(rng, {480, 360}, 0.4, 40);
  cv::Mat shaded = frame(rng, ice, 60, 45, 5, CV_16U);
  for (int x = 0; x < shaded.cols; ++x) shaded.col(x) += 60.0 * x / shaded.cols;
  cv::Mat image;
  shaded.convertTo(image, CV_8U);
  const LocalOtsuSegmenter local({}, {}, IcePolarity::Brighter);
  const OtsuSegmenter global({}, IcePolarity::Brighter);
  EXPECT_LT(error(ice_found(local, image), ice), 0.03);
  EXPECT_GT(error(image > otsu_threshold(image)->level, ice), 0.1)
      << "one threshold should have failed here, or this test shows nothing";
}

TEST(LocalOtsu, WindowsOfOneClassAreNotCutInHalf) {
  cv::RNG rng(3);
  cv::Mat ice(300, 400, CV_8U, cv::Scalar(0));
  ice.colRange(250, 400).setTo(255);
  const cv::Mat image = frame(rng, ice, 90, 60, 8);
  const LocalOtsuSegmenter segmenter({.radius_px = 20, .stride_px = 1}, {}, IcePolarity::Brighter);
  EXPECT_LT(error(ice_found(segmenter, image), ice), 0.003);
  const cv::Mat levels = local_otsu_thresholds(image, {}, {20, false}).level;
  EXPECT_GT(error(image > levels, ice), 0.2)
      << "the windows' own thresholds should have failed here, or this test shows nothing";
}

TEST(LocalOtsu, StridesChangeLittle) {
  cv::RNG rng(4);
  const cv::Mat ice = floes(rng, kFrame, 0.3);
  const cv::Mat image = frame(rng, ice, 90, 50, 8);
  const auto found = [&](int stride) {
    return ice_found(
        LocalOtsuSegmenter({.radius_px = 40, .stride_px = stride}, {}, IcePolarity::Brighter),
        image);
  };
  EXPECT_LT(error(found(8), found(1)), 0.01);
}

}  // namespace
}  // namespace watersky
