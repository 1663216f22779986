// SPDX-License-Identifier: MIT
#include "watersky/io/geotiff.hpp"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <random>

#include "support/temporary_folder.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/geotiff_stream.hpp"
#include "watersky/io/pyramid.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;

RasterPlace place() {
  return {{500000.0, 0.5, 0.0, 8750000.0, 0.0, -0.5},
          Projection::from_text("EPSG:32633").value().wkt()};
}

/// Whether GDAL's own validator calls a file a cloud-optimised GeoTIFF; nullopt without it.
std::optional<bool> validator_says(const fs::path& file) {
  const std::string probe =
      "/usr/bin/python3 -c 'import osgeo_utils.samples.validate_cloud_optimized_geotiff' "
      "2>/dev/null";
  if (std::system(probe.c_str()) != 0) return std::nullopt;
  return std::system(("/usr/bin/python3 -m osgeo_utils.samples.validate_cloud_optimized_geotiff "
                      "--full-check=yes \"" +
                      file.string() + "\" >/dev/null 2>&1")
                         .c_str()) == 0;
}

cv::Mat random_probability(int rows, int columns, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(0, 1);
  cv::Mat p(rows, columns, CV_32F);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      p.at<float>(r, c) = (r / 97 + c / 131) % 3 == 0 ? std::nanf("") : u(random);
  return p;
}

TEST(GeoTiff, GivesBackEveryCellWhereItWas) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "p.tif";
  const cv::Mat p = random_probability(1301, 917, 1);
  ASSERT_TRUE(write_geotiff(file, p, place(),
                            {"probability of ice", "1", {{"TIFFTAG_SOFTWARE", "watersky"}}})
                  .ok());

  GDALAllRegister();
  const std::unique_ptr<GDALDataset> d(GDALDataset::Open(file.c_str()));
  ASSERT_TRUE(d);
  EXPECT_STREQ(d->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  EXPECT_STREQ(d->GetSpatialRef()->GetAuthorityCode(nullptr), "32633");
  double gt[6];
  ASSERT_EQ(d->GetGeoTransform(gt), CE_None);
  EXPECT_EQ(gt[0], 500000.0);
  EXPECT_EQ(gt[5], -0.5);
  GDALRasterBand* band = d->GetRasterBand(1);
  EXPECT_TRUE(std::isnan(band->GetNoDataValue()));
  EXPECT_STREQ(band->GetDescription(), "probability of ice");
  EXPECT_STREQ(band->GetUnitType(), "1");
  cv::Mat back(p.size(), CV_32F);
  ASSERT_EQ(band->RasterIO(GF_Read, 0, 0, p.cols, p.rows, back.data, p.cols, p.rows, GDT_Float32, 0,
                           0, nullptr),
            CE_None);
  for (int r = 0; r < p.rows; ++r)
    for (int c = 0; c < p.cols; ++c) {
      const float a = p.at<float>(r, c);
      const float b = back.at<float>(r, c);
      ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << r << " " << c;
    }
  ASSERT_EQ(band->GetOverviewCount(), 2);
  const cv::Mat quarter = pyramid(p, 512).back();
  cv::Mat overview(quarter.size(), CV_32F);
  ASSERT_EQ(band->GetOverview(1)->RasterIO(GF_Read, 0, 0, quarter.cols, quarter.rows, overview.data,
                                           quarter.cols, quarter.rows, GDT_Float32, 0, 0, nullptr),
            CE_None);
  EXPECT_EQ(cv::countNonZero(overview != overview), cv::countNonZero(quarter != quarter));
  EXPECT_EQ(overview.at<float>(100, 200), quarter.at<float>(100, 200));
}

TEST(GeoTiff, GdalsOwnValidatorCallsThemCloudOptimised) {
  const test::TemporaryFolder folder;
  const cv::Mat p = random_probability(1301, 917, 2);
  cv::Mat looks(p.size(), CV_16U, cv::Scalar(3));
  cv::Mat seen(p.size(), CV_64F, cv::Scalar(1.5e9));
  cv::Mat bgra(p.size(), CV_8UC4, cv::Scalar(10, 100, 200, 255));
  bgra(cv::Rect(0, 0, 300, 300)).setTo(cv::Scalar(0, 0, 0, 0));
  ASSERT_TRUE(write_geotiff(folder.path() / "p.tif", p, place(), {}).ok());
  ASSERT_TRUE(write_geotiff(folder.path() / "l.tif", looks, place(), {}).ok());
  ASSERT_TRUE(write_geotiff(folder.path() / "s.tif", seen, place(), {}).ok());
  ASSERT_TRUE(
      write_geotiff(folder.path() / "small.tif", p(cv::Rect(0, 0, 7, 3)).clone(), place(), {})
          .ok());
  ASSERT_TRUE(write_mosaic_geotiff(folder.path() / "m.tif", bgra, place(), {}).ok());
  for (const char* name : {"p.tif", "l.tif", "s.tif", "small.tif", "m.tif"}) {
    const std::optional<bool> valid = validator_says(folder.path() / name);
    if (!valid) GTEST_SKIP() << "GDAL's validator (python3-gdal) is not installed";
    EXPECT_TRUE(*valid) << name;
  }
}

TEST(GeoTiff, TheMosaicKeepsItsColoursAndItsMaskAtEverySize) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "m.tif";
  cv::Mat bgra(1100, 1300, CV_8UC4, cv::Scalar(30, 90, 200, 255));
  bgra(cv::Rect(700, 0, 600, 1100)).setTo(cv::Scalar(0, 0, 0, 0));
  ASSERT_TRUE(write_mosaic_geotiff(file, bgra, place(), {}).ok());
  GDALAllRegister();
  const std::unique_ptr<GDALDataset> d(GDALDataset::Open(file.c_str()));
  ASSERT_TRUE(d);
  EXPECT_STREQ(d->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  EXPECT_STREQ(d->GetMetadataItem("COMPRESSION", "IMAGE_STRUCTURE"), "YCbCr JPEG");
  ASSERT_EQ(d->GetRasterCount(), 3);
  const int expected[3] = {200, 90, 30};
  for (int level = -1; level < d->GetRasterBand(1)->GetOverviewCount(); ++level) {
    for (int b = 0; b < 3; ++b) {
      GDALRasterBand* band = d->GetRasterBand(b + 1);
      if (level >= 0) band = band->GetOverview(level);
      const int scale = 1 << (level + 1);
      const int x = 200 / scale;
      const int unseen = 1000 / scale;
      std::uint8_t value = 0;
      std::uint8_t mask_seen = 0;
      std::uint8_t mask_unseen = 9;
      ASSERT_EQ(band->RasterIO(GF_Read, x, x, 1, 1, &value, 1, 1, GDT_Byte, 0, 0, nullptr),
                CE_None);
      ASSERT_EQ(band->GetMaskBand()->RasterIO(GF_Read, x, x, 1, 1, &mask_seen, 1, 1, GDT_Byte, 0, 0,
                                              nullptr),
                CE_None);
      ASSERT_EQ(band->GetMaskBand()->RasterIO(GF_Read, unseen, x, 1, 1, &mask_unseen, 1, 1,
                                              GDT_Byte, 0, 0, nullptr),
                CE_None);
      EXPECT_NEAR(value, expected[b], 4);
      EXPECT_EQ(mask_seen, 255);
      EXPECT_EQ(mask_unseen, 0);
    }
  }
  EXPECT_GE(d->GetRasterBand(1)->GetOverviewCount(), 2);
}

TEST(GeoTiff, AnUnwritablePlaceIsAnIoErrorAndLeavesNothing) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "missing" / "p.tif";
  const Status s = write_geotiff(file, cv::Mat(4, 4, CV_32F, cv::Scalar(0.5)), place(), {});
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().code, ErrorCode::Io);
  EXPECT_NE(s.error().message.find("p.tif"), std::string::npos);
  EXPECT_FALSE(fs::exists(file));
}

TEST(GeoTiff, WhatHasNoPlaceOnEarthOrNoCellsIsRefused) {
  const test::TemporaryFolder folder;
  const Status bad = write_geotiff(folder.path() / "p.tif", cv::Mat(4, 4, CV_32F, cv::Scalar(0.5)),
                                   {{0, 1, 0, 0, 0, -1}, "nonsense"}, {});
  EXPECT_FALSE(bad.ok());
  EXPECT_EQ(write_geotiff(folder.path() / "p.tif", cv::Mat(), place(), {}).error().code,
            ErrorCode::Unsupported);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Pyramid, MeansKnowWhatWasSeen) {
  const float n = std::nanf("");
  const cv::Mat p = (cv::Mat_<float>(3, 3) << 1, n, 0.5F, 0, n, n, n, n, 0.25F);
  const cv::Mat h = halved(p);
  ASSERT_EQ(h.size(), cv::Size(2, 2));
  EXPECT_FLOAT_EQ(h.at<float>(0, 0), 0.5F);
  EXPECT_FLOAT_EQ(h.at<float>(0, 1), 0.5F);
  EXPECT_TRUE(std::isnan(h.at<float>(1, 0)));
  EXPECT_FLOAT_EQ(h.at<float>(1, 1), 0.25F);

  cv::Mat bgra(2, 2, CV_8UC4, cv::Scalar(0, 0, 0, 0));
  bgra.at<cv::Vec4b>(1, 1) = {9, 8, 7, 255};
  EXPECT_EQ(halved(bgra).at<cv::Vec4b>(0, 0), cv::Vec4b(9, 8, 7, 255));
}

/// All of a file's levels, to compare.
std::vector<std::vector<float>> levels_of(const fs::path& file) {
  GDALAllRegister();
  const std::unique_ptr<GDALDataset> d(GDALDataset::Open(file.c_str()));
  if (!d) return {};
  std::vector<std::vector<float>> out;
  GDALRasterBand* band = d->GetRasterBand(1);
  for (int i = -1; i < band->GetOverviewCount(); ++i) {
    GDALRasterBand* level = i < 0 ? band : band->GetOverview(i);
    std::vector<float> cells(static_cast<std::size_t>(level->GetXSize()) *
                             static_cast<std::size_t>(level->GetYSize()));
    EXPECT_EQ(level->RasterIO(GF_Read, 0, 0, level->GetXSize(), level->GetYSize(), cells.data(),
                              level->GetXSize(), level->GetYSize(), GDT_Float32, 0, 0, nullptr),
              CE_None);
    out.push_back(std::move(cells));
  }
  return out;
}

TEST(GeoTiff, StreamedIsTheSameAsWhole) {
  const test::TemporaryFolder folder;
  const cv::Mat p = random_probability(1301, 1917, 2);
  const RasterText text{"probability of ice", "1", {}};
  ASSERT_TRUE(write_geotiff(folder.path() / "whole.tif", p, place(), text));
  const StreamedRaster raster{p.cols, p.rows, p.type(),
                              [&](const cv::Rect& part) -> Result<cv::Mat> { return p(part); }};
  ASSERT_TRUE(write_geotiff(folder.path() / "streamed.tif", raster, place(), text));
  const auto whole = levels_of(folder.path() / "whole.tif");
  const auto streamed = levels_of(folder.path() / "streamed.tif");
  ASSERT_EQ(whole.size(), streamed.size());
  ASSERT_GE(whole.size(), 2u);
  EXPECT_EQ(std::memcmp(whole[0].data(), streamed[0].data(), whole[0].size() * sizeof(float)), 0);
  // GDAL makes these overviews, and leaves out what is less than a cell at the edge.
  const auto mean = [](const std::vector<float>& cells) {
    double sum = 0, count = 0;
    for (const float c : cells)
      if (c == c) sum += c, ++count;
    return sum / count;
  };
  for (std::size_t level = 1; level < whole.size(); ++level)
    EXPECT_NEAR(mean(streamed[level]), mean(whole[level]), 0.003) << level;
  EXPECT_NE(validator_says(folder.path() / "streamed.tif"), false);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2) << "no part is left";
}

TEST(GeoTiff, StreamedFromASourceThatFailsSaysWhatItSaidAndLeavesNothing) {
  const test::TemporaryFolder folder;
  const StreamedRaster raster{
      3000, 3000, CV_16U, [](const cv::Rect& part) -> Result<cv::Mat> {
        if (part.y > 1000) return Error{ErrorCode::InvalidInput, "a.wsmap: byte 77: damaged"};
        return cv::Mat(part.size(), CV_16U, cv::Scalar(3));
      }};
  const Status done = write_geotiff(folder.path() / "looks.tif", raster, place(), {});
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message, "a.wsmap: byte 77: damaged");
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(GeoTiff, StreamedSeaThatNobodySawTakesNoRoom) {
  const test::TemporaryFolder folder;
  const StreamedRaster raster{
      20000, 20000, CV_32F, [](const cv::Rect& part) -> Result<cv::Mat> {
        return cv::Mat(part.size(), CV_32F,
                       cv::Scalar(part.x == 512 && part.y == 512 ? 0.5 : std::nan("")));
      }};
  ASSERT_TRUE(write_geotiff(folder.path() / "p.tif", raster, place(), {}));
  EXPECT_LT(fs::file_size(folder.path() / "p.tif"), 300'000u);
}

}  // namespace
}  // namespace watersky
