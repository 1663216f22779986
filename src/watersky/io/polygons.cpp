// SPDX-License-Identifier: MIT
#include "watersky/io/polygons.hpp"

#include <gdal.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <memory>
#include <string>
#include <type_traits>

#include "watersky/io/files.hpp"
#include "watersky/io/gdal_session.hpp"

namespace watersky {
namespace {

struct CloseDataset {
  using pointer = GDALDatasetH;
  void operator()(GDALDatasetH dataset) const { GDALClose(dataset); }
};
struct ReleaseReference {
  using pointer = OGRSpatialReferenceH;
  void operator()(OGRSpatialReferenceH reference) const { OSRRelease(reference); }
};
struct DestroyTransform {
  using pointer = OGRCoordinateTransformationH;
  void operator()(OGRCoordinateTransformationH t) const { OCTDestroyCoordinateTransformation(t); }
};
struct DestroyFeature {
  using pointer = OGRFeatureH;
  void operator()(OGRFeatureH feature) const { OGR_F_Destroy(feature); }
};
template <class Deleter>
using Owned = std::unique_ptr<std::remove_pointer_t<typename Deleter::pointer>, Deleter>;

Status add_ring(OGRGeometryH ring, GeoPolygon& polygon) {
  const int points = OGR_G_GetPointCount(ring);
  std::vector<Eigen::Vector2d> lon_lat;
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector2d p(OGR_G_GetX(ring, i), OGR_G_GetY(ring, i));
    if (!(std::abs(p.x()) <= 360.0 && std::abs(p.y()) <= 90.0))
      return Error{ErrorCode::InvalidInput,
                   "has a point that is no longitude and latitude: " + std::to_string(p.x()) +
                       ", " + std::to_string(p.y())};
    lon_lat.push_back(p);
  }
  if (lon_lat.size() > 1 && lon_lat.front() == lon_lat.back()) lon_lat.pop_back();
  if (lon_lat.size() < 3)
    return Error{ErrorCode::InvalidInput, "has a ring of fewer than three points"};
  polygon.rings_lon_lat_deg.push_back(std::move(lon_lat));
  return {};
}

/// Polygons at any depth of collections.
Status add(OGRGeometryH geometry, int depth, std::vector<GeoPolygon>& polygons) {
  if (!geometry || depth > 8) return {};
  const int parts = OGR_G_GetGeometryCount(geometry);
  if (wkbFlatten(OGR_G_GetGeometryType(geometry)) == wkbPolygon) {
    GeoPolygon polygon;
    for (int i = 0; i < parts; ++i)
      WATERSKY_CHECK(add_ring(OGR_G_GetGeometryRef(geometry, i), polygon));
    if (!polygon.rings_lon_lat_deg.empty()) polygons.push_back(std::move(polygon));
    return {};
  }
  for (int i = 0; i < parts; ++i)
    WATERSKY_CHECK(add(OGR_G_GetGeometryRef(geometry, i), depth + 1, polygons));
  return {};
}

Status read_layer(OGRLayerH layer, OGRSpatialReferenceH wgs84, std::vector<GeoPolygon>& polygons) {
  Owned<DestroyTransform> to_wgs84;
  if (OGRSpatialReferenceH own = OGR_L_GetSpatialRef(layer)) {
    const Owned<ReleaseReference> traditional(OSRClone(own));
    OSRSetAxisMappingStrategy(traditional.get(), OAMS_TRADITIONAL_GIS_ORDER);
    if (!OSRIsSame(traditional.get(), wgs84)) {
      to_wgs84.reset(OCTNewCoordinateTransformation(traditional.get(), wgs84));
      if (!to_wgs84)
        return Error{ErrorCode::Unsupported,
                     "is in a coordinate system that cannot be taken to WGS-84"};
    }
  }
  OGR_L_ResetReading(layer);
  while (const Owned<DestroyFeature> feature{OGR_L_GetNextFeature(layer)}) {
    OGRGeometryH geometry = OGR_F_GetGeometryRef(feature.get());
    if (!geometry) continue;
    if (to_wgs84 && OGR_G_Transform(geometry, to_wgs84.get()) != OGRERR_NONE)
      return Error{ErrorCode::InvalidInput, "has a geometry outside its coordinate system"};
    WATERSKY_CHECK(add(geometry, 0, polygons));
  }
  return {};
}

}  // namespace

bool is_polygon_file(const std::filesystem::path& file) {
  const std::string e = lower_extension(file);
  return e == ".geojson" || e == ".json" || e == ".gpkg" || e == ".shp" || e == ".kml";
}

Result<std::vector<GeoPolygon>> read_polygons(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file))
    return Error{ErrorCode::NotFound, file.string() + ": does not exist; is the path right?"};
  const GdalSession quiet;
  GDALAllRegister();
  const Owned<CloseDataset> dataset(
      GDALOpenEx(file.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  if (!dataset)
    return Error{ErrorCode::InvalidInput,
                 file.string() + ": is no vector file that can be read, such as GeoJSON"};
  const Owned<ReleaseReference> wgs84(OSRNewSpatialReference(nullptr));
  OSRImportFromEPSG(wgs84.get(), 4326);
  OSRSetAxisMappingStrategy(wgs84.get(), OAMS_TRADITIONAL_GIS_ORDER);
  std::vector<GeoPolygon> polygons;
  for (int i = 0; i < GDALDatasetGetLayerCount(dataset.get()); ++i)
    if (const Status s = read_layer(GDALDatasetGetLayer(dataset.get(), i), wgs84.get(), polygons);
        !s)
      return Error{s.error().code, file.string() + ": " + s.error().message};
  if (polygons.empty())
    return Error{ErrorCode::InvalidInput,
                 file.string() + ": holds no polygon; draw the areas that are not to be used"};
  return polygons;
}

}  // namespace watersky
