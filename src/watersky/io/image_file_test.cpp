// SPDX-License-Identifier: MIT
#include "watersky/io/image_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "support/make_photo.hpp"

namespace watersky {
namespace {

using ::testing::HasSubstr;
using watersky::test::Bytes;
using watersky::test::make_photo;
using watersky::test::TemporaryFolder;

/// Smooth, different in u and v, so that a shift or a transpose shows.
cv::Mat ramp(int width, int height) {
  cv::Mat m(height, width, CV_8UC3);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      m.at<cv::Vec3b>(v, u) = {static_cast<std::uint8_t>(20 + 200 * u / width),
                               static_cast<std::uint8_t>(20 + 200 * v / height),
                               static_cast<std::uint8_t>(128)};
  return m;
}

double mean_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) /
         static_cast<double>(a.total() * static_cast<std::size_t>(a.channels()));
}

TEST(ImageFile, AJpegIsWhatOpenCvMakesOfIt) {
  const Bytes jpeg = make_photo({}, ramp(320, 200));
  const cv::Mat ours = decode_image(jpeg, {}, "x").value();
  EXPECT_LT(mean_difference(ours, cv::imdecode(jpeg, cv::IMREAD_COLOR)), 0.5);
  const cv::Mat gray = decode_image(jpeg, {.color = false}, "x").value();
  EXPECT_EQ(gray.type(), CV_8UC1);
  EXPECT_LT(mean_difference(gray, cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE)), 0.5);
}

// What CameraModel::reduced_by assumes: pixel centre u' of the reduced image sees what
// (u' + ½) n - ½ saw, whether or not the size is a multiple of n.
TEST(ImageFile, APixelOfAReducedJpegIsAWholeBlock) {
  for (const auto& [w, h] : {std::pair{320, 200}, {325, 203}, {331, 250}}) {
    const cv::Mat full = ramp(w, h);
    const Bytes jpeg = make_photo({}, full);
    for (int r : {1, 2, 4, 8}) {
      const cv::Mat small = decode_image(jpeg, {.reduction = r}, "x").value();
      EXPECT_EQ(small.cols, (w + r - 1) / r);
      EXPECT_EQ(small.rows, (h + r - 1) / r);
      double worst_u = 0, worst_v = 0;
      for (int v = 2; v + 2 < small.rows; ++v)
        for (int u = 2; u + 2 < small.cols; ++u) {
          const cv::Vec3b got = small.at<cv::Vec3b>(v, u);
          const double fu = (u + 0.5) * r - 0.5, fv = (v + 0.5) * r - 0.5;
          worst_u = std::max(worst_u, std::abs(got[0] - (20 + 200 * fu / w)));
          worst_v = std::max(worst_v, std::abs(got[1] - (20 + 200 * fv / h)));
        }
      // 4 grey levels are 6 pixels of 325: a whole reduced pixel of shift would show at r = 8.
      EXPECT_LT(worst_u, 4.0) << w << " / " << r;
      EXPECT_LT(worst_v, 4.0) << h << " / " << r;
    }
  }
}

TEST(ImageFile, AJpegCutShortIsAnErrorAndNeverHalfAPicture) {
  std::mt19937 rng(5);
  const Bytes jpeg = make_photo({}, ramp(160, 120));
  for (int i = 0; i < 200; ++i) {
    const auto n = std::uniform_int_distribution<std::size_t>(0, jpeg.size() - 3)(rng);
    EXPECT_FALSE(decode_image(std::span(jpeg).first(n), {}, "cut.jpg"))
        << n << " of " << jpeg.size();
    EXPECT_FALSE(
        decode_image(std::span(jpeg).first(n), {.color = false, .reduction = 8}, "cut.jpg"))
        << n;
  }
  EXPECT_THAT(decode_image(std::span(jpeg).first(jpeg.size() / 2), {}, "cut.jpg").error().message,
              HasSubstr("cut.jpg: is damaged or cut short"));
}

TEST(ImageFile, PaddingBehindAJpegDoesNoHarm) {
  Bytes jpeg = make_photo({}, ramp(64, 48));
  jpeg.resize(jpeg.size() + 5000, 0);
  EXPECT_TRUE(decode_image(jpeg, {}, "padded.jpg"));
}

TEST(ImageFile, KeepsSixteenBitsOfPngAndTiff) {
  cv::Mat thermal(37, 53, CV_16UC1);
  cv::randu(thermal, 0, 65536);
  for (const char* extension : {".png", ".tiff"}) {
    Bytes bytes;
    cv::imencode(extension, thermal, bytes);
    const cv::Mat back = decode_image(bytes, {}, "x").value();
    EXPECT_EQ(back.type(), CV_16UC1);
    EXPECT_EQ(cv::norm(back, thermal, cv::NORM_INF), 0);
  }
}

TEST(ImageFile, DamagedPngAndTiffAreErrors) {
  cv::Mat thermal(200, 300, CV_16UC1);
  cv::randu(thermal, 0, 65536);
  for (const char* extension : {".png", ".tiff"}) {
    Bytes bytes;
    cv::imencode(extension, thermal, bytes);
    EXPECT_FALSE(decode_image(std::span(bytes).first(bytes.size() / 2), {}, "x")) << extension;
  }
  const Bytes text = {'h', 'e', 'l', 'l', 'o', ' ', 'i', 'c', 'e'};
  EXPECT_FALSE(decode_image(text, {}, "x"));
  EXPECT_FALSE(decode_image({}, {}, "x"));
}

TEST(ImageFile, DropsAlphaAndRefusesFloats) {
  cv::Mat bgra(8, 8, CV_8UC4, cv::Scalar(1, 2, 3, 4));
  Bytes bytes;
  cv::imencode(".png", bgra, bytes);
  EXPECT_EQ(decode_image(bytes, {}, "x").value().type(), CV_8UC3);
  cv::imencode(".tiff", cv::Mat(8, 8, CV_32FC1, cv::Scalar(1.5)), bytes);
  EXPECT_EQ(decode_image(bytes, {}, "x").error().code, ErrorCode::Unsupported);
}

TEST(ImageFile, ProbesTheSizeOfEachFormat) {
  const TemporaryFolder folder;
  const cv::Mat image = ramp(123, 77);
  watersky::test::write(folder.path() / "a.JPG", make_photo({}, image));
  for (const char* name : {"b.png", "c.tif"}) {
    Bytes bytes;
    cv::imencode(std::filesystem::path(name).extension().string(), image, bytes);
    watersky::test::write(folder.path() / name, bytes);
  }
  watersky::test::write(folder.path() / "._a.JPG", std::string("a Macintosh was here"));
  watersky::test::write(folder.path() / "notes.txt", std::string("x"));
  const auto files = list_images(folder.path()).value();
  ASSERT_EQ(files.size(), 3u);
  for (const auto& file : files)
    EXPECT_EQ(probe_image_size(file).value(), (ImageSize{123, 77})) << file;
  EXPECT_FALSE(probe_image_size(folder.path() / "notes.txt"));
  EXPECT_FALSE(probe_image_size(folder.path() / "absent.jpg"));
}

TEST(ImageLoader, RefusesAnotherSizeThanTheCameras) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.jpg";
  watersky::test::write(file, make_photo({}, ramp(125, 83)));
  EXPECT_TRUE(image_loader(file, ImageSize{125, 83})({}));
  EXPECT_TRUE(image_loader(file, ImageSize{125, 83})({.reduction = 4}));
  const auto wrong = image_loader(file, ImageSize{640, 512})({});
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("125x83"));
  EXPECT_FALSE(image_loader(folder.path() / "absent.jpg")({}));
}

}  // namespace
}  // namespace watersky
