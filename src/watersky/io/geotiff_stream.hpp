// SPDX-License-Identifier: MIT
#pragma once
/// The same cloud-optimised GeoTIFF for a raster that does not fit into memory: it is asked for
/// block by block.
#include <cstdint>
#include <functional>

#include "watersky/base/progress.hpp"
#include "watersky/io/geotiff.hpp"

namespace watersky {

struct StreamedRaster {
  int columns = 0;
  int rows = 0;
  int type = 0;  ///< CV_32F, CV_64F, CV_16U or CV_8U, with the nodata values of write_geotiff
  /// The cells of a part, of `type` and the part's size. Parts come in rows of blocks of 512 cells
  /// from the north-west corner; all of them twice, for the overviews and for the raster itself.
  std::function<Result<cv::Mat>(const cv::Rect& cells)> read;
};

/// Memory: a few rows of blocks, whatever the raster's height (bench/map_large); beside the file a
/// temporary one a third as large. Blocks without a known cell take no room. Io, or what `read`
/// says; then nothing is left.
Status write_geotiff(const std::filesystem::path& path, const StreamedRaster& raster,
                     const RasterPlace& place, const RasterText& text,
                     const Progress& progress = {});

}  // namespace watersky
