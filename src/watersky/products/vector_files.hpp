// SPDX-License-Identifier: MIT
#pragma once
/// What was found, as vector files.
#include <filesystem>

#include "watersky/products/products.hpp"

namespace watersky {

/// A GeoPackage in the map's projection with the layers `footprints` (one polygon a used frame),
/// `floes`, `icebergs` (candidates: ice/objects.hpp) and `tracks` (of kind "aircraft"), and
/// their styles for QGIS in `layer_styles`. Io when it cannot be written; then nothing is left.
Status write_geopackage(const std::filesystem::path& path, const Products& products);

/// The iceberg candidates as GeoJSON, RFC 7946: longitude and latitude on WGS-84, outer lines
/// counter-clockwise, units in the names.
Status write_icebergs_geojson(const std::filesystem::path& path, const Products& products);

}  // namespace watersky
