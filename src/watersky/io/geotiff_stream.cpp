// SPDX-License-Identifier: MIT
#include "watersky/io/geotiff_stream.hpp"

#include <gdal_priv.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <system_error>

#include "watersky/io/detail/cog.hpp"
#include "watersky/io/gdal_session.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

constexpr int kBlock = 512;  // the COG driver's

struct Kind {
  GDALDataType type = GDT_Unknown;
  double nodata = 0.0;
};

std::optional<Kind> kind_of(int type) {
  switch (type) {
    case CV_8U: return Kind{GDT_Byte, 255.0};
    case CV_16U: return Kind{GDT_UInt16, 0.0};
    case CV_32F: return Kind{GDT_Float32, std::nan("")};
    case CV_64F: return Kind{GDT_Float64, std::nan("")};
    default: return std::nullopt;
  }
}

class SourceBand;

/// A raster as GDAL asks for it.
class SourceDataset final : public GDALDataset {
 public:
  SourceDataset(const StreamedRaster& raster, const Kind& kind);
  const StreamedRaster& raster;
  std::optional<Error> error;  ///< the first that read() gave
  std::array<double, 6> geotransform{};
  OGRSpatialReference crs;

  CPLErr GetGeoTransform(double* out) override {
    std::copy(geotransform.begin(), geotransform.end(), out);
    return CE_None;
  }
  CPLErr SetGeoTransform(double* values) override {
    std::copy_n(values, geotransform.size(), geotransform.begin());
    return CE_None;
  }
  [[nodiscard]] const OGRSpatialReference* GetSpatialRef() const override { return &crs; }
  CPLErr SetSpatialRef(const OGRSpatialReference* given) override {
    crs = *given;
    return CE_None;
  }
};

class SourceBand final : public GDALRasterBand {
 public:
  SourceBand(SourceDataset& dataset, const Kind& kind) : source_(dataset), kind_(kind) {
    poDS = &dataset;
    nBand = 1;
    nRasterXSize = dataset.raster.columns;
    nRasterYSize = dataset.raster.rows;
    nBlockXSize = nBlockYSize = kBlock;
    eDataType = kind.type;
  }
  double GetNoDataValue(int* has) override {
    if (has) *has = TRUE;
    return kind_.nodata;
  }
  GDALColorInterp GetColorInterpretation() override { return GCI_GrayIndex; }

 protected:
  CPLErr IReadBlock(int column, int row, void* into) override {
    const cv::Rect cells = cv::Rect(column * kBlock, row * kBlock, kBlock, kBlock) &
                           cv::Rect(0, 0, nRasterXSize, nRasterYSize);
    const auto part = source_.raster.read(cells);
    if (!part) {
      if (!source_.error) source_.error = part.error();
      CPLError(CE_Failure, CPLE_FileIO, "%s", part.error().message.c_str());
      return CE_Failure;
    }
    // What lies beyond the raster's edge nobody looks at.
    const std::size_t line = kBlock * part->elemSize();
    for (int r = 0; r < part->rows; ++r)
      std::memcpy(static_cast<char*>(into) + static_cast<std::size_t>(r) * line, part->ptr(r),
                  static_cast<std::size_t>(part->cols) * part->elemSize());
    return CE_None;
  }

 private:
  SourceDataset& source_;
  Kind kind_;
};

SourceDataset::SourceDataset(const StreamedRaster& from, const Kind& kind) : raster(from) {
  nRasterXSize = from.columns;
  nRasterYSize = from.rows;
  SetBand(1, new SourceBand(*this, kind));  // NOLINT(cppcoreguidelines-owning-memory): GDAL owns it
}

/// GDAL 3.6 does not tell when the last bytes of a file could not be written.
bool all_blocks_are_in(const fs::path& file) {
  const DatasetPtr dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (!dataset || error) return false;
  GDALRasterBand* band = dataset->GetRasterBand(1);
  const auto number = [&](const char* what, int c, int r) -> std::uintmax_t {
    const std::string name = std::string(what) + std::to_string(c) + "_" + std::to_string(r);
    const char* text = band->GetMetadataItem(name.c_str(), "TIFF");
    return text ? std::strtoull(text, nullptr, 10) : 0;  // none: a block of nodata
  };
  for (int r = 0; r * kBlock < band->GetYSize(); ++r)
    for (int c = 0; c * kBlock < band->GetXSize(); ++c)
      if (number("BLOCK_OFFSET_", c, r) + number("BLOCK_SIZE_", c, r) > size) return false;
  return true;
}

/// GDAL keeps blocks up to a part of the machine's memory, whatever else needs it. It goes over the
/// raster line by line, so two rows of blocks must stay, or each block is made again and again.
class BlockCache {
 public:
  explicit BlockCache(const StreamedRaster& raster) {
    constexpr GIntBig kLeast = GIntBig{64} << 20;
    const GIntBig row = GIntBig{kBlock} * (raster.columns + kBlock) *
                        static_cast<GIntBig>(CV_ELEM_SIZE(raster.type));
    GDALSetCacheMax64(kLeast + 2 * row);
  }
  ~BlockCache() { GDALSetCacheMax64(before_); }
  BlockCache(const BlockCache&) = delete;
  BlockCache& operator=(const BlockCache&) = delete;

 private:
  GIntBig before_ = GDALGetCacheMax64();
};

struct Told {
  const Progress& progress;
  std::string name;
};

int CPL_STDCALL tell(double fraction, const char*, void* told) {
  const auto& t = *static_cast<const Told*>(told);
  report(t.progress, t.name, static_cast<std::size_t>(1000 * fraction), 1000);
  return TRUE;
}

}  // namespace

Status write_geotiff(const fs::path& path, const StreamedRaster& raster, const RasterPlace& place,
                     const RasterText& text, const Progress& progress) {
  const auto kind = kind_of(raster.type);
  if (raster.columns <= 0 || raster.rows <= 0 || !kind)
    return Error{ErrorCode::Unsupported, path.string() +
                                             ": a raster must have cells, of one 32 or 64 bit "
                                             "float, one 16 bit count or one 8 bit class"};
  GdalSession gdal;
  const BlockCache cache(raster);
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("COG");
  if (!driver)
    return Error{ErrorCode::Unsupported,
                 path.string() + ": this GDAL has no COG driver; install GDAL 3.1 or later"};
  SourceDataset source(raster, *kind);
  if (!detail::describe(source, place, text)) return gdal.error(path);
  source.GetRasterBand(1)->SetDescription(utf8(text.description).c_str());
  CPLStringList options = detail::cog_options(false);
  options.SetNameValue("SPARSE_OK", "YES");
  options.SetNameValue("OVERVIEW_RESAMPLING", raster.type == CV_32F ? "AVERAGE" : "NEAREST");
  fs::path part = path;
  part += ".part" + std::to_string(::getpid()) + ".tif";
  const auto give_up = [&](Error error) {
    std::error_code ignored;
    fs::remove(part, ignored);
    return error;
  };
  Told told{progress, path.filename().string()};
  DatasetPtr cog(driver->CreateCopy(part.c_str(), &source, FALSE, options.List(), &tell, &told));
  const bool made = cog != nullptr;
  cog.reset();
  if (source.error) return give_up(*source.error);
  if (!made || gdal.failed()) return give_up(gdal.error(path));
  if (!all_blocks_are_in(part))
    return give_up({ErrorCode::Io, path.string() +
                                       ": cannot be written to its end; free space there, or "
                                       "choose another output"});
  std::error_code error;
  fs::rename(part, path, error);
  if (error)
    return give_up({ErrorCode::Io, path.string() + ": cannot be written: " + error.message()});
  return {};
}

}  // namespace watersky
