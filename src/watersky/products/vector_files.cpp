// SPDX-License-Identifier: MIT
#include "watersky/products/vector_files.hpp"

#include <cpl_string.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>

#include "watersky/base/time.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/gdal_session.hpp"
#include "watersky/products/frame_figures.hpp"
#include "watersky/products/qgis_style.hpp"

namespace watersky {

namespace {

/// Adds features to one layer; remembers whether all went well.
class LayerWriter {
 public:
  explicit LayerWriter(OGRLayer* layer) : layer_(layer), ok_(layer != nullptr) {}

  LayerWriter& field(const char* name, OGRFieldType type, OGRFieldSubType subtype = OFSTNone) {
    if (!ok_) return *this;
    OGRFieldDefn definition(name, type);
    definition.SetSubType(subtype);
    ok_ = layer_->CreateField(&definition) == OGRERR_NONE;
    return *this;
  }

  [[nodiscard]] OGRFeatureUniquePtr feature() const {
    return OGRFeatureUniquePtr(ok_ ? OGRFeature::CreateFeature(layer_->GetLayerDefn()) : nullptr);
  }
  void add(OGRFeatureUniquePtr feature, std::unique_ptr<OGRGeometry> geometry) {
    if (!ok_ || !feature) return;
    if (geometry) feature->SetGeometryDirectly(geometry.release());
    ok_ = layer_->CreateFeature(feature.get()) == OGRERR_NONE;
  }
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  OGRLayer* layer_;
  bool ok_;
};

void set_time(OGRFeature& feature, const char* name, double seconds_utc, bool is_utc) {
  const std::optional<Time> time = time_from_seconds(seconds_utc);
  if (!time) return;
  const auto day = std::chrono::floor<std::chrono::days>(*time);
  const std::chrono::year_month_day date{day};
  const std::chrono::hh_mm_ss clock{*time - day};
  feature.SetField(feature.GetFieldIndex(name), static_cast<int>(date.year()),
                   static_cast<int>(static_cast<unsigned>(date.month())),
                   static_cast<int>(static_cast<unsigned>(date.day())),
                   static_cast<int>(clock.hours().count()),
                   static_cast<int>(clock.minutes().count()),
                   static_cast<float>(static_cast<double>(clock.seconds().count()) +
                                      to_seconds(Duration(clock.subseconds()))),
                   is_utc ? 100 : 0);  // OGR's flags for UTC and for an unknown zone
}

/// Infinite or unknown becomes NULL.
void set_known(OGRFeature& feature, const char* name, double value) {
  if (std::isfinite(value)) feature.SetField(name, value);
}

void add_points(OGRSimpleCurve& line, const std::vector<Eigen::Vector2d>& points) {
  line.setNumPoints(static_cast<int>(points.size()), FALSE);
  for (std::size_t i = 0; i < points.size(); ++i)
    line.setPoint(static_cast<int>(i), points[i].x(), points[i].y());
}

void add_ring(OGRPolygon& polygon, std::vector<Eigen::Vector2d> points) {
  auto ring = std::make_unique<OGRLinearRing>();
  if (!points.empty()) points.push_back(points.front());
  add_points(*ring, points);
  polygon.addRingDirectly(ring.release());
}

std::unique_ptr<OGRGeometry> outline(const Products& products, const ice::IceObject& object) {
  const auto placed = [&](const ice::Ring& ring) {
    std::vector<Eigen::Vector2d> points;
    points.reserve(ring.size() + 1);
    for (const Eigen::Vector2d& p : ring) points.push_back(products.easting_northing_m(p));
    return points;
  };
  auto geometry = std::make_unique<OGRMultiPolygon>();
  for (const ice::Polygon& part : object.outline) {
    auto polygon = std::make_unique<OGRPolygon>();
    add_ring(*polygon, placed(part.outer));
    for (const ice::Ring& hole : part.holes) add_ring(*polygon, placed(hole));
    geometry->addGeometryDirectly(polygon.release());
  }
  return geometry;
}

LayerWriter& object_fields(LayerWriter& layer) {
  return layer.field("id", OFTInteger)
      .field("size_class", OFTString)
      .field("lat_deg", OFTReal)
      .field("lon_deg", OFTReal)
      .field("length_m", OFTReal)
      .field("width_m", OFTReal)
      .field("area_m2", OFTReal)
      .field("equivalent_diameter_m", OFTReal)
      .field("perimeter_m", OFTReal)
      .field("solidity", OFTReal)
      .field("gap_m", OFTReal)
      .field("cut_by_edge", OFTInteger, OFSTBoolean)
      .field("mean_probability", OFTReal)
      .field("mean_looks", OFTReal)
      .field("last_seen", OFTDateTime)
      .field("last_seen_s", OFTReal);
}

void add_object(LayerWriter& layer, const Products& products, const ice::IceObject& object) {
  OGRFeatureUniquePtr f = layer.feature();
  if (!f) return;
  f->SetField("id", object.id);
  f->SetField("size_class", std::string(object.size_class).c_str());
  if (const auto place =
          products.projection.inverse(products.easting_northing_m(object.centroid))) {
    f->SetField("lat_deg", place->latitude.degrees());
    f->SetField("lon_deg", place->longitude.degrees());
  }
  f->SetField("length_m", object.length_m);
  f->SetField("width_m", object.width_m);
  f->SetField("area_m2", object.area_m2);
  f->SetField("equivalent_diameter_m", object.equivalent_diameter_m);
  f->SetField("perimeter_m", object.perimeter_m);
  f->SetField("solidity", object.solidity);
  set_known(*f, "gap_m", object.gap_m);
  f->SetField("cut_by_edge", object.cut_by_edge ? 1 : 0);
  f->SetField("mean_probability", object.mean_probability);
  f->SetField("mean_looks", object.mean_looks);
  set_time(*f, "last_seen", object.last_seen_s, products.times_are_utc);
  set_known(*f, "last_seen_s", object.last_seen_s);
  layer.add(std::move(f), outline(products, object));
}

bool write_objects(OGRLayer* target, const Products& products, ice::ObjectKind kind) {
  LayerWriter layer(target);
  object_fields(layer);
  for (const ice::IceObject& object : products.objects)
    if (object.kind == kind) add_object(layer, products, object);
  return layer.ok();
}

bool write_footprints(OGRLayer* target, const Products& products) {
  LayerWriter layer(target);
  layer.field("file", OFTString)
      .field("captured", OFTDateTime)
      .field("captured_s", OFTReal)
      .field("height_above_sea_m", OFTReal)
      .field("gsd_m", OFTReal)
      .field("off_nadir_deg", OFTReal)
      .field("ice_fraction", OFTReal)
      .field("cut_by_grazing_limit", OFTInteger, OFSTBoolean);
  for (const UsedFrame& frame : products.used) {
    OGRFeatureUniquePtr f = layer.feature();
    if (!f) return false;
    f->SetField("file", utf8(frame.file).c_str());
    set_time(*f, "captured", to_seconds(frame.time), products.times_are_utc);
    f->SetField("captured_s", to_seconds(frame.time));
    f->SetField("height_above_sea_m", frame.height_above_sea_m);
    f->SetField("gsd_m", frame.gsd_m);
    f->SetField("off_nadir_deg", off_nadir(frame).degrees());
    set_known(*f, "ice_fraction", frame.ice_fraction);
    f->SetField("cut_by_grazing_limit", frame.cut_by_grazing_limit ? 1 : 0);
    auto polygon = std::make_unique<OGRPolygon>();
    add_ring(*polygon, frame.footprint_easting_northing_m);
    layer.add(std::move(f), std::move(polygon));
  }
  return layer.ok();
}

bool write_tracks(OGRLayer* target, const Products& products) {
  LayerWriter layer(target);
  layer.field("kind", OFTString)
      .field("name", OFTString)
      .field("start", OFTDateTime)
      .field("end", OFTDateTime)
      .field("length_m", OFTReal);
  const std::vector<TrackPoint> track = aircraft_track(products);
  if (track.size() < 2) return layer.ok();
  auto line = std::make_unique<OGRLineString>();
  std::vector<Eigen::Vector2d> points;
  for (const TrackPoint& p : track) points.push_back(p.easting_northing_m);
  add_points(*line, points);
  OGRFeatureUniquePtr f = layer.feature();
  if (!f) return false;
  f->SetField("kind", "aircraft");
  f->SetField("name", utf8(products.flight_name).c_str());
  set_time(*f, "start", track.front().time_s, products.times_are_utc);
  set_time(*f, "end", track.back().time_s, products.times_are_utc);
  f->SetField("length_m", line->get_Length());
  layer.add(std::move(f), std::move(line));
  return layer.ok();
}

struct StyledLayer {
  const char* name;
  VectorStyle style;
};
const StyledLayer kLayers[] = {
    {"footprints", {SymbolKind::Outline, kFootprintColor, 0.2, 0.0}},
    {"floes", {SymbolKind::Outline, kFloeColor, 0.3, 0.0}},
    {"icebergs", {SymbolKind::Fill, kIcebergColor, 0.6, 0.35}},
    {"tracks", {SymbolKind::Line, kTrackColor, 0.5, 0.0}},
};

/// The table in which QGIS keeps the styles of a GeoPackage's layers, by QGIS's own column names.
bool write_styles(GDALDataset& package) {
  CPLStringList options;
  options.SetNameValue("FID", "id");
  LayerWriter table(package.CreateLayer("layer_styles", nullptr, wkbNone, options.List()));
  for (const char* name : {"f_table_catalog", "f_table_schema", "f_table_name", "f_geometry_column",
                           "styleName", "styleQML", "styleSLD"})
    table.field(name, OFTString);
  table.field("useAsDefault", OFTInteger, OFSTBoolean);
  for (const char* name : {"description", "owner", "ui"}) table.field(name, OFTString);
  table.field("update_time", OFTDateTime);
  for (const StyledLayer& layer : kLayers) {
    OGRFeatureUniquePtr f = table.feature();
    if (!f) return false;
    f->SetField("f_table_catalog", "");
    f->SetField("f_table_schema", "");
    f->SetField("f_table_name", layer.name);
    f->SetField("f_geometry_column", "geom");
    f->SetField("styleName", layer.name);
    f->SetField("styleQML", vector_qml(layer.style).c_str());
    f->SetField("styleSLD", vector_sld(layer.name, layer.style).c_str());
    f->SetField("useAsDefault", 1);
    f->SetField("description", "Watersky");
    f->SetField("owner", "");
    f->SetField("ui", "");
    table.add(std::move(f), nullptr);
  }
  return table.ok();
}

/// The map's projection, easting first.
bool read_crs(const Products& products, OGRSpatialReference& crs) {
  if (crs.importFromWkt(products.projection.wkt().c_str()) != OGRERR_NONE) return false;
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return true;
}

}  // namespace

Status write_geopackage(const std::filesystem::path& path, const Products& products) {
  GdalSession gdal;
  OGRSpatialReference crs;
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
  if (!driver)
    return Error{ErrorCode::Unsupported,
                 path.string() + ": this GDAL cannot write GeoPackage; install one with SQLite"};
  if (!read_crs(products, crs)) return gdal.error(path);

  const MemoryFile file(".gpkg");
  DatasetPtr package(driver->Create(file.name().c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  if (!package || package->StartTransaction(FALSE) != OGRERR_NONE) return gdal.error(path);
  const auto layer = [&](const char* name, OGRwkbGeometryType type, const char* description) {
    CPLStringList options;
    options.SetNameValue("GEOMETRY_NAME", "geom");
    options.SetNameValue("DESCRIPTION", description);
    return package->CreateLayer(name, &crs, type, options.List());
  };
  const bool written =
      write_footprints(layer("footprints", wkbPolygon, "What each used frame saw of the sea"),
                       products) &&
      write_objects(layer("floes", wkbMultiPolygon, "Connected pieces of ice"), products,
                    ice::ObjectKind::Floe) &&
      write_objects(layer("icebergs", wkbMultiPolygon,
                          "Iceberg candidates: pieces that are alone, compact and seen whole; "
                          "without height or temperature they cannot be told from floes"),
                    products, ice::ObjectKind::IcebergCandidate) &&
      write_tracks(layer("tracks", wkbLineString, "Where the aircraft was"), products) &&
      write_styles(*package);
  if (!written || package->CommitTransaction() != OGRERR_NONE) return gdal.error(path);
  package.reset();
  if (gdal.failed()) return gdal.error(path);
  return write_file(path, file.bytes());
}

Status write_icebergs_geojson(const std::filesystem::path& path, const Products& products) {
  GdalSession gdal;
  OGRSpatialReference crs;
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GeoJSON");
  if (!driver)
    return Error{ErrorCode::Unsupported, path.string() + ": this GDAL cannot write GeoJSON"};
  if (!read_crs(products, crs)) return gdal.error(path);
  const MemoryFile file(".geojson");
  DatasetPtr collection(driver->Create(file.name().c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  if (!collection) return gdal.error(path);
  CPLStringList options;
  options.SetNameValue("RFC7946", "YES");
  // 1e-8° is a millimetre: cells may be centimetres.
  options.SetNameValue("COORDINATE_PRECISION", "8");
  options.SetNameValue("WRITE_NAME", "NO");
  if (!write_objects(collection->CreateLayer("icebergs", &crs, wkbMultiPolygon, options.List()),
                     products, ice::ObjectKind::IcebergCandidate))
    return gdal.error(path);
  collection.reset();
  if (gdal.failed()) return gdal.error(path);
  return write_file(path, file.bytes());
}

}  // namespace watersky
