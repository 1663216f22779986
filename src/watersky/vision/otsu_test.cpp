// SPDX-License-Identifier: MIT
#include "watersky/vision/otsu.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "watersky/vision/detail/test_frames.hpp"

namespace watersky {
namespace {

using namespace test;

constexpr TwoClassEvidence kPlain{};

cv::Mat random_image(cv::RNG& rng, int type = CV_8U) {
  cv::Mat image(rng.uniform(1, 90), rng.uniform(1, 90), type);
  const double span = type == CV_8U ? 255.0 : 65535.0;
  if (rng.uniform(0, 2) == 0) {
    rng.fill(image, cv::RNG::UNIFORM, 0.0, rng.uniform(1.0, span));
  } else {
    rng.fill(image, cv::RNG::NORMAL, rng.uniform(0.2, 0.8) * span, 0.05 * span);
    const cv::Rect half(0, 0, image.cols, (image.rows + 1) / 2);
    cv::Mat part = image(half);
    rng.fill(part, cv::RNG::NORMAL, rng.uniform(0.2, 0.8) * span, 0.03 * span);
  }
  return image;
}

TEST(OtsuThreshold, SplitsEveryPixelAsOpenCvDoes) {
  cv::RNG rng(1);
  int equal = 0;
  for (int i = 0; i < 2000; ++i) {
    const cv::Mat image = random_image(rng);
    cv::Mat theirs;
    const double level = cv::threshold(image, theirs, 0, 255, cv::THRESH_OTSU);
    const auto ours = otsu_threshold(image).value();
    if (ours.separability == 0.0) continue;  // one level: OpenCV splits it nevertheless
    // Between two levels that occur any threshold is the same split; we name the lowest.
    EXPECT_EQ(cv::norm(theirs, image > ours.level, cv::NORM_INF), 0.0) << i;
    equal += ours.level == static_cast<int>(level);
  }
  EXPECT_GT(equal, 1900);
}

TEST(OtsuThreshold, SplitsSixteenBitsAsOpenCvDoes) {
  cv::RNG rng(2);
  for (int i = 0; i < 50; ++i) {
    const cv::Mat image = random_image(rng, CV_16U);
    const auto ours = otsu_threshold(image).value();
    if (ours.separability == 0.0) continue;
    cv::Mat theirs;
    cv::threshold(image, theirs, 0, 65535, cv::THRESH_OTSU);
    EXPECT_EQ(cv::norm(theirs != 0, image > ours.level, cv::NORM_INF), 0.0) << i;
  }
}

TEST(OtsuThreshold, SeparabilityIsOneForTwoLevelsAndTwoOverPiForOneGaussian) {
  cv::Mat two(10, 10, CV_8U, cv::Scalar(40));
  two.rowRange(0, 3).setTo(200);
  const auto split = otsu_threshold(two).value();
  EXPECT_DOUBLE_EQ(split.separability, 1.0);
  EXPECT_EQ(split.level, 40);
  EXPECT_DOUBLE_EQ(split.bright_fraction, 0.3);
  EXPECT_DOUBLE_EQ(split.bright_mean, 200.0);

  cv::RNG rng(3);
  cv::Mat noise(600, 600, CV_16U);
  rng.fill(noise, cv::RNG::NORMAL, 30000.0, 2000.0);
  EXPECT_NEAR(otsu_threshold(noise).value().separability, 2.0 / M_PI, 0.005);
}

TEST(OtsuThreshold, CountsOnlyWhatIsValid) {
  cv::RNG rng(4);
  const cv::Mat image = random_image(rng);
  cv::Mat wide;
  cv::copyMakeBorder(image, wide, 3, 5, 7, 2, cv::BORDER_CONSTANT, 255);
  cv::Mat valid(image.size(), CV_8U, cv::Scalar(255));
  cv::copyMakeBorder(valid, valid, 3, 5, 7, 2, cv::BORDER_CONSTANT, 0);
  EXPECT_EQ(otsu_threshold(wide, valid).value().level, otsu_threshold(image).value().level);
  valid.setTo(0);
  EXPECT_EQ(otsu_threshold(wide, valid).error().code, ErrorCode::InvalidInput);
}

TEST(OtsuSegmenter, WithoutAFlightIsPlainOtsu) {
  cv::RNG rng(5);
  for (int i = 0; i < 60; ++i) {
    const cv::Mat image = frame(rng, floes(rng, kFrame, rng.uniform(0.05, 0.6)), 80,
                                rng.uniform(20.0, 90.0), rng.uniform(1.0, 12.0));
    const auto otsu = otsu_threshold(image).value();
    const cv::Mat p = OtsuSegmenter(kPlain, IcePolarity::Brighter).segment(image, {}).value();
    cv::Mat expected(image.size(), CV_32F, cv::Scalar(0.4F));
    expected.setTo(0.7F, image > otsu.level);
    EXPECT_EQ(known_fraction(p), 1.0);
    EXPECT_EQ(cv::norm(p, expected, cv::NORM_INF), 0.0);
  }
}

TEST(OtsuSegmenter, InvertedImagesInvertWithThePolarity) {
  cv::RNG rng(6);
  const TwoClassEvidence symmetric{.p_ice_if_ice = 0.75, .p_ice_if_water = 0.25, .close_px = 0};
  OtsuSegmenter bright(symmetric, IcePolarity::Brighter), dark(symmetric, IcePolarity::Darker);
  std::vector<cv::Mat> images;
  for (int i = 0; i < 6; ++i) {
    images.push_back(frame(rng, floes(rng, kFrame, 0.1 + 0.1 * i), 100, 60, 10));
    bright.observe(images.back(), {});
    dark.observe(255 - images.back(), {});
  }
  for (const auto& image : images) {
    const cv::Mat a = ice_found(bright, image), b = ice_found(dark, 255 - image);
    EXPECT_LT(error(a, b), 0.002);  // levels fall on the other side of a bin
    // And the wrong polarity gives exactly the complement.
    const cv::Mat p = OtsuSegmenter(symmetric, IcePolarity::Brighter).segment(image, {}).value();
    const cv::Mat q = OtsuSegmenter(symmetric, IcePolarity::Darker).segment(image, {}).value();
    EXPECT_LT(cv::norm(p + q, cv::Mat(p.size(), CV_32F, cv::Scalar(1.0)), cv::NORM_INF), 1e-6);
  }
}

/// The least error that any threshold can make of two equal Gaussians `d` sigmas apart.
double bayes_error(double f, double d) {
  const auto tail = [](double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); };
  const double off = std::log((1.0 - f) / f) / d;
  return (1.0 - f) * tail(0.5 * d + off) + f * tail(0.5 * d - off);
}

TEST(OtsuSegmenter, AtFourSigmasIsWithinHalfAPercentOfTheBestForAnyIceFraction) {
  cv::RNG rng(7);
  for (const int type : {CV_8U, CV_16U}) {
    OtsuSegmenter segmenter(kPlain, IcePolarity::Brighter);
    std::vector<std::pair<cv::Mat, cv::Mat>> flight;
    for (const double f : {0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65}) {
      for (const bool inverted : {false, true}) {
        cv::Mat ice = floes(rng, kFrame, f, f < 0.06 ? 20 : 60);
        if (inverted) ice = ~ice;  // fractions up to 0.98
        flight.emplace_back(frame(rng, ice, 90, 32, 8, type), ice);
        segmenter.observe(flight.back().first, {});
      }
    }
    EXPECT_TRUE(segmenter.classes().two_classes);
    EXPECT_NEAR(segmenter.classes().bright - segmenter.classes().dark, 32.0, 3.0);
    EXPECT_NEAR(segmenter.classes().sigma, 8.0, 1.0);
    for (const auto& [image, ice] : flight) {
      const double f = fraction(ice);
      EXPECT_LT(error(ice_found(segmenter, image), ice), bayes_error(f, 4.0) + 0.005) << f;
    }
  }
}

TEST(OtsuSegmenter, WaterAloneStaysWaterAndIceAloneStaysIce) {
  cv::RNG rng(8);
  OtsuSegmenter segmenter(kPlain, IcePolarity::Brighter);
  for (const double f : {0.2, 0.4, 0.0, 0.0, 0.5})
    segmenter.observe(frame(rng, floes(rng, kFrame, f), 90, 32, 8), {});
  for (int i = 0; i < 20; ++i) {
    const cv::Mat water = frame(rng, cv::Mat::zeros(kFrame, CV_8U), 90, 32, 8);
    EXPECT_LT(fraction(ice_found(segmenter, water)), 0.01);
    // Otsu's threshold would have cut it in half; by itself the frame is not known.
    EXPECT_GT(fraction(water > otsu_threshold(water)->level), 0.3);
    EXPECT_EQ(
        known_fraction(OtsuSegmenter(kPlain, IcePolarity::Brighter).segment(water, {}).value()),
        0.0);
    const cv::Mat ice = frame(rng, cv::Mat(kFrame, CV_8U, cv::Scalar(255)), 90, 32, 8);
    EXPECT_GT(fraction(ice_found(segmenter, ice)), 0.99);
  }
}

TEST(OtsuSegmenter, LearnsFromFramesThatEachShowOneClass) {
  cv::RNG rng(9);
  OtsuSegmenter segmenter(kPlain, IcePolarity::Brighter);
  const cv::Mat none = cv::Mat::zeros(kFrame, CV_8U), all = ~none;
  for (int i = 0; i < 6; ++i) segmenter.observe(frame(rng, i < 4 ? none : all, 90, 32, 8), {});
  EXPECT_EQ(segmenter.classes().two_class_frames, 0u);
  EXPECT_TRUE(segmenter.classes().two_classes);
  EXPECT_LT(fraction(ice_found(segmenter, frame(rng, none, 90, 32, 8))), 0.01);
  EXPECT_GT(fraction(ice_found(segmenter, frame(rng, all, 90, 32, 8))), 0.99);
}

TEST(OtsuSegmenter, SaysWhenAFlightShowsOneClassOnly) {
  cv::RNG rng(10);
  OtsuSegmenter segmenter;
  for (int i = 0; i < 5; ++i)
    segmenter.observe(frame(rng, cv::Mat::zeros(kFrame, CV_8U), 90, 32, 8), {});
  EXPECT_EQ(segmenter.classes().frames, 5u);
  EXPECT_FALSE(segmenter.classes().two_classes);
  EXPECT_LT(segmenter.polarity().confidence, kSureOfPolarity);
}

// A thermal camera moves its levels as the scene changes: water in one frame is as bright as
// water plus a third of the contrast in another.
TEST(OtsuSegmenter, FollowsLevelsThatDriftWithTheGain) {
  cv::RNG rng(11);
  OtsuSegmenter segmenter(kPlain, IcePolarity::Brighter);
  std::vector<std::pair<cv::Mat, cv::Mat>> flight;
  for (int i = 0; i < 24; ++i) {
    const double drift = rng.uniform(-10.0, 10.0);
    const double f = i % 4 == 0 ? 0.0 : i % 4 == 1 ? 0.03 : rng.uniform(0.1, 0.5);
    const cv::Mat ice = floes(rng, kFrame, f, f < 0.06 ? 20 : 60);
    flight.emplace_back(frame(rng, ice, 90 + drift, 32, 8), ice);
    segmenter.observe(flight.back().first, {});
  }
  EXPECT_GT(segmenter.classes().drift_sigma, 2.0);
  for (const auto& [image, ice] : flight) EXPECT_LT(error(ice_found(segmenter, image), ice), 0.028);
}

TEST(OtsuSegmenter, DoesNotReadShadingAsTwoClasses) {
  cv::RNG rng(12);
  OtsuSegmenter segmenter(kPlain, IcePolarity::Brighter);
  cv::Mat shaded(kFrame, CV_32F);
  for (int y = 0; y < shaded.rows; ++y)
    for (int x = 0; x < shaded.cols; ++x)
      shaded.at<float>(y, x) = static_cast<float>(
          150.0 - 60.0 * (std::pow(x - 160.0, 2) + std::pow(y - 128.0, 2)) / (160.0 * 160.0) +
          rng.gaussian(4.0));
  shaded.convertTo(shaded, CV_8U);
  for (int i = 0; i < 3; ++i) segmenter.observe(shaded, {});
  EXPECT_EQ(segmenter.classes().two_class_frames, 0u);
}

TEST(OtsuSegmenter, TakesReducedFramesOfTheSameFlight) {
  cv::RNG rng(13);
  OtsuSegmenter segmenter(kPlain, IcePolarity::Brighter);
  const cv::Mat ice = floes(rng, {1280, 1024}, 0.3, 150);
  const cv::Mat image = frame(rng, ice, 90, 32, 8);
  segmenter.observe(image, {});
  cv::Mat quarter, quarter_ice;
  cv::resize(image, quarter, {}, 0.25, 0.25, cv::INTER_AREA);
  cv::resize(ice, quarter_ice, {}, 0.25, 0.25, cv::INTER_AREA);
  const cv::Mat edges = (quarter_ice > 0) & (quarter_ice < 255);
  cv::Mat wrong = ice_found(segmenter, quarter) ^ (quarter_ice > 127);
  wrong.setTo(0, edges);
  EXPECT_LT(fraction(wrong), 0.001);
}

TEST(OtsuSegmenter, SixteenBitsEqualEightBitsScaled) {
  cv::RNG rng(14);
  OtsuSegmenter eight(kPlain, IcePolarity::Brighter), sixteen(kPlain, IcePolarity::Brighter);
  for (int i = 0; i < 8; ++i) {
    const cv::Mat image = frame(rng, floes(rng, kFrame, 0.05 * i), 90, 60, 8);
    cv::Mat deep;
    image.convertTo(deep, CV_16U, 256.0);
    EXPECT_EQ(cv::norm(ice_found(OtsuSegmenter(kPlain, IcePolarity::Darker), image),
                       ice_found(OtsuSegmenter(kPlain, IcePolarity::Darker), deep), cv::NORM_INF),
              0.0);
    eight.observe(image, {});
    sixteen.observe(deep, {});
    EXPECT_EQ(cv::norm(ice_found(eight, image), ice_found(sixteen, deep), cv::NORM_INF), 0.0) << i;
  }
}

TEST(OtsuSegmenter, ReadsThermalCountsDespiteHotPixels) {
  cv::RNG rng(15);
  OtsuSegmenter segmenter(kPlain, IcePolarity::Darker);
  const cv::Mat ice = floes(rng, kFrame, 0.3);
  cv::Mat image = frame(rng, ~ice, 22000, 90, 20, CV_16U);  // water warmer by 90 counts
  for (int i = 0; i < 15; ++i)
    image.at<unsigned short>(rng.uniform(0, 256), rng.uniform(0, 320)) = 65535;
  segmenter.observe(image, {});
  EXPECT_NEAR(segmenter.classes().bright - segmenter.classes().dark, 90.0, 9.0);
  EXPECT_LT(error(ice_found(segmenter, image), ice), 0.03);
}

TEST(OtsuSegmenter, ClosesDarkIceAsWellAsBrightIce) {
  cv::Mat image(60, 60, CV_8U, cv::Scalar(50));
  cv::rectangle(image, {10, 10, 40, 40}, 200, cv::FILLED);
  image.at<unsigned char>(30, 30) = 50;  // a hole in the ice
  image.at<unsigned char>(3, 3) = 200;   // a growler, which closing must leave
  const TwoClassEvidence closing{.p_ice_if_ice = 0.7, .p_ice_if_water = 0.4, .close_px = 4};
  for (const bool dark : {false, true}) {
    const cv::Mat shown = dark ? cv::Mat(255 - image) : image;
    const auto ice = dark ? IcePolarity::Darker : IcePolarity::Brighter;
    const cv::Mat open = ice_found(OtsuSegmenter(kPlain, ice), shown);
    const cv::Mat closed = ice_found(OtsuSegmenter(closing, ice), shown);
    EXPECT_EQ(cv::countNonZero(open), 40 * 40);
    EXPECT_EQ(cv::countNonZero(closed), 40 * 40 + 1);
    EXPECT_EQ(closed.at<unsigned char>(30, 30), 255);
    EXPECT_EQ(closed.at<unsigned char>(3, 3), 255);
  }
}

TEST(OtsuSegmenter, KnowsNothingOutsideTheValidPart) {
  cv::RNG rng(16);
  const cv::Mat ice = floes(rng, kFrame, 0.3);
  cv::Mat image = frame(rng, ice, 90, 60, 8);
  cv::Mat valid(kFrame, CV_8U, cv::Scalar(1));
  valid.colRange(0, 100).setTo(0);
  image.colRange(0, 100).setTo(255);
  for (const bool observed : {false, true}) {
    OtsuSegmenter segmenter({.p_ice_if_ice = 0.7, .p_ice_if_water = 0.4, .close_px = 5},
                            IcePolarity::Brighter);
    if (observed) segmenter.observe(image, valid);
    const cv::Mat p = segmenter.segment(image, valid).value();
    EXPECT_EQ(cv::countNonZero(known(p) != (valid != 0)), 0);
    EXPECT_LT(error(cv::Mat(p > 0.5).colRange(100, 320), ice.colRange(100, 320)), 0.02);
  }
  valid.setTo(0);
  const cv::Mat nothing = OtsuSegmenter().segment(image, valid).value();
  EXPECT_EQ(known_fraction(nothing), 0.0);
}

TEST(OtsuSegmenter, OneGrayLevelIsNeitherIceNorWater) {
  const cv::Mat flat(50, 50, CV_8U, cv::Scalar(80));
  EXPECT_EQ(known_fraction(OtsuSegmenter().segment(flat, {}).value()), 0.0);
}

TEST(OtsuSegmenter, TakesColourAsLuminance) {
  cv::RNG rng(17);
  cv::Mat color(100, 120, CV_8UC3), gray;
  rng.fill(color, cv::RNG::UNIFORM, 150, 255);
  color.rowRange(0, 40) *= 0.3;
  cv::cvtColor(color, gray, cv::COLOR_BGR2GRAY);
  EXPECT_GT(fraction(ice_found(OtsuSegmenter(kPlain, IcePolarity::Brighter), gray)), 0.5);
  const OtsuSegmenter segmenter(kPlain, IcePolarity::Brighter);
  EXPECT_EQ(cv::norm(ice_found(segmenter, color), ice_found(segmenter, gray), cv::NORM_INF), 0.0);
}

TEST(OtsuSegmenter, RefusesWhatItDoesNotTake) {
  OtsuSegmenter segmenter;
  EXPECT_EQ(segmenter.segment({}, {}).error().code, ErrorCode::InvalidInput);
  EXPECT_EQ(segmenter.segment(cv::Mat(9, 9, CV_32F, cv::Scalar(1)), {}).error().code,
            ErrorCode::Unsupported);
  EXPECT_EQ(segmenter.segment(cv::Mat(9, 9, CV_8UC4, cv::Scalar(1)), {}).error().code,
            ErrorCode::Unsupported);
  const cv::Mat image(9, 9, CV_8U, cv::Scalar(1));
  const auto result = segmenter.segment(image, cv::Mat(8, 9, CV_8U, cv::Scalar(1)));
  EXPECT_EQ(result.error().code, ErrorCode::InvalidInput);
  EXPECT_NE(result.error().message.find("9x8"), std::string::npos) << result.error().message;
  segmenter.observe(cv::Mat(9, 9, CV_32F, cv::Scalar(1)), {});
  segmenter.observe({}, {});
  EXPECT_EQ(segmenter.classes().frames, 0u);
  EXPECT_FALSE(
      TwoClassSegmenter::check({.p_ice_if_ice = 0.4, .p_ice_if_water = 0.4, .close_px = 0}).ok());
  EXPECT_FALSE(
      TwoClassSegmenter::check({.p_ice_if_ice = 0.7, .p_ice_if_water = 0.0, .close_px = 0}).ok());
}

TEST(OtsuSegmenter, SurvivesTheSmallestImages) {
  OtsuSegmenter segmenter;
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 300), cv::Size(300, 1), cv::Size(9, 9)}) {
    cv::Mat image(size, CV_8U);
    cv::randu(image, 0, 255);
    segmenter.observe(image, {});
    EXPECT_EQ(segmenter.segment(image, {}).value().size(), size);
    EXPECT_EQ(OtsuSegmenter().segment(image, {}).value().size(), size);
  }
}

TEST(OtsuSegmenter, SegmentsAlikeFromSeveralThreads) {
  cv::RNG rng(18);
  OtsuSegmenter segmenter;
  std::vector<cv::Mat> images, alone, together(8);
  for (int i = 0; i < 8; ++i) {
    images.push_back(frame(rng, floes(rng, kFrame, 0.08 * i), 90, 40, 8));
    segmenter.observe(images.back(), {});
  }
  for (const auto& image : images) alone.push_back(ice_found(segmenter, image));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 8; ++i)
    threads.emplace_back([&, i] { together[i] = ice_found(segmenter, images[i]); });
  for (auto& thread : threads) thread.join();
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(cv::norm(alone[i], together[i], cv::NORM_INF), 0.0);
}

TEST(OtsuSegmenter, DoesNotKnowAFrameOfWhichAMaskLeavesAFewPixels) {
  cv::Mat image(128, 128, CV_8U, cv::Scalar(60));
  image.colRange(0, 64) = 200;
  OtsuSegmenter segmenter({}, IcePolarity::Brighter);
  segmenter.observe(image, cv::Mat());
  cv::Mat valid = cv::Mat::zeros(image.size(), CV_8U);
  valid.at<uchar>(5, 5) = 255;
  const cv::Mat p = segmenter.segment(image, valid).value();
  EXPECT_TRUE(std::isnan(p.at<float>(5, 5)));
  EXPECT_TRUE(std::isnan(p.at<float>(6, 5)));
}

}  // namespace
}  // namespace watersky
