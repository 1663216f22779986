// SPDX-License-Identifier: MIT
/// Laws that every method keeps, and those of the two-class methods.
#include "watersky/vision/segmentation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <thread>

#include "watersky/vision/detail/test_frames.hpp"

namespace watersky {
namespace {

using namespace test;
using ::testing::HasSubstr;

class EveryMethod : public ::testing::TestWithParam<SegmentationMethod> {
 protected:
  [[nodiscard]] static std::unique_ptr<Segmenter> make(IcePolarity ice = IcePolarity::Auto,
                                                       const TwoClassEvidence& evidence = {}) {
    SegmentationParameters parameters;
    parameters.evidence = evidence;
    return make_segmenter(GetParam(), parameters, ice).value();
  }
  [[nodiscard]] static cv::Mat found(IcePolarity ice, const cv::Mat& image, int close_px = 0) {
    const auto segmenter =
        make(ice, {.p_ice_if_ice = 0.7, .p_ice_if_water = 0.4, .close_px = close_px});
    return ice_found(*segmenter, image);
  }
};

/// Methods that split an image in two and nothing else.
class TwoClassMethod : public EveryMethod {};

std::vector<SegmentationMethod> two_class_methods() {
  std::vector<SegmentationMethod> methods;
  for (const SegmentationMethod method : segmentation_methods())
    if (!is_learned(method)) methods.push_back(method);
  return methods;
}

std::string test_name(const ::testing::TestParamInfo<SegmentationMethod>& method) {
  std::string name(name_of(method.param));
  std::erase(name, '-');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Segmentation, EveryMethod,
                         ::testing::ValuesIn(segmentation_methods().begin(),
                                             segmentation_methods().end()),
                         test_name);
INSTANTIATE_TEST_SUITE_P(Segmentation, TwoClassMethod, ::testing::ValuesIn(two_class_methods()),
                         test_name);

TEST_P(EveryMethod, FindsFloesWithinTwoPercent) {
  cv::RNG rng(1);
  for (const double fraction : {0.1, 0.3, 0.5}) {
    const cv::Mat ice = floes(rng, kFrame, fraction);
    for (const int type : {CV_8U, CV_16U}) {
      const cv::Mat image = frame(rng, ice, 90, 60, 8, type);
      EXPECT_LT(error(found(IcePolarity::Brighter, image), ice), 0.02) << fraction;
    }
  }
}

TEST_P(EveryMethod, InvertedImagesInvertWithThePolarity) {
  cv::RNG rng(2);
  for (int i = 0; i < 5; ++i) {
    const cv::Mat image = frame(rng, floes(rng, kFrame, 0.1 + 0.1 * i), 90, 60, 8);
    EXPECT_LT(error(found(IcePolarity::Brighter, image), found(IcePolarity::Darker, 255 - image)),
              0.003);
  }
}

TEST_P(TwoClassMethod, WithTheWrongPolarityWaterIsWhatWasIce) {
  cv::RNG rng(2);
  const cv::Mat image = frame(rng, floes(rng, kFrame, 0.3), 90, 60, 8);
  EXPECT_EQ(fraction(found(IcePolarity::Brighter, image) ^ found(IcePolarity::Darker, image)), 1.0);
}

TEST_P(EveryMethod, GainAndOffsetDoNotMatter) {
  cv::RNG rng(3);
  for (int i = 0; i < 5; ++i) {
    const cv::Mat image = frame(rng, floes(rng, kFrame, 0.1 + 0.1 * i), 60, 60, 6);
    const cv::Mat here = found(IcePolarity::Darker, image);
    cv::Mat deep;
    for (const auto& [gain, offset] : {std::pair{256.0, 0.0}, {3.0, 21000.0}, {200.0, 500.0}}) {
      image.convertTo(deep, CV_16U, gain, offset);
      EXPECT_LT(error(here, found(IcePolarity::Darker, deep)), 0.002) << gain << " " << offset;
    }
  }
}

TEST_P(TwoClassMethod, ClosingOnlyAddsIceWhateverThePolarity) {
  cv::RNG rng(4);
  for (const auto ice : {IcePolarity::Brighter, IcePolarity::Darker}) {
    const cv::Mat image = frame(rng, floes(rng, kFrame, 0.3), 90, 25, 8);
    const cv::Mat open = found(ice, image), closed = found(ice, image, 5);
    EXPECT_EQ(cv::countNonZero(open & ~closed), 0);
    EXPECT_GT(cv::countNonZero(closed), cv::countNonZero(open));
    // Closing twice is closing once.
    cv::Mat again;
    cv::morphologyEx(closed, again, cv::MORPH_CLOSE,
                     cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
    EXPECT_EQ(cv::norm(again, closed, cv::NORM_INF), 0.0);
  }
}

TEST_P(TwoClassMethod, GivesP1AndP2AndNothingElse) {
  cv::RNG rng(5);
  const cv::Mat image = frame(rng, floes(rng, kFrame, 0.3), 90, 60, 8);
  const cv::Mat p =
      make(IcePolarity::Brighter, {.p_ice_if_ice = 0.9, .p_ice_if_water = 0.2, .close_px = 0})
          ->segment(image, {})
          .value();
  for (const float value : cv::Mat_<float>(p)) EXPECT_TRUE(value == 0.9F || value == 0.2F);
}

TEST_P(EveryMethod, WithoutContrastKnowsNothing) {
  cv::RNG rng(6);
  const auto segmenter = make(IcePolarity::Brighter);
  for (const int type : {CV_8U, CV_16U}) {
    const double full = type == CV_8U ? 255 : 65535;
    for (const double level : {0.0, 0.4 * full, full})  // black, gray, saturated
      EXPECT_EQ(
          known_fraction(segmenter->segment(cv::Mat(kFrame, type, cv::Scalar(level)), {}).value()),
          0.0);
    for (const double sigma : {0.5, 2.0, 8.0, 25.0}) {
      const cv::Mat noise = frame(rng, cv::Mat::zeros(kFrame, CV_8U), 120, 0, sigma, type);
      const Result<cv::Mat> p = segmenter->segment(noise, {});
      EXPECT_EQ(known_fraction(p.value()), 0.0) << sigma;
      EXPECT_THAT(segmenter->findings_of(noise, {}).notes.at(0), HasSubstr("no contrast"));
    }
  }
}

// Contrast of 60 levels in noise of 4, through ever thicker fog. What is answered is mostly
// right; where contrast is a quarter of the noise nothing is answered.
TEST_P(EveryMethod, UnderFogIsRightOrSilent) {
  cv::RNG rng(7);
  const auto segmenter = make(IcePolarity::Brighter);
  for (int i = 0; i < 4; ++i) {
    const cv::Mat ice = floes(rng, kFrame, 0.3 + 0.05 * i);
    const cv::Mat clear = frame(rng, ice, 90, 60, 2);
    for (const double transmission : {1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.08, 0.05, 0.0}) {
      const cv::Mat p = segmenter->segment(fogged(rng, clear, transmission, 4.0), {}).value();
      const double answered = known_fraction(p);
      if (transmission >= 0.25) {
        EXPECT_EQ(answered, 1.0) << transmission;
      }
      if (transmission == 0.0) {
        EXPECT_EQ(answered, 0.0);
      }
      if (answered > 0.0) {
        EXPECT_LT(error(p > 0.5, ice), 0.38) << transmission;
      }
      if (answered > 0.0 && transmission >= 0.25) {
        EXPECT_LT(error(p > 0.5, ice), 0.07) << transmission;
      }
    }
  }
}

TEST_P(EveryMethod, KnowsNothingOutsideTheValidPart) {
  cv::RNG rng(8);
  const cv::Mat ice = floes(rng, kFrame, 0.3);
  cv::Mat image = frame(rng, ice, 90, 60, 8);
  cv::Mat valid(kFrame, CV_8U, cv::Scalar(1));
  valid.colRange(0, 100).setTo(0);
  image.colRange(0, 100).setTo(255);
  for (const bool observed : {false, true}) {
    const auto segmenter =
        make(IcePolarity::Brighter, {.p_ice_if_ice = 0.7, .p_ice_if_water = 0.4, .close_px = 5});
    if (observed) segmenter->observe(image, valid);
    const cv::Mat p = segmenter->segment(image, valid).value();
    EXPECT_EQ(cv::countNonZero(known(p) != (valid != 0)), 0);
    EXPECT_LT(error(cv::Mat(p > 0.5).colRange(103, 320), ice.colRange(103, 320)), 0.02);
  }
  valid.setTo(0);
  EXPECT_EQ(known_fraction(make()->segment(image, valid).value()), 0.0);
}

TEST_P(EveryMethod, AFlightTellsItsFramesOfOneClass) {
  cv::RNG rng(9);
  const auto segmenter = make(IcePolarity::Brighter);
  for (const double f : {0.2, 0.4, 0.0, 0.5, 0.3})
    segmenter->observe(frame(rng, floes(rng, kFrame, f), 90, 40, 8), {});
  const cv::Mat none = cv::Mat::zeros(kFrame, CV_8U);
  EXPECT_LT(fraction(ice_found(*segmenter, frame(rng, none, 90, 40, 8))), 0.01);
  EXPECT_GT(fraction(ice_found(*segmenter, frame(rng, ~none, 90, 40, 8))), 0.99);
  // Fog halfway between them is neither.
  const cv::Mat fog = frame(rng, none, 110, 0, 8);
  EXPECT_EQ(known_fraction(segmenter->segment(fog, {}).value()), 0.0);
  EXPECT_THAT(segmenter->findings_of(fog, {}).notes.at(0), HasSubstr("one class"));
}

TEST_P(EveryMethod, TakesColour) {
  cv::RNG rng(10);
  const cv::Mat ice = floes(rng, kFrame, 0.3);
  cv::Mat color(kFrame, CV_8UC3, cv::Scalar(90, 70, 30));
  color.setTo(cv::Scalar(225, 215, 205), ice);
  cv::Mat noise(kFrame, CV_8UC3);
  rng.fill(noise, cv::RNG::UNIFORM, 0, 20);
  color += noise;
  const auto segmenter = make();
  EXPECT_LT(error(ice_found(*segmenter, color), ice), 0.02);
  ASSERT_TRUE(segmenter->findings_of(color, {}).polarity);
  EXPECT_EQ(segmenter->findings_of(color, {}).polarity->polarity, IcePolarity::Brighter);
}

TEST_P(EveryMethod, RefusesWhatItDoesNotTakeAndSurvivesTheSmallest) {
  const auto segmenter = make();
  EXPECT_EQ(segmenter->segment({}, {}).error().code, ErrorCode::InvalidInput);
  EXPECT_EQ(segmenter->segment(cv::Mat(9, 9, CV_32F, cv::Scalar(1)), {}).error().code,
            ErrorCode::Unsupported);
  EXPECT_EQ(segmenter->segment(cv::Mat(9, 9, CV_8UC4, cv::Scalar(1)), {}).error().code,
            ErrorCode::Unsupported);
  const cv::Mat nine(9, 9, CV_8U, cv::Scalar(1));
  EXPECT_EQ(segmenter->segment(nine, cv::Mat(8, 9, CV_8U, cv::Scalar(1))).error().code,
            ErrorCode::InvalidInput);
  EXPECT_TRUE(segmenter->findings_of({}, {}).notes.empty());
  for (const cv::Size size : {cv::Size(1, 1), {1, 300}, {300, 1}, {9, 9}, {10, 11}, {12, 40}})
    for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3, CV_16UC3}) {
      cv::Mat image(size, type);
      cv::randu(image, 0, 255);
      image.rowRange(0, (image.rows + 1) / 2) *= 0.3;
      EXPECT_EQ(segmenter->segment(image, {}).value().size(), size);
      const auto flight = make();
      flight->observe(image, {});
      EXPECT_EQ(flight->segment(image, {}).value().size(), size);
    }
}

TEST_P(EveryMethod, SegmentsAlikeFromSeveralThreads) {
  cv::RNG rng(11);
  const auto segmenter = make();
  std::vector<cv::Mat> images, alone, together(6);
  for (int i = 0; i < 6; ++i) {
    images.push_back(frame(rng, floes(rng, kFrame, 0.1 + 0.08 * i), 90, 50, 8));
    alone.push_back(ice_found(*segmenter, images.back()));
  }
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 6; ++i)
    threads.emplace_back([&, i] { together[i] = ice_found(*segmenter, images[i]); });
  for (auto& thread : threads) thread.join();
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(cv::norm(alone[i], together[i], cv::NORM_INF), 0.0);
}

TEST(Segmentation, NamesFindTheirMethods) {
  for (const SegmentationMethod method : segmentation_methods())
    EXPECT_EQ(segmentation_method(name_of(method)).value(), method);
  const auto unheard = segmentation_method("magic");
  EXPECT_EQ(unheard.error().code, ErrorCode::Usage);
  EXPECT_THAT(unheard.error().message, HasSubstr("local-otsu"));
  EXPECT_EQ(ice_polarity("darker").value(), IcePolarity::Darker);
  EXPECT_EQ(ice_polarity("bright").error().code, ErrorCode::Usage);
}

TEST(Segmentation, ParametersOutOfRangeAreNamed) {
  SegmentationParameters parameters;
  parameters.local_otsu.radius_px = 0;
  const auto made = make_segmenter(SegmentationMethod::LocalOtsu, parameters);
  EXPECT_EQ(made.error().code, ErrorCode::Usage);
  EXPECT_THAT(made.error().message, HasSubstr("local_radius_px"));
}

TEST(Segmentation, EveryParameterHasANameOfItsOwn) {
  std::vector<std::string> names;
  const SegmentationParameters parameters;
  SegmentationParameters::describe(parameters, [&](const auto&, const auto& info) {
    EXPECT_EQ(std::count(names.begin(), names.end(), info.name), 0) << info.name;
    names.emplace_back(info.name);
  });
}

}  // namespace
}  // namespace watersky
