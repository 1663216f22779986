// SPDX-License-Identifier: MIT
#pragma once
/// What all our cloud-optimised GeoTIFFs share.
#include <cpl_string.h>

#include "watersky/io/geotiff.hpp"

class GDALDataset;

namespace watersky::detail {

/// Puts place and text into a dataset; false when GDAL does not take them.
[[nodiscard]] bool describe(GDALDataset& dataset, const RasterPlace& place, const RasterText& text);

/// Creation options of the COG driver; a picture is JPEG, data lossless.
[[nodiscard]] CPLStringList cog_options(bool picture);

}  // namespace watersky::detail
