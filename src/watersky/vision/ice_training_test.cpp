// SPDX-License-Identifier: MIT
#include "watersky/vision/ice_training.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "watersky/vision/detail/drawn_scene.hpp"
#include "watersky/vision/detail/test_frames.hpp"
#include "watersky/vision/learned_segmenter.hpp"

namespace watersky {
namespace {

using namespace test;
using ::testing::HasSubstr;

/// Floes with their masks.
std::vector<LabelledImage> labelled(int count) {
  cv::RNG rng(3);
  std::vector<LabelledImage> images;
  for (int i = 0; i < count; ++i) {
    const cv::Mat ice = floes(rng, kFrame, 0.2 + 0.1 * i);
    cv::Mat mask(kFrame, CV_8U, cv::Scalar(static_cast<int>(IceClass::Water)));
    mask.setTo(static_cast<int>(IceClass::Ice), ice);
    images.push_back({"image " + std::to_string(i), frame(rng, ice, 90, 60, 8), mask});
  }
  return images;
}

constexpr TrainingParameters kQuick{.variants = 3, .drawn = 6, .samples = 300, .passes = 6};

TEST(IceTraining, LearnsWhatItIsShown) {
  const auto images = labelled(4);
  const auto model = train_ice_model(std::span(images).first(3), kQuick);
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_FALSE(model->colour);
  EXPECT_THAT(model->gray_origin, HasSubstr("3 images"));
  const LearnedSegmenter segmenter({}, SegmentationQuality::Standard, IcePolarity::Brighter,
                                   *model);
  EXPECT_LT(error(ice_found(segmenter, images[3].image), images[3].mask == 1), 0.05);
}

TEST(IceTraining, IsReproducible) {
  const auto images = labelled(3);
  EXPECT_EQ(format_ice_model(train_ice_model(images, kQuick).value()),
            format_ice_model(train_ice_model(images, kQuick).value()));
  TrainingParameters other = kQuick;
  other.seed = 2;
  EXPECT_NE(format_ice_model(train_ice_model(images, kQuick).value()),
            format_ice_model(train_ice_model(images, other).value()));
}

TEST(IceTraining, KeepsTheKindThatTheImagesAreNotOf) {
  const auto images = labelled(3);
  const IceModel model = train_ice_model(images, kQuick, IceModel::shipped()).value();
  ASSERT_TRUE(model.colour);
  EXPECT_EQ(model.colour_origin, IceModel::shipped().colour_origin);
  EXPECT_NE(model.gray_origin, IceModel::shipped().gray_origin);
}

TEST(IceTraining, NamesTheImageThatIsAtFault) {
  auto images = labelled(3);
  images[1].mask = images[1].mask.rowRange(0, 200).clone();
  EXPECT_THAT(train_ice_model(images, kQuick).error().message,
              AllOf(HasSubstr("image 1"), HasSubstr("320x200"), HasSubstr("320x256")));
  images = labelled(3);
  images[2].mask.at<unsigned char>(4, 7) = 99;
  EXPECT_THAT(train_ice_model(images, kQuick).error().message,
              AllOf(HasSubstr("image 2"), HasSubstr("99"), HasSubstr("column 7, row 4")));
  images = labelled(3);
  images[0].image.setTo(80);
  EXPECT_THAT(train_ice_model(images, kQuick).error().message, HasSubstr("image 0"));
  for (auto& image : images = labelled(3)) image.mask.setTo(static_cast<int>(IceClass::Ice));
  EXPECT_FALSE(train_ice_model(images, kQuick).ok()) << "ice alone teaches nothing";
  EXPECT_FALSE(train_ice_model({}, kQuick).ok());
}

TEST(DrawnScene, ShowsEveryConcentrationAndOnlyKnownClasses) {
  cv::RNG rng(5);
  double least = 1.0, most = 0.0;
  for (int i = 0; i < 60; ++i) {
    const detail::DrawnScene scene = detail::draw_scene({96, 80}, i % 2 == 1, rng);
    ASSERT_EQ(scene.image.type(), i % 2 == 1 ? CV_32FC3 : CV_32FC1);
    ASSERT_EQ(scene.image.size(), cv::Size(96, 80));
    EXPECT_TRUE(cv::checkRange(scene.image));
    double highest = 0.0;
    cv::minMaxLoc(scene.mask, nullptr, &highest);
    EXPECT_LE(highest, static_cast<int>(IceClass::Water));
    const double share = fraction(scene.mask == static_cast<int>(IceClass::Ice));
    least = std::min(least, share);
    most = std::max(most, share);
  }
  EXPECT_LT(least, 0.15);
  EXPECT_GT(most, 0.85);
}

}  // namespace
}  // namespace watersky
