// SPDX-License-Identifier: MIT
#include "watersky/io/geotiff.hpp"

#include <cpl_string.h>
#include <gdal_priv.h>

#include <array>
#include <cmath>
#include <string>

#include "watersky/io/detail/cog.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/gdal_session.hpp"
#include "watersky/io/pyramid.hpp"

namespace watersky {

namespace {

constexpr int kTileSide = 512;  // the COG driver's

/// One channel of a matrix as GDAL's band sees it.
struct Channel {
  std::size_t byte = 0;  ///< from the start of an element
  GDALColorInterp meaning = GCI_GrayIndex;
};

GDALDataType gdal_type(const cv::Mat& m) {
  switch (m.depth()) {
    case CV_8U: return GDT_Byte;
    case CV_16U: return GDT_UInt16;
    case CV_32F: return GDT_Float32;
    default: return GDT_Float64;
  }
}

/// A dataset whose bands are the matrix itself, not copies.
DatasetPtr view_of(const cv::Mat& m, const std::vector<Channel>& channels) {
  DatasetPtr dataset(GetGDALDriverManager()->GetDriverByName("MEM")->Create("", m.cols, m.rows, 0,
                                                                            gdal_type(m), nullptr));
  if (!dataset) return nullptr;
  for (const Channel& channel : channels) {
    std::array<char, 64> address{};
    CPLPrintPointer(address.data(), m.data + channel.byte, static_cast<int>(address.size()) - 1);
    CPLStringList options;
    options.SetNameValue("DATAPOINTER", address.data());
    options.SetNameValue("PIXELOFFSET", std::to_string(m.elemSize()).c_str());
    options.SetNameValue("LINEOFFSET", std::to_string(m.step[0]).c_str());
    if (dataset->AddBand(gdal_type(m), options.List()) != CE_None) return nullptr;
    dataset->GetRasterBand(dataset->GetRasterCount())->SetColorInterpretation(channel.meaning);
  }
  return dataset;
}

bool write_band(GDALRasterBand* band, const cv::Mat& m, std::size_t byte) {
  return band && band->GetXSize() == m.cols && band->GetYSize() == m.rows &&
         band->RasterIO(GF_Write, 0, 0, m.cols, m.rows, m.data + byte, m.cols, m.rows, gdal_type(m),
                        static_cast<GSpacing>(m.elemSize()), static_cast<GSpacing>(m.step[0]),
                        nullptr) == CE_None;
}

bool build_empty_overviews(GDALDataset& dataset, std::size_t count) {
  std::vector<int> factors;
  for (std::size_t i = 0; i < count; ++i) factors.push_back(2 << i);
  return count == 0 || dataset.BuildOverviews("NONE", static_cast<int>(count), factors.data(), 0,
                                              nullptr, nullptr, nullptr) == CE_None;
}

Status write_cog(const std::filesystem::path& path, GDALDataset& source, bool picture,
                 GdalSession& gdal) {
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("COG");
  if (!driver)
    return Error{ErrorCode::Unsupported,
                 path.string() + ": this GDAL has no COG driver; install GDAL 3.1 or later"};
  const CPLStringList options = detail::cog_options(picture);
  const MemoryFile file(".tif");
  DatasetPtr cog(
      driver->CreateCopy(file.name().c_str(), &source, FALSE, options.List(), nullptr, nullptr));
  if (!cog) return gdal.error(path);
  cog.reset();
  if (gdal.failed()) return gdal.error(path);
  return write_file(path, file.bytes());
}

}  // namespace

Status write_geotiff(const std::filesystem::path& path, const cv::Mat& raster,
                     const RasterPlace& place, const RasterText& text) {
  if (raster.empty() || (raster.type() != CV_32F && raster.type() != CV_64F &&
                         raster.type() != CV_16U && raster.type() != CV_8U))
    return Error{ErrorCode::Unsupported, path.string() +
                                             ": a raster must have cells, of one 32 or 64 bit "
                                             "float, one 16 bit count or one 8 bit class"};
  GdalSession gdal;
  const DatasetPtr source = view_of(raster, {{0, GCI_GrayIndex}});
  if (!source || !detail::describe(*source, place, text)) return gdal.error(path);
  GDALRasterBand& band = *source->GetRasterBand(1);
  band.SetNoDataValue(raster.type() == CV_16U  ? 0.0
                      : raster.type() == CV_8U ? 255.0
                                               : std::nan(""));
  band.SetDescription(utf8(text.description).c_str());
  band.SetUnitType(text.unit.c_str());
  const std::vector<cv::Mat> levels = pyramid(raster, kTileSide);
  if (!build_empty_overviews(*source, levels.size())) return gdal.error(path);
  for (std::size_t i = 0; i < levels.size(); ++i)
    if (!write_band(band.GetOverview(static_cast<int>(i)), levels[i], 0)) return gdal.error(path);
  return write_cog(path, *source, false, gdal);
}

Status write_mosaic_geotiff(const std::filesystem::path& path, const cv::Mat& bgra,
                            const RasterPlace& place, const RasterText& text) {
  if (bgra.empty() || bgra.type() != CV_8UC4)
    return Error{ErrorCode::Unsupported,
                 path.string() + ": a mosaic must have cells of four 8 bit channels"};
  GdalSession gdal;
  const std::vector<Channel> channels = {{2, GCI_RedBand}, {1, GCI_GreenBand}, {0, GCI_BlueBand}};
  const DatasetPtr source = view_of(bgra, channels);
  if (!source || !detail::describe(*source, place, text)) return gdal.error(path);
  source->GetRasterBand(1)->SetDescription("red");
  source->GetRasterBand(2)->SetDescription("green");
  source->GetRasterBand(3)->SetDescription("blue");
  if (source->CreateMaskBand(GMF_PER_DATASET) != CE_None ||
      !write_band(source->GetRasterBand(1)->GetMaskBand(), bgra, 3))
    return gdal.error(path);
  const std::vector<cv::Mat> levels = pyramid(bgra, kTileSide);
  if (!build_empty_overviews(*source, levels.size())) return gdal.error(path);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    for (int b = 0; b < 3; ++b)
      if (!write_band(source->GetRasterBand(b + 1)->GetOverview(static_cast<int>(i)), levels[i],
                      channels[static_cast<std::size_t>(b)].byte))
        return gdal.error(path);
    GDALRasterBand* mask = source->GetRasterBand(1)->GetMaskBand();
    if (!write_band(mask->GetOverviewCount() > static_cast<int>(i)
                        ? mask->GetOverview(static_cast<int>(i))
                        : source->GetRasterBand(1)->GetOverview(static_cast<int>(i))->GetMaskBand(),
                    levels[i], 3))
      return gdal.error(path);
  }
  return write_cog(path, *source, true, gdal);
}

}  // namespace watersky
