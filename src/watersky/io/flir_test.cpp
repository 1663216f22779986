// SPDX-License-Identifier: MIT
#include "watersky/io/flir.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/real_data.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"

namespace watersky {
namespace {

using Bytes = std::vector<std::uint8_t>;

void put(Bytes& out, std::size_t at, std::uint64_t value, int size, bool big) {
  if (out.size() < at + static_cast<std::size_t>(size))
    out.resize(at + static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i)
    out[at + static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(value >> 8 * (big ? size - 1 - i : i));
}
void put_float(Bytes& out, std::size_t at, float value, bool big) {
  put(out, at, std::bit_cast<std::uint32_t>(value), 4, big);
}

struct Made {
  bool big_directory = true, big_records = false, png = false, planck = true;
  std::size_t chunk = 60000;
};

/// Counts as a camera of 100 mK noise over ice would give them.
cv::Mat scene(int width = 48, int height = 40) {
  cv::Mat counts(height, width, CV_16U);
  cv::RNG rng(1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      counts.at<ushort>(y, x) =
          static_cast<ushort>(13000 + (x > 20 ? 900 : 0) + rng.uniform(0, 30));
  return counts;
}

Bytes raw_record(const cv::Mat& counts, const Made& made) {
  Bytes r;
  put(r, 0, 2, 2, made.big_records);
  put(r, 2, counts.cols, 2, made.big_records);
  put(r, 4, counts.rows, 2, made.big_records);
  r.resize(0x20);
  if (made.png) {
    cv::Mat swapped = counts.clone();  // as FLIR's cameras write them
    for (auto& c : cv::Mat_<ushort>(swapped)) c = static_cast<ushort>(c << 8 | c >> 8);
    Bytes png;
    cv::imencode(".png", swapped, png);
    r.insert(r.end(), png.begin(), png.end());
    return r;
  }
  for (const ushort c : cv::Mat_<ushort>(counts)) put(r, r.size(), c, 2, made.big_records);
  return r;
}

Bytes camera_record(const Made& made) {
  Bytes r;
  put(r, 0x33c, 0, 4, made.big_records);
  put(r, 0, 2, 2, made.big_records);
  if (made.planck) {
    put_float(r, 0x58, 17096.453F, made.big_records);
    put_float(r, 0x5c, 1428.0F, made.big_records);
    put_float(r, 0x60, 1.0F, made.big_records);
    put(r, 0x308, static_cast<std::uint32_t>(-342), 4, made.big_records);
    put_float(r, 0x30c, 0.04651F, made.big_records);
  }
  const std::string_view model = "FLIR Tau 640";
  std::copy(model.begin(), model.end(), r.begin() + 0xd4);
  return r;
}

Bytes fff(const cv::Mat& counts, const Made& made) {
  const Bytes raw = raw_record(counts, made), camera = camera_record(made);
  Bytes out = {'F', 'F', 'F', 0};
  out.resize(0x40);
  const bool big = made.big_directory;
  put(out, 0x14, 101, 4, big);
  put(out, 0x18, 0x40, 4, big);
  put(out, 0x1c, 3, 4, big);
  const std::size_t first = 0x40 + 3 * 0x20;
  std::size_t at = 0x40 + 0x20;  // the first entry stays free
  std::size_t offset = first;
  for (const auto& [type, record] : {std::pair{0x01, &raw}, std::pair{0x20, &camera}}) {
    put(out, at, type, 2, big);
    put(out, at + 0x0c, offset, 4, big);
    put(out, at + 0x10, record->size(), 4, big);
    at += 0x20;
    offset += record->size();
  }
  out.resize(first);
  out.insert(out.end(), raw.begin(), raw.end());
  out.insert(out.end(), camera.begin(), camera.end());
  return out;
}

/// A JPEG of the picture with the FFF file in chunks behind its first marker.
Bytes radiometric_jpeg(const cv::Mat& counts, const Made& made, cv::Size picture) {
  Bytes jpeg;
  cv::imencode(".jpg", cv::Mat(picture, CV_8U, cv::Scalar(90)), jpeg);
  const Bytes file = fff(counts, made);
  const std::size_t chunks = (file.size() + made.chunk - 1) / made.chunk;
  Bytes segments;
  for (std::size_t i = 0; i < chunks; ++i) {
    const std::size_t from = i * made.chunk, size = std::min(made.chunk, file.size() - from);
    const Bytes head = {0xFF,
                        0xE1,
                        static_cast<std::uint8_t>((size + 10) >> 8),
                        static_cast<std::uint8_t>(size + 10),
                        'F',
                        'L',
                        'I',
                        'R',
                        0,
                        1,
                        static_cast<std::uint8_t>(i),
                        static_cast<std::uint8_t>(chunks - 1)};
    segments.insert(segments.end(), head.begin(), head.end());
    segments.insert(segments.end(), file.begin() + static_cast<std::ptrdiff_t>(from),
                    file.begin() + static_cast<std::ptrdiff_t>(from + size));
  }
  jpeg.insert(jpeg.begin() + 2, segments.begin(), segments.end());
  return jpeg;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(FlirJpeg, GivesItsCountsInEveryByteOrder) {
  const cv::Mat counts = scene();
  for (int i = 0; i < 16; ++i) {
    const Made made{.big_directory = (i & 1) != 0,
                    .big_records = (i & 2) != 0,
                    .png = (i & 4) != 0,
                    .chunk = (i & 8) != 0 ? 700U : 60000U};
    const auto image = find_flir_image(radiometric_jpeg(counts, made, {48, 40}), "a.jpg");
    ASSERT_TRUE(image.ok()) << image.error().message;
    ASSERT_TRUE(image->has_value());
    EXPECT_TRUE(equal((*image)->counts, counts)) << i;
    EXPECT_EQ((*image)->camera, "FLIR Tau 640");
    ASSERT_TRUE((*image)->scale);
    EXPECT_FLOAT_EQ(static_cast<float>((*image)->scale->r1), 17096.453F);
    EXPECT_EQ((*image)->scale->o, -342.0);
  }
}

TEST(FlirJpeg, StaysInCountsWithoutCalibration) {
  const auto image =
      find_flir_image(radiometric_jpeg(scene(), {.planck = false}, {48, 40}), "a.jpg").value();
  ASSERT_TRUE(image);
  EXPECT_FALSE(image->scale);
}

TEST(FlirJpeg, IsAFramesPixelsOnlyWhereBothAreOfOneSize) {
  const test::TemporaryFolder folder;
  const auto write = [&](const std::string& name, const Bytes& bytes) {
    EXPECT_TRUE(write_file(folder.path() / name,
                           {reinterpret_cast<const char*>(bytes.data()), bytes.size()})
                    .ok());
    return folder.path() / name;
  };
  const auto same = image_loader(write("same.jpg", radiometric_jpeg(scene(), {}, {48, 40})))({});
  ASSERT_TRUE(same.ok()) << same.error().message;
  EXPECT_TRUE(equal(*same, scene()));
  const auto other = image_loader(write("other.jpg", radiometric_jpeg(scene(), {}, {96, 80})))({});
  ASSERT_TRUE(other.ok()) << other.error().message;
  EXPECT_EQ(other->depth(), CV_8U);
}

TEST(FlirJpeg, OrdinaryOnesHaveNone) {
  Bytes jpeg;
  cv::imencode(".jpg", cv::Mat(40, 48, CV_8U, cv::Scalar(90)), jpeg);
  EXPECT_FALSE(find_flir_image(jpeg, "a.jpg").value());
  EXPECT_FALSE(find_flir_image({}, "a.jpg").value());
}

TEST(FlirJpeg, CutAnywhereIsRefusedOrHasNone) {
  const Bytes whole = radiometric_jpeg(scene(), {.chunk = 900}, {48, 40});
  for (std::size_t n = 0; n < 4600; n += 37) {
    const auto image = find_flir_image(std::span(whole).first(std::min(n, whole.size())), "a.jpg");
    EXPECT_FALSE(image.ok() && image->has_value()) << n;
  }
  Bytes lies = whole;
  put(lies, 2 + 12 + 0x1c, 0xFFFFFFFF, 4, true);
  EXPECT_THAT(find_flir_image(lies, "a.jpg").error().message,
              testing::HasSubstr("a.jpg: its FLIR thermal data ends within its directory"));
}

TEST(ThermalPng, KeepsAllSixteenBits) {
  // The camera's own list of hot spots (a text in the PNG) says 26140 for (521, 295), centikelvin.
  // sBIT is 15: samples were scaled to 16 bit by repeating their first bit, as PNG asks for.
  const auto folder = test::real_data("arctic_thermal_rgb_pair");
  if (!folder) GTEST_SKIP() << "the real data is not here";
  const auto image = image_loader(*folder / "CHESS_FL1_C_160407_234502.428_THERM-16BIT.PNG")({});
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image->type(), CV_16UC1);
  const auto counts = image->at<std::uint16_t>(295, 521);
  EXPECT_EQ(counts >> 1, 26140);
  EXPECT_NEAR(kelvin_of(counts, LinearThermalScale{0.005, 0.0}).value(), 261.40, 0.006);
}

TEST(ThermalScale, IsItsOwnInverse) {
  const PlanckThermalScale planck{17096.453, 1428.0, 1.0, -342.0, 0.04651};
  for (double kelvin = 230; kelvin < 310; kelvin += 2.5)
    for (const ThermalScale& scale :
         {ThermalScale(planck), ThermalScale(LinearThermalScale{0.04, 0.0})})
      EXPECT_NEAR(kelvin_of(counts_of(kelvin, scale).value(), scale).value(), kelvin, 1e-9);
  // FLIR TLinear, high resolution.
  EXPECT_NEAR(kelvin_of(26140, LinearThermalScale{}).value(), 261.40, 1e-12);
  EXPECT_FALSE(kelvin_of(0, LinearThermalScale{}).ok());
  EXPECT_FALSE(kelvin_of(300, planck).ok());
  EXPECT_FALSE(counts_of(-5, planck).ok());
}

}  // namespace
}  // namespace watersky
