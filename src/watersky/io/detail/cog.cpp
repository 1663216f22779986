// SPDX-License-Identifier: MIT
#include "watersky/io/detail/cog.hpp"

#include <gdal_priv.h>

#include "watersky/io/gdal_session.hpp"

namespace watersky::detail {

bool describe(GDALDataset& dataset, const RasterPlace& place, const RasterText& text) {
  OGRSpatialReference crs;
  if (crs.importFromWkt(place.crs_wkt.c_str()) != OGRERR_NONE) return false;
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  std::array<double, 6> geotransform = place.geotransform;
  if (dataset.SetSpatialRef(&crs) != CE_None ||
      dataset.SetGeoTransform(geotransform.data()) != CE_None)
    return false;
  dataset.SetMetadataItem("AREA_OR_POINT", "Area");
  for (const auto& [key, value] : text.metadata)
    dataset.SetMetadataItem(key.c_str(), utf8(value).c_str());
  return true;
}

CPLStringList cog_options(bool picture) {
  CPLStringList options;
  options.SetNameValue("OVERVIEWS", "AUTO");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  options.SetNameValue("NUM_THREADS", "1");
  if (picture) {
    options.SetNameValue("COMPRESS", "JPEG");
    options.SetNameValue("QUALITY", "90");
    options.SetNameValue("OVERVIEW_QUALITY", "90");
  } else {
    const char* codec = has_gdal_driver("COG", "ZSTD") ? "ZSTD" : "DEFLATE";
    options.SetNameValue("COMPRESS", codec);
    options.SetNameValue("OVERVIEW_COMPRESS", codec);
    options.SetNameValue("LEVEL", "1");
  }
  return options;
}

}  // namespace watersky::detail
