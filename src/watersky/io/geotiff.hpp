// SPDX-License-Identifier: MIT
#pragma once
/// Cloud-optimised GeoTIFF: tiled, with overviews, in the layout that GDAL's COG driver makes and
/// its validator checks.
///
/// Compression, as measured on 2500 x 2000 cells and one thread: the three data rasters take
/// 0.14 s with ZSTD level 1 and 0.27 s with DEFLATE level 1, and predictors make them slower and
/// larger: maps are patches of equal values, not slopes. Where GDAL was built without ZSTD it is
/// DEFLATE. The mosaic is JPEG (quality 90, YCbCr) with an exact mask: 1.8 MB where DEFLATE
/// makes 9.8 MB and WEBP takes three times as long. Overviews are made here, in two-by-two steps
/// that know what was seen: GDAL's own averaging took as long as the rest of the file. What each
/// file takes now: bench/products.
#include <array>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

/// Where a raster lies.
struct RasterPlace {
  std::array<double, 6> geotransform{};  ///< GDAL's, of the raster's north-west corner
  std::string crs_wkt;
};

/// What a raster says of itself.
struct RasterText {
  std::string description;                                    ///< of its band
  std::string unit;                                           ///< "1" for a pure number, "s", …
  std::vector<std::pair<std::string, std::string>> metadata;  ///< of the file
};

/// One band: CV_32F and CV_64F with NaN as nodata, CV_16U with 0, CV_8U (classes) with 255. The
/// overviews of CV_32F hold the mean of the known cells, of the others one of the cells. Io when it
/// cannot be written; then nothing is left.
Status write_geotiff(const std::filesystem::path& path, const cv::Mat& raster,
                     const RasterPlace& place, const RasterText& text);

/// A picture: CV_8UC4 BGR and validity (255 seen, 0 not); three bands and a mask.
Status write_mosaic_geotiff(const std::filesystem::path& path, const cv::Mat& bgra,
                            const RasterPlace& place, const RasterText& text);

}  // namespace watersky
