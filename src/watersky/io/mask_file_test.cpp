// SPDX-License-Identifier: MIT
#include "watersky/io/mask_file.hpp"

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "support/temporary_folder.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

cv::Mat mask(const std::vector<unsigned char>& values) { return cv::Mat(values, true).reshape(1, 1); }
cv::Mat ice(const std::vector<unsigned char>& values, MaskValues meaning, PondIs pond) {
  return ice_in_mask(mask(values), meaning, pond).value();
}
bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

TEST(MaskFile, ClassesArePondIceOcean) {
  EXPECT_TRUE(same(ice({0, 1, 2}, MaskValues::Auto, PondIs::Water), mask({0, 255, 0})));
  EXPECT_TRUE(same(ice({0, 1, 2}, MaskValues::Auto, PondIs::Ice), mask({255, 255, 0})));
  EXPECT_TRUE(same(ice({0, 1, 1}, MaskValues::Classes, PondIs::Ice), mask({255, 255, 255})));
}

TEST(MaskFile, BinaryIsKnownByIts255) {
  for (const auto pond : {PondIs::Water, PondIs::Ice})
    EXPECT_TRUE(same(ice({0, 255, 0}, MaskValues::Auto, pond), mask({0, 255, 0})));
  EXPECT_TRUE(same(ice({0, 1, 7}, MaskValues::Binary, PondIs::Ice), mask({0, 255, 255})));
}

TEST(MaskFile, NamesAValueThatIsNoClassAndItsPlace) {
  const auto classes = ice_in_mask(mask({0, 1, 3}), MaskValues::Auto, PondIs::Water);
  ASSERT_FALSE(classes);
  EXPECT_THAT(classes.error().message, HasSubstr("value 3 in row 0, column 2"));
  EXPECT_THAT(classes.error().message, HasSubstr("binary"));
  const auto lossy = ice_in_mask(mask({0, 255, 254}), MaskValues::Auto, PondIs::Water);
  ASSERT_FALSE(lossy);
  EXPECT_THAT(lossy.error().message, HasSubstr("254"));
  EXPECT_FALSE(ice_in_mask(mask({0, 255}), MaskValues::Classes, PondIs::Water));
}

TEST(MaskFile, ReadsOneChannelOrThreeThatAreEqual) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "m.png";
  cv::Mat values(3, 4, CV_8U, cv::Scalar(1));
  values.at<unsigned char>(2, 3) = 2;
  ASSERT_TRUE(cv::imwrite(file.string(), values));
  EXPECT_TRUE(same(read_mask(file, {4, 3}).value(), values));
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>{values, values, values}, three);
  ASSERT_TRUE(cv::imwrite(file.string(), three));
  EXPECT_TRUE(same(read_mask(file, {4, 3}).value(), values));
  three.at<cv::Vec3b>(0, 0) = {1, 2, 1};
  ASSERT_TRUE(cv::imwrite(file.string(), three));
  EXPECT_THAT(read_mask(file, {4, 3}).error().message, HasSubstr("colours"));
}

TEST(MaskFile, RefusesWhatIsNoMaskOfTheImage) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "m.png";
  ASSERT_TRUE(cv::imwrite(file.string(), cv::Mat(3, 4, CV_8U, cv::Scalar(1))));
  const auto size = read_mask(file, {5, 3});
  EXPECT_EQ(size.error().code, ErrorCode::InvalidInput);
  EXPECT_THAT(size.error().message, HasSubstr("4x3"));
  EXPECT_THAT(size.error().message, HasSubstr("5x3"));
  ASSERT_TRUE(cv::imwrite(file.string(), cv::Mat(3, 4, CV_16U, cv::Scalar(1))));
  EXPECT_EQ(read_mask(file, {4, 3}).error().code, ErrorCode::Unsupported);
  EXPECT_EQ(read_mask(folder.path() / "none.png", {4, 3}).error().code, ErrorCode::NotFound);
}

TEST(MaskFile, FindsAnImagesMask) {
  const test::TemporaryFolder folder;
  const fs::path masks = folder.path() / "masks";
  fs::create_directory(masks);
  const cv::Mat any(3, 4, CV_8U, cv::Scalar(1));
  for (const char* name : {"a.png", "b.tif"})
    ASSERT_TRUE(cv::imwrite((masks / name).string(), any));
  EXPECT_EQ(find_mask("x/a.png", {masks}, false).value(), masks / "a.png");
  EXPECT_EQ(find_mask("x/b.jpg", {masks}, false).value(), masks / "b.tif");
  EXPECT_EQ(find_mask("x/b.jpg", {masks / "a.png", masks / "b.tif"}, false).value(),
            masks / "b.tif");
  EXPECT_EQ(find_mask("x/c.png", {masks}, false).error().code, ErrorCode::NotFound);
  // One image, one file: that is it, whatever it is called.
  EXPECT_EQ(find_mask("x/c.png", {masks / "a.png"}, true).value(), masks / "a.png");
  EXPECT_EQ(find_mask("x/c.png", {masks / "a.png"}, false).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(cv::imwrite((masks / "b.png").string(), any));
  EXPECT_EQ(find_mask("x/b.jpg", {masks}, false).error().code, ErrorCode::InvalidInput);
}

}  // namespace
}  // namespace watersky
