// SPDX-License-Identifier: MIT
#include "watersky/vision/ice_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "watersky/vision/learned_segmenter.hpp"

namespace watersky {
namespace {

using ::testing::HasSubstr;

TEST(IceModel, TheShippedOneReadsAndWritesTheSame) {
  const IceModel& shipped = IceModel::shipped();
  ASSERT_TRUE(shipped.gray && shipped.colour);
  EXPECT_EQ(shipped.name, "shipped");
  EXPECT_THAT(shipped.gray_origin, HasSubstr("images"));
  const std::string text = format_ice_model(shipped);
  const auto again = parse_ice_model(text, "again");
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(format_ice_model(*again), text);
}

TEST(IceModel, MayHoldOneKindOnly) {
  IceModel gray_only = IceModel::shipped();
  gray_only.colour.reset();
  const auto read = parse_ice_model(format_ice_model(gray_only), "gray");
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(read->gray);
  EXPECT_FALSE(read->colour);
  cv::Mat colour(40, 40, CV_8UC3);
  cv::randu(colour, 0, 255);
  const LearnedSegmenter segmenter({}, SegmentationQuality::Standard, IcePolarity::Auto, *read);
  const auto p = segmenter.segment(colour, {});
  ASSERT_FALSE(p.ok());
  EXPECT_EQ(p.error().code, ErrorCode::Unsupported);
  EXPECT_THAT(p.error().message, HasSubstr("segment train"));
}

// Wherever a copy stops, it is told; never is half a model taken for one.
TEST(IceModel, CutShortIsRefused) {
  const std::string text = format_ice_model(IceModel::shipped());
  for (std::size_t size = 0; size < text.size(); size += size < 2000 ? 7 : 1013) {
    const auto read = parse_ice_model(std::string_view(text).substr(0, size), "short.ice-model");
    ASSERT_FALSE(read.ok()) << size;
    EXPECT_THAT(read.error().message, HasSubstr("short.ice-model"));
  }
  EXPECT_THAT(
      parse_ice_model(std::string_view(text).substr(0, text.size() / 2), "m").error().message,
      HasSubstr("cut short"));
}

TEST(IceModel, DamagedIsRefused) {
  const std::string text = format_ice_model(IceModel::shipped());
  for (const std::size_t at :
       {std::size_t{25}, text.size() / 3, text.size() / 2, text.size() - 3}) {
    std::string damaged = text;
    damaged[at] = damaged[at] == '7' ? '8' : '7';
    EXPECT_FALSE(parse_ice_model(damaged, "m").ok()) << at;
  }
}

TEST(IceModel, AnotherVersionIsUnsupportedAndSaysSo) {
  std::string text = format_ice_model(IceModel::shipped());
  text.replace(text.find("model 1"), 7, "model 9");
  const auto format = parse_ice_model(text, "m");
  ASSERT_FALSE(format.ok());
  EXPECT_EQ(format.error().code, ErrorCode::Unsupported);
  EXPECT_THAT(format.error().message, HasSubstr("version"));
}

TEST(IceModel, OtherFilesAreNotModels) {
  for (const char* text : {"", "\n", "%YAML:1.0\n---\n", "watersky ice model", "\x89PNG\r\n"}) {
    const auto read = parse_ice_model(text, "photo.png");
    ASSERT_FALSE(read.ok());
    EXPECT_THAT(read.error().message, HasSubstr("photo.png"));
  }
}

}  // namespace
}  // namespace watersky
