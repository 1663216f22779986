// SPDX-License-Identifier: MIT
#pragma once
/// Polygons of the world: land, a ship, a fjord.
#include <filesystem>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/geodesy/geo_polygon.hpp"

namespace watersky {

/// All polygons of a vector file: GeoJSON, GeoPackage, Shapefile, KML, whatever GDAL reads, in
/// any coordinate system that it knows (none given: longitude, latitude on WGS-84). Lines and
/// points are not areas and are passed over. InvalidInput when the file holds no polygon, or one
/// that is not on the earth.
[[nodiscard]] Result<std::vector<GeoPolygon>> read_polygons(const std::filesystem::path& file);

/// Whether the name ends as that of a vector file: .geojson .json .gpkg .shp .kml.
[[nodiscard]] bool is_polygon_file(const std::filesystem::path& file);

}  // namespace watersky
