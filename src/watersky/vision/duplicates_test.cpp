// SPDX-License-Identifier: MIT
#include "watersky/vision/duplicates.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "support/temporary_folder.hpp"

namespace watersky {
namespace {

const cv::Size kSize(640, 512);

/// A sea of floes seen from above, twice as large as a frame each way, 8 bit levels in float.
/// `texture` is one sigma of the ice's own brightness at some 3 px.
cv::Mat floes(std::uint64_t seed, float contrast, float texture) {
  cv::RNG rng(seed);
  cv::Mat sea(2 * kSize.height, 3 * kSize.width, CV_32F, cv::Scalar(100.0));
  for (int i = 0; i < 60; ++i)
    cv::circle(sea, {rng.uniform(0, sea.cols), rng.uniform(0, sea.rows)}, rng.uniform(5, 60),
               cv::Scalar(100.0 + contrast * rng.uniform(0.7F, 1.3F)), cv::FILLED, cv::LINE_8);
  cv::GaussianBlur(sea, sea, {}, 0.8);
  cv::Mat detail(sea.size(), CV_32F);
  rng.fill(detail, cv::RNG::NORMAL, 0.0, 1.0);
  cv::GaussianBlur(detail, detail, {}, 3.0);
  cv::Scalar mean, deviation;
  cv::meanStdDev(detail, mean, deviation);
  cv::scaleAdd(detail, texture / deviation[0], sea, sea);
  return sea;
}

struct Sensor {
  double noise = 2.0;
  double pattern = 0.0;  ///< fixed, one sigma
  int type = CV_8UC1;
  double gain = 1.0;  ///< counts a level
};

/// What a camera at (x, y) of the scene records, noise anew each time.
cv::Mat capture(const cv::Mat& scene, double x, double y, const Sensor& sensor, cv::RNG& rng) {
  const cv::Matx23d move(1, 0, -x, 0, 1, -y);
  cv::Mat seen;
  cv::warpAffine(scene, seen, move, kSize, cv::INTER_LINEAR, cv::BORDER_REFLECT);
  cv::Mat noise(kSize, CV_32F);
  rng.fill(noise, cv::RNG::NORMAL, 0.0, sensor.noise);
  seen += noise;
  if (sensor.pattern > 0) {
    cv::Mat pattern(kSize, CV_32F);
    cv::RNG(77).fill(pattern, cv::RNG::NORMAL, 0.0, sensor.pattern);
    seen += pattern;
  }
  cv::Mat image;
  seen.convertTo(image, CV_MAKETYPE(CV_MAT_DEPTH(sensor.type), 1), sensor.gain);
  if (CV_MAT_CN(sensor.type) == 3) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  return image;
}

/// `count` captures, (dx, dy) apart.
std::vector<cv::Mat> flown(const cv::Mat& scene, int count, const cv::Point2d& from,
                           const cv::Point2d& step, const Sensor& sensor, cv::RNG& rng) {
  std::vector<cv::Mat> frames(static_cast<std::size_t>(count));
  cv::Point2d at = from;
  for (cv::Mat& frame : frames) {
    frame = capture(scene, at.x, at.y, sensor, rng);
    at += step;
  }
  return frames;
}

std::vector<bool> judged(const std::vector<cv::Mat>& frames) {
  DuplicateFilter filter;
  std::vector<bool> duplicate;
  for (const cv::Mat& frame : frames) {
    const auto difference = filter.judge(FrameSample::of(frame).value());
    duplicate.push_back(difference && difference->duplicate);
  }
  return duplicate;
}

/// The frames after a round through a codec, as ffmpeg makes and reads it.
std::vector<cv::Mat> encoded(const std::vector<cv::Mat>& frames, const std::string& codec,
                             const std::string& container) {
  const test::TemporaryFolder folder;
  const auto raw = folder.path() / "raw", video = folder.path() / ("video." + container),
             back = folder.path() / "back";
  {
    std::ofstream out(raw, std::ios::binary);
    for (const cv::Mat& frame : frames)
      out.write(reinterpret_cast<const char*>(frame.data),
                static_cast<std::streamsize>(frame.total()));
  }
  const std::string format = " -f rawvideo -pix_fmt gray ";
  const std::string make = "ffmpeg -v error -y" + format + "-s " + std::to_string(kSize.width) +
                           "x" + std::to_string(kSize.height) + " -r 25 -i '" + raw.string() +
                           "' " + codec + " '" + video.string() + "' && ffmpeg -v error -y -i '" +
                           video.string() + "'" + format + "'" + back.string() + "'";
  EXPECT_EQ(std::system(make.c_str()), 0) << make;
  std::vector<cv::Mat> decoded;
  std::ifstream in(back, std::ios::binary);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    cv::Mat frame(kSize, CV_8UC1);
    in.read(reinterpret_cast<char*>(frame.data), static_cast<std::streamsize>(frame.total()));
    EXPECT_TRUE(in.good());
    decoded.push_back(frame);
  }
  return decoded;
}

bool have_ffmpeg() { return std::system("ffmpeg -version >/dev/null 2>&1") == 0; }

TEST(HellingerDistance, IsFormula41) {
  // Two levels each, one shared: sqrt(1 - sqrt(1/2 · 1/4) - 0).
  cv::Mat a(64, 64, CV_8U, cv::Scalar(10)), b(64, 64, CV_8U, cv::Scalar(10));
  a.rowRange(32, 64) = 20;
  b.rowRange(16, 64) = 30;
  EXPECT_NEAR(hellinger_distance(a, b).value(), std::sqrt(1.0 - std::sqrt(0.5 * 0.25)), 1e-12);
  EXPECT_EQ(hellinger_distance(a, a).value(), 0.0);
  cv::Mat other(64, 64, CV_8U, cv::Scalar(99));
  EXPECT_EQ(hellinger_distance(a, other).value(), 1.0);
}

TEST(HellingerDistance, IsOpenCVsBhattacharyya) {
  cv::RNG rng(5);
  for (int i = 0; i < 20; ++i) {
    cv::Mat a(50, 70, CV_8U), b(50, 70, CV_8U);
    rng.fill(a, cv::RNG::NORMAL, rng.uniform(50, 200), rng.uniform(1, 60));
    rng.fill(b, cv::RNG::NORMAL, rng.uniform(50, 200), rng.uniform(1, 60));
    const int bins = 256;
    const float range[] = {0, 256};
    const float* ranges = range;
    cv::Mat ha, hb;
    cv::calcHist(&a, 1, nullptr, {}, ha, 1, &bins, &ranges);
    cv::calcHist(&b, 1, nullptr, {}, hb, 1, &bins, &ranges);
    EXPECT_NEAR(hellinger_distance(a, b).value(),
                cv::compareHist(ha, hb, cv::HISTCMP_BHATTACHARYYA), 1e-6);
  }
}

TEST(HellingerDistance, Spreads16BitOverTheRangeThatIsThere) {
  // 8 bits of levels on a base far up: the same distance as in 8 bit.
  cv::RNG rng(6);
  cv::Mat a(64, 64, CV_8U), b(64, 64, CV_8U);
  rng.fill(a, cv::RNG::UNIFORM, 0, 256);
  rng.fill(b, cv::RNG::UNIFORM, 0, 128);
  a.at<uchar>(0) = 0;
  a.at<uchar>(1) = 255;
  cv::Mat wide_a, wide_b;
  a.convertTo(wide_a, CV_16U, 1, 30000);
  b.convertTo(wide_b, CV_16U, 1, 30000);
  EXPECT_NEAR(hellinger_distance(wide_a, wide_b).value(), hellinger_distance(a, b).value(), 1e-12);
}

TEST(L2Norm, IsTheRootOfTheSumOfSquares) {
  const cv::Mat a(10, 10, CV_8UC3, cv::Scalar(1, 2, 3)), b(10, 10, CV_8UC3, cv::Scalar(1, 5, 7));
  EXPECT_NEAR(l2_norm(a, b).value(), std::sqrt(100.0 * (9 + 16)), 1e-9);
}

TEST(FrameDifference, SaysWhatOfADifferenceIsSeen) {
  cv::RNG rng(8);
  const cv::Mat scene = floes(1, 60, 4);
  const auto a = FrameSample::of(capture(scene, 10, 10, {.noise = 0.0}, rng)).value();
  const auto b = FrameSample::of(capture(scene, 10.6, 9.5, {.noise = 0.0}, rng)).value();
  const FrameDifference moved = compare(a, b).value();
  EXPECT_NEAR(moved.shift_px, std::hypot(0.6, 0.5), 0.25);
  EXPECT_FALSE(moved.duplicate);
  const FrameDifference same = compare(a, a).value();
  EXPECT_EQ(same.rms, 0.0);
  EXPECT_EQ(same.hellinger, 0.0);
  EXPECT_EQ(same.coarse_correlation, 1.0);
  EXPECT_TRUE(same.duplicate);
}

class AnySensor : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(
    Types, AnySensor,
    testing::Values(Sensor{.noise = 1.0}, Sensor{.noise = 4.0},
                    Sensor{.noise = 2.0, .pattern = 1.4}, Sensor{.noise = 2.0, .type = CV_8UC3},
                    Sensor{.noise = 2.0, .type = CV_16UC1, .gain = 15.0},
                    Sensor{.noise = 0.7, .pattern = 0.4, .type = CV_16UC1, .gain = 100.0}));

TEST_P(AnySensor, NeverLosesAFrameOverUniformIce) {
  cv::RNG rng(11);
  const cv::Mat ice(2 * kSize.height, 3 * kSize.width, CV_32F, cv::Scalar(150.0));
  EXPECT_THAT(judged(flown(ice, 25, {0, 0}, {3, 0}, GetParam(), rng)), testing::Each(false));
}

TEST_P(AnySensor, NeverLosesAFrameOfAHoverThatIsPerfectlyStill) {
  cv::RNG rng(12);
  for (const float texture : {0.0F, 3.0F, 10.0F}) {
    const cv::Mat scene = floes(2, 60, texture);
    EXPECT_THAT(judged(flown(scene, 10, {50, 40}, {0, 0}, GetParam(), rng)), testing::Each(false))
        << "texture " << texture;
  }
}

TEST_P(AnySensor, FindsEveryFrameThatIsStoredTwice) {
  cv::RNG rng(13);
  const cv::Mat scene = floes(3, 40, 4);
  std::vector<cv::Mat> frames;
  std::vector<bool> expected;
  for (int i = 0; i < 20; ++i) {
    const int times = 1 + i % 3;
    const cv::Mat frame = capture(scene, 1.5 * i, 0.7 * i, GetParam(), rng);
    for (int k = 0; k < times; ++k) {
      frames.push_back(frame.clone());
      expected.push_back(k > 0);
    }
  }
  EXPECT_EQ(judged(frames), expected);
}

TEST(DuplicateFilter, KeepsFramesThatShowNothing) {
  std::vector<cv::Mat> frames(5, cv::Mat(kSize, CV_8U, cv::Scalar(255)));
  EXPECT_THAT(judged(frames), testing::Each(false));
  // Neither does a caption make them tell: it is the same whatever the camera sees.
  for (cv::Mat& frame : frames) {
    frame = frame.clone();
    cv::putText(frame, "N 78.90 E 11.90", {10, 20}, cv::FONT_HERSHEY_PLAIN, 1.0, cv::Scalar(0));
  }
  EXPECT_THAT(judged(frames), testing::Each(false));
}

TEST(DuplicateFilter, DoesNotLoseACameraThatDriftsSlowly) {
  // A tenth of a pixel a frame, noise far below a level: each frame alone is as good as the last.
  cv::RNG rng(14);
  const cv::Mat scene = floes(4, 60, 5);
  const std::vector<bool> duplicate =
      judged(flown(scene, 60, {20, 20}, {0.1, 0}, {.noise = 0.05}, rng));
  std::size_t longest = 0, run = 0;
  for (const bool d : duplicate) longest = std::max(longest, run = d ? run + 1 : 0);
  EXPECT_LE(longest, 5U);  // half a pixel
}

struct Codec {
  std::string options, container;
};

// GoogleTest finds it by this name.
void PrintTo(const Codec& c, std::ostream* out) {  // NOLINT(readability-identifier-naming)
  *out << c.options;
}

class MadeVideo : public testing::TestWithParam<Codec> {};

INSTANTIATE_TEST_SUITE_P(Codecs, MadeVideo,
                         testing::Values(Codec{"-c:v mjpeg -q:v 2 -pix_fmt yuvj420p", "avi"},
                                         Codec{"-c:v mjpeg -q:v 8 -pix_fmt yuvj420p", "avi"},
                                         Codec{"-c:v libx264 -crf 18 -pix_fmt yuv420p", "mkv"},
                                         Codec{"-c:v libx264 -crf 23 -pix_fmt yuv420p", "mkv"},
                                         Codec{"-c:v libx264 -crf 30 -pix_fmt yuv420p", "mkv"}));

TEST_P(MadeVideo, ShowsItsDuplicatesAndItsMotion) {
  if (!have_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  for (const double noise : {0.7, 1.5, 3.0}) {
    cv::RNG rng(15);
    const cv::Mat scene = floes(5, 50, 3);
    std::vector<cv::Mat> frames;
    std::vector<bool> expected;
    for (int i = 0; i < 14; ++i) {
      const cv::Mat frame = capture(scene, 4.3 * i, 2.1 * i, {.noise = noise}, rng);
      for (int k = 0; k < 1 + i % 4; ++k) {  // as when 9 Hz are recorded at 25
        frames.push_back(frame);
        expected.push_back(k > 0);
      }
    }
    EXPECT_EQ(judged(encoded(frames, GetParam().options, GetParam().container)), expected)
        << "noise " << noise;
  }
}

/// A key frame is quantised unlike the frame before it, which can look like noise of its own, or
/// pass 0.03: then the frame is kept. Never the other way.
TEST(MadeVideo, OfManyKeyFramesLosesNoFrameAndShowsMostDuplicates) {
  if (!have_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  cv::RNG rng(18);
  const cv::Mat scene = floes(8, 50, 3);
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 24; ++i)
    frames.insert(frames.end(), 3, capture(scene, 4.3 * i, 2.1 * i, {.noise = 2.0}, rng));
  const std::vector<bool> duplicate =
      judged(encoded(frames, "-c:v libx264 -crf 23 -g 7 -pix_fmt yuv420p", "mkv"));
  int found = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i % 3 == 0)
      EXPECT_FALSE(duplicate[i]) << i;
    else
      found += duplicate[i];
  }
  EXPECT_GE(found, 36);  // of 48
}

TEST(MadeVideo, OfSlowMotionLosesNoFrame) {
  if (!have_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  cv::RNG rng(16);
  const cv::Mat scene = floes(6, 50, 3);
  const std::vector<cv::Mat> frames = flown(scene, 40, {20, 20}, {0.7, 0.3}, {.noise = 2.0}, rng);
  EXPECT_THAT(judged(encoded(frames, "-c:v libx264 -crf 23 -pix_fmt yuv420p", "mkv")),
              testing::Each(false));
}

TEST(FrameSample, RefusesWhatItCannotCompare) {
  EXPECT_EQ(FrameSample::of(cv::Mat()).error().code, ErrorCode::InvalidInput);
  EXPECT_EQ(FrameSample::of(cv::Mat(100, 100, CV_32F)).error().code, ErrorCode::Unsupported);
  EXPECT_EQ(FrameSample::of(cv::Mat(100, 20, CV_8U)).error().code, ErrorCode::InvalidInput);
  const auto small = FrameSample::of(cv::Mat(64, 64, CV_8U, cv::Scalar(1))).value();
  const auto large = FrameSample::of(cv::Mat(64, 80, CV_8U, cv::Scalar(1))).value();
  EXPECT_EQ(compare(small, large).error().code, ErrorCode::InvalidInput);
  EXPECT_EQ(l2_norm(cv::Mat(4, 4, CV_8U), cv::Mat(4, 5, CV_8U)).error().code,
            ErrorCode::InvalidInput);
  EXPECT_EQ(hellinger_distance(cv::Mat(4, 4, CV_32F), cv::Mat(4, 4, CV_32F)).error().code,
            ErrorCode::Unsupported);
}

}  // namespace
}  // namespace watersky
