// SPDX-License-Identifier: MIT
#include "watersky/vision/sensor_correction.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace watersky {
namespace {

const cv::Size kSize(320, 256);

/// Ice floes on water through a lens, levels 0 (water) to 1 (ice).
cv::Mat floes(std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat sea(kSize.height + 200, kSize.width + 2000, CV_32F, cv::Scalar(0.0));
  for (int i = 0; i < 250; ++i)
    cv::circle(sea, {rng.uniform(0, sea.cols), rng.uniform(0, sea.rows)}, rng.uniform(1, 50),
               cv::Scalar(rng.uniform(0.7F, 1.2F)), cv::FILLED, cv::LINE_8);
  cv::GaussianBlur(sea, sea, {}, 0.6);
  return sea;
}

/// A camera with all faults.
struct Camera {
  int depth = CV_16U;
  double water = 7000.0, contrast = 60.0;
  double noise = 4.0;
  double column = 0.0, pixel = 0.0;                   ///< one sigma
  double corners = 0.0;                               ///< counts that the corners have more
  double corner_light = 1.0;                          ///< share of the middle's light
  std::vector<std::pair<cv::Point, double>> stuck{};  ///< at this level

  [[nodiscard]] cv::Mat pattern() const {
    cv::RNG rng(99);
    cv::Mat columns(1, kSize.width, CV_32F), pixels(kSize, CV_32F);
    rng.fill(columns, cv::RNG::NORMAL, 0.0, column);
    rng.fill(pixels, cv::RNG::NORMAL, 0.0, pixel);
    return pixels + cv::repeat(columns, kSize.height, 1);
  }
  [[nodiscard]] cv::Mat rho2() const {
    cv::Mat map(kSize, CV_32F);
    const double cx = 0.5 * (kSize.width - 1), cy = 0.5 * (kSize.height - 1);
    for (int y = 0; y < kSize.height; ++y)
      for (int x = 0; x < kSize.width; ++x)
        map.at<float>(y, x) =
            static_cast<float>(((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (cx * cx + cy * cy));
    return map;
  }
  /// What a faultless one would see, without noise.
  [[nodiscard]] cv::Mat ideal(const cv::Mat& sea, int x, int y) const {
    return sea(cv::Rect({x, y}, kSize)) * contrast + water;
  }
  [[nodiscard]] cv::Mat capture(const cv::Mat& sea, int x, int y, cv::RNG& rng) const {
    cv::Mat light = ideal(sea, x, y);
    light = light.mul(1.0 - (1.0 - corner_light) * rho2()) + corners * rho2() + pattern();
    cv::Mat random(kSize, CV_32F);
    rng.fill(random, cv::RNG::NORMAL, 0.0, noise);
    light += random;
    for (const auto& [p, level] : stuck) light.at<float>(p) = static_cast<float>(level);
    cv::Mat image;
    light.convertTo(image, depth);
    return image;
  }
};

Camera in_8_bit() {
  Camera camera;
  camera.depth = CV_8U;
  camera.water = 90;
  camera.contrast = 60;
  camera.noise = 2.0;
  return camera;
}

/// Shown `frames` frames, each `step` pixels further.
SensorCorrection shown(const Camera& camera, const cv::Mat& sea, int frames, int step) {
  cv::RNG rng(3);
  SensorCorrection correction;
  for (int i = 0; i < frames; ++i)
    correction.observe(camera.capture(sea, (i * step) % 1900, (i * 37) % 200 * (step > 0), rng));
  correction.learn();
  return correction;
}

/// RMS of a fresh frame against the faultless one, of the same mean and contrast; without noise.
double error_rms(const Camera& camera, const cv::Mat& sea, const SensorCorrection* correction) {
  cv::RNG rng(1234);
  Camera quiet = camera;
  quiet.noise = 0.3;  // enough that rounding is no bias
  const cv::Mat raw = quiet.capture(sea, 991, 83, rng), ideal = quiet.ideal(sea, 991, 83);
  cv::Mat got;
  (correction ? correction->correct(raw) : raw).convertTo(got, CV_32F);
  // A share of the light is free to be that of the middle or of the mean.
  const double scale = camera.depth == CV_8U ? cv::mean(got)[0] / cv::mean(ideal)[0] : 1.0;
  const cv::Mat error = got / scale - ideal;
  cv::Scalar mean, deviation;
  cv::meanStdDev(error, mean, deviation);
  return deviation[0];
}

TEST(SensorCorrection, TakesThePatternOutAndLeavesTheSea) {
  const cv::Mat sea = floes(1);
  Camera camera;
  camera.column = 3.0;
  camera.pixel = 3.0;
  const SensorCorrection correction = shown(camera, sea, 16, 117);
  const SensorFindings& found = correction.findings();
  EXPECT_TRUE(found.moving);
  EXPECT_TRUE(found.corrects_pattern);
  EXPECT_NEAR(found.column_rms, 3.0, 0.6);
  EXPECT_NEAR(found.pixel_rms, 3.0, 0.6);
  const double before = error_rms(camera, sea, nullptr),
               after = error_rms(camera, sea, &correction);
  EXPECT_NEAR(before, std::sqrt(18.0), 0.4);
  EXPECT_LT(after, 0.4 * before);
  RecordProperty("before", std::to_string(before));
  RecordProperty("after", std::to_string(after));
}

TEST(SensorCorrection, EstimatesWhatItLeaves) {
  const cv::Mat sea = floes(2);
  Camera camera;
  camera.pixel = 4.0;
  camera.noise = 8.0;
  for (const int frames : {8, 16, 32}) {
    const SensorCorrection correction = shown(camera, sea, frames, 117);
    const double after = error_rms(camera, sea, &correction);
    EXPECT_NEAR(correction.findings().pattern_left_rms, after, 0.35 * after) << frames;
  }
}

TEST(SensorCorrection, DoesNothingToAFaultlessCamera) {
  for (const Camera& camera : {Camera{}, in_8_bit()}) {
    const cv::Mat sea = floes(3);
    const SensorCorrection correction = shown(camera, sea, 16, 117);
    EXPECT_FALSE(correction.needed());
    EXPECT_TRUE(correction.findings().notes().empty());
    const cv::Mat image(kSize, CV_MAKETYPE(camera.depth, 1), cv::Scalar(100));
    EXPECT_EQ(correction.correct(image).data, image.data);
  }
}

TEST(SensorCorrection, DoesNothingWithoutMotion) {
  // The sea itself would be the pattern.
  Camera camera;
  camera.column = 3.0;
  camera.corners = 40.0;
  const SensorCorrection correction = shown(camera, floes(4), 20, 0);
  EXPECT_FALSE(correction.findings().moving);
  EXPECT_FALSE(correction.needed());
}

TEST(SensorCorrection, DoesNothingWithFewFrames) {
  Camera camera;
  camera.column = 3.0;
  EXPECT_FALSE(shown(camera, floes(5), 5, 117).needed());
  SensorCorrection untaught;
  untaught.learn();
  EXPECT_FALSE(untaught.needed());
}

TEST(SensorCorrection, LearnsFromASeaWithoutDetail) {
  const cv::Mat sea = cv::Mat::ones(kSize.height + 200, kSize.width + 2000, CV_32F);
  Camera camera;
  camera.column = 2.0;
  camera.pixel = 2.0;
  const SensorCorrection correction = shown(camera, sea, 16, 117);
  EXPECT_TRUE(correction.findings().corrects_pattern);
  EXPECT_LT(error_rms(camera, sea, &correction), 0.5 * error_rms(camera, sea, nullptr));
}

TEST(SensorCorrection, TakesVignettingOut) {
  const cv::Mat sea = floes(6);
  Camera visible = in_8_bit();
  for (const double light : {0.85, 0.6, 0.45}) {
    visible.corner_light = light;
    const SensorCorrection correction = shown(visible, sea, 16, 117);
    EXPECT_TRUE(correction.findings().corrects_vignetting) << light;
    EXPECT_NEAR(correction.findings().corner_step, light - 1.0, 0.05);
    EXPECT_FALSE(correction.findings().corrects_pattern);
    EXPECT_THAT(correction.findings().defects, testing::IsEmpty());
    EXPECT_LT(error_rms(visible, sea, &correction), 0.35 * error_rms(visible, sea, nullptr));
  }
  Camera thermal;
  for (const double counts : {-40.0, 40.0}) {
    thermal.corners = counts;
    const SensorCorrection correction = shown(thermal, sea, 16, 117);
    EXPECT_TRUE(correction.findings().corrects_vignetting) << counts;
    EXPECT_NEAR(correction.findings().corner_step, counts, 6.0);
    EXPECT_LT(error_rms(thermal, sea, &correction), 0.35 * error_rms(thermal, sea, nullptr));
  }
}

TEST(SensorCorrection, TakesADarkMiddleOutAsWell) {
  // A camera that corrects for a lens which it does not have.
  const cv::Mat sea = floes(14);
  Camera camera = in_8_bit();
  camera.corner_light = 1.5;
  const SensorCorrection correction = shown(camera, sea, 16, 117);
  EXPECT_TRUE(correction.findings().corrects_vignetting);
  EXPECT_LT(error_rms(camera, sea, &correction), 0.35 * error_rms(camera, sea, nullptr));
}

TEST(SensorCorrection, TakesNoIceEdgeForVignetting) {
  // Ice on the left or along the middle in every frame: a mean over the frames would call it
  // shading.
  for (const bool middle : {false, true}) {
    cv::Mat sea = floes(7) * 0.2;
    sea = cv::Mat(sea.t());
    const int from = middle ? 130 : 0, to = middle ? 190 : 160;
    cv::Mat tall = sea.colRange(0, kSize.width).clone();
    tall.colRange(from, to) += 1.0;
    for (const Camera& camera : {Camera{}, in_8_bit()}) {
      cv::RNG rng(8);
      SensorCorrection correction;
      for (int i = 0; i < 16; ++i) correction.observe(camera.capture(tall, 0, 120 * i, rng));
      correction.learn();
      EXPECT_FALSE(correction.findings().corrects_vignetting);
      EXPECT_FALSE(correction.findings().corrects_pattern);
    }
  }
}

TEST(SensorCorrection, ReplacesDefectsAndKeepsSmallFloes) {
  cv::Mat sea = floes(9);
  Camera camera;
  camera.stuck = {
      {{40, 50}, 7900}, {{41, 50}, 6000}, {{200, 100}, 0}, {{10, 10}, 65535}, {{0, 20}, 9000}};
  const SensorCorrection correction = shown(camera, sea, 16, 117);
  EXPECT_THAT(correction.findings().defects,
              testing::IsSupersetOf({cv::Point(200, 100), cv::Point(10, 10), cv::Point(0, 20),
                                     cv::Point(40, 50), cv::Point(41, 50)}));
  EXPECT_LE(correction.findings().defects.size(), 6U);
  EXPECT_LT(error_rms(camera, sea, &correction), 5.0);
  EXPECT_GT(error_rms(camera, sea, nullptr), 200.0);
}

TEST(FindDefectivePixels, LeavesPointsThatALensMade) {
  cv::RNG rng(10);
  cv::Mat sea(kSize, CV_32F, cv::Scalar(7000.0));
  std::vector<cv::Point> floe, defect;
  for (int y = 8; y + 8 < kSize.height; y += 16)
    for (int x = 8; x + 16 < kSize.width; x += 32) {
      floe.emplace_back(x, y);
      defect.emplace_back(x + 16, y);
    }
  for (const cv::Point& p : floe) sea.at<float>(p) += 600.0F;  // one pixel large
  cv::GaussianBlur(sea, sea, {}, 0.6);
  for (const cv::Point& p : defect) sea.at<float>(p) += rng.uniform(0, 2) ? 90.0F : -90.0F;
  cv::Mat noise(kSize, CV_32F), image;
  rng.fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
  cv::Mat(sea + noise).convertTo(image, CV_16U);
  const auto found = find_defective_pixels(image).value();
  for (const cv::Point& p : floe) EXPECT_THAT(found, testing::Not(testing::Contains(p)));
  std::size_t right = 0;
  for (const cv::Point& p : defect) right += std::count(found.begin(), found.end(), p) > 0;
  EXPECT_GE(right, defect.size() * 95 / 100);
  EXPECT_LE(found.size(), right + 1);
}

TEST(SensorCorrection, CorrectsColourByItsVignettingOnly) {
  const cv::Mat sea = floes(11);
  Camera camera = in_8_bit();
  camera.corner_light = 0.6;
  cv::RNG rng(12);
  const auto color = [&](int x, int y) {
    cv::Mat image;
    cv::cvtColor(camera.capture(sea, x, y, rng), image, cv::COLOR_GRAY2BGR);
    return image;
  };
  SensorCorrection correction;
  for (int i = 0; i < 16; ++i) correction.observe(color(117 * i, 10 * i));
  correction.learn();
  EXPECT_TRUE(correction.findings().corrects_vignetting);
  EXPECT_FALSE(correction.findings().corrects_pattern);
  EXPECT_TRUE(correction.findings().defects.empty());
  // Decoded at half the size the same field is taken out.
  const cv::Mat image = color(50, 50);
  cv::Mat half, corrected_half;
  cv::resize(image, half, {}, 0.5, 0.5, cv::INTER_AREA);
  cv::resize(correction.correct(image), corrected_half, {}, 0.5, 0.5, cv::INTER_AREA);
  EXPECT_LT(cv::norm(correction.correct(half), corrected_half, cv::NORM_INF), 4.0);
}

TEST(SensorCorrection, PassesWhatItWasNotMadeFor) {
  Camera camera;
  camera.column = 3.0;
  const SensorCorrection correction = shown(camera, floes(13), 16, 117);
  ASSERT_TRUE(correction.needed());
  for (const int type : {CV_8UC1, CV_8UC3, CV_32FC1}) {
    const cv::Mat other(kSize, type, cv::Scalar::all(7));
    EXPECT_EQ(correction.correct(other).data, other.data);
  }
  EXPECT_EQ(find_defective_pixels(cv::Mat(9, 9, CV_32F)).error().code, ErrorCode::Unsupported);
}

}  // namespace
}  // namespace watersky
