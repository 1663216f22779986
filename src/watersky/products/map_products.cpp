// SPDX-License-Identifier: MIT
#include "watersky/products/map_products.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "watersky/io/files.hpp"
#include "watersky/products/detail/map_rasters.hpp"
#include "watersky/products/detail/run_folder.hpp"
#include "watersky/products/detail/versions.hpp"
#include "watersky/products/qgis_style.hpp"
#include "watersky/store/map_file.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using nlohmann::json;

/// Projection metres per metre on the ground at the middle of a box.
double scale_at(const MapReference& reference, const CellBox& box) {
  const auto place = reference.projection.inverse(reference.easting_northing_m(
      box.first_column + 0.5 * box.columns, box.first_row + 0.5 * box.rows));
  if (!place) return 1.0;
  const auto projected = reference.projection.at(*place);
  return projected ? std::sqrt(std::abs(projected->grid_from_north_east.determinant())) : 1.0;
}

double ground_cell_m2(const MapReference& reference, const CellBox& box) {
  const double cell_m = reference.cell_m / scale_at(reference, box);
  return cell_m * cell_m;
}

json iso_or_null(const std::optional<Time>& time, bool utc) {
  if (!time) return {};
  std::string text = to_iso8601(*time);
  if (!utc) text.pop_back();
  return text;
}

json sources_json(const MapHeader& header) {
  json out = json::array();
  for (const MapSource& s : header.sources)
    out.push_back({{"id", s.id},
                   {"flight", s.name},
                   {"first", iso_or_null(s.first, s.times_are_utc)},
                   {"last", iso_or_null(s.last, s.times_are_utc)}});
  return out;
}

RasterText text_of(const char* description, const char* unit) {
  return {description, unit, {{"TIFFTAG_SOFTWARE", "Watersky"}}};
}

/// The colours of the changes; what stayed is pale.
constexpr std::array<std::pair<CellChange, Rgb>, kCellChanges> kChangeColors{
    {{CellChange::StayedWater, {20, 62, 110}},
     {CellChange::StayedIce, {247, 252, 255}},
     {CellChange::BecameWater, {213, 94, 0}},
     {CellChange::BecameIce, {0, 158, 115}},
     {CellChange::NewWater, {104, 158, 189}},
     {CellChange::NewIce, {177, 211, 224}},
     {CellChange::OnlyBefore, {120, 120, 120}}}};

/// A raster of a stored map.
struct MapRaster {
  const char* file;
  int type;
  const char* description;
  const char* unit;
  Result<cv::Mat> (detail::MapRasters::*read)(const CellBox&);
};
constexpr std::array<MapRaster, 3> kMapRasters{
    {{"probability.tif", CV_32F, "probability of ice", "1", &detail::MapRasters::probability},
     {"looks.tif", CV_16U, "frames that showed the cell", "1", &detail::MapRasters::looks},
     {"last_seen.tif", CV_64F, "time of the last look, UTC since 1970", "s",
      &detail::MapRasters::last_seen_s}}};

Status write_raster(const StoredMap& map, const CellBox& box, const RasterPlace& place,
                    const MapRaster& raster, const fs::path& path, const Progress& progress) {
  detail::MapRasters rasters(map);
  const auto read = [&](const cv::Rect& part) {
    return (rasters.*raster.read)(detail::part_of(box, part));
  };
  return write_geotiff(path, StreamedRaster{box.columns, box.rows, raster.type, read}, place,
                       text_of(raster.description, raster.unit), progress);
}

}  // namespace

std::string source_id_of(const Flight& flight) {
  std::string told = flight.name;
  for (const ImageFrame& frame : flight.frames) {
    told += '\n' + frame.name;
    for (const auto& time : {frame.captured_at, frame.received_at})
      if (time) told += ' ' + std::to_string(time->time_since_epoch().count());
  }
  return source_id_from(told);
}

StoredMap stored_map(const MapRun& run) {
  MapSource source{.id = run.source_id.empty() ? new_source_id() : run.source_id,
                   .name = run.flight_name,
                   .times_are_utc = run.times_are_utc};
  for (const UsedFrame& frame : run.used) {
    source.first = std::min(source.first.value_or(frame.time), frame.time);
    source.last = std::max(source.last.value_or(frame.time), frame.time);
  }
  const auto made_at = std::chrono::system_clock::now().time_since_epoch();
  const auto version = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(made_at).count());
  const MapParameters& parameters = run.map.parameters();
  return {.header = {.projection = run.reference.projection.name(),
                     .wkt = run.reference.projection.wkt(),
                     .anchor_easting_m = run.reference.anchor_easting_m,
                     .anchor_northing_m = run.reference.anchor_northing_m,
                     .cell_m = parameters.cell_m,
                     .prior = parameters.prior,
                     .max_probability = parameters.max_probability,
                     .half_life_s = parameters.half_life_s,
                     .sources = {source}},
          .tiles = tiles_of(run.map, source, version)};
}

Result<MapReference> reference_of(const MapHeader& header) {
  auto projection = Projection::from_text(header.wkt);
  if (!projection) projection = Projection::from_text(header.projection);
  if (!projection) return projection.error().at("the map's projection " + header.projection);
  return MapReference{*projection, header.anchor_easting_m, header.anchor_northing_m,
                      header.cell_m};
}

Result<StoredMapFigures> figures_of(const StoredMap& map, const Progress& progress) {
  StoredMapFigures out;
  WATERSKY_TRY(const MapReference reference, reference_of(map.header));
  const std::vector<TileIndex> tiles = map.tiles.tiles();
  const double prior = log_odds(map.header.prior);
  double sum = 0.0;
  std::size_t done = 0;
  for (const TileIndex& index : tiles) {
    report(progress, "count", done++, tiles.size());
    WATERSKY_TRY(const MapTile tile, view_tile(map.tiles, index, map.view()));
    std::size_t seen = 0;
    for (int b = 0; b < MapTile::kBlocks * MapTile::kBlocks; ++b)
      if (const MapTile::Block* block = tile.block(b))
        for (std::size_t c = 0; c < block->looks.size(); ++c)
          if (block->looks[c] != 0) {
            sum += probability(static_cast<double>(block->evidence[c]) / kEvidenceUnits + prior);
            ++seen;
          }
    out.seen_cells += seen;
    out.seen_area_m2 += static_cast<double>(seen) * ground_cell_m2(reference, cells_of(index));
  }
  out.ice_concentration = sum / static_cast<double>(out.seen_cells);
  return out;
}

Result<ice::Rasters> rasters_of(const StoredMap& map, const CellBox& box) {
  detail::MapRasters rasters(map);
  WATERSKY_TRY(const cv::Mat probability, rasters.probability(box));
  WATERSKY_TRY(const cv::Mat looks, rasters.looks(box));
  WATERSKY_TRY(const cv::Mat last_seen_s, rasters.last_seen_s(box));
  return ice::Rasters{probability, looks, last_seen_s};
}

Status export_probability(const StoredMap& map, const fs::path& path, const Progress& progress) {
  WATERSKY_TRY(const MapReference reference, reference_of(map.header));
  WATERSKY_TRY(const CellBox box, seen_box(map.tiles));
  return write_raster(map, box, {reference.geotransform(box), map.header.wkt}, kMapRasters[0], path,
                      progress);
}

Result<json> write_map_products(const StoredMap& map, const std::vector<std::string>& names,
                                const fs::path& out, const WriteOptions& options,
                                const Progress& progress) {
  WATERSKY_CHECK(check_output(out, options));
  WATERSKY_TRY(const MapReference reference, reference_of(map.header));
  WATERSKY_TRY(const CellBox box, seen_box(map.tiles));
  if (box.empty())
    return Error{ErrorCode::OutOfRange,
                 out.string() + ": not written: no cell of the map was seen"};
  WATERSKY_TRY(const StoredMapFigures figures, figures_of(map, progress));
  WATERSKY_TRY(PartialFolder partial, PartialFolder::beside(out));
  const fs::path& folder = partial.path();
  const RasterPlace place{reference.geotransform(box), map.header.wkt};
  const auto write = [&]() -> Status {
    WATERSKY_CHECK(write_map_file(disk(), folder / kMapFileName, map.header, map.tiles, progress));
    for (const MapRaster& raster : kMapRasters)
      WATERSKY_CHECK(write_raster(map, box, place, raster, folder / raster.file, progress));
    return write_file(folder / "probability.qml", raster_qml(kProbabilityRamp, 0, 1, ""));
  };
  if (const Status written = write(); !written)
    return detail::named_as_asked(written.error(), folder, out);
  const detail::Versions versions = detail::versions();
  json run = {
      {"watersky", versions.watersky},
      {"made_at",
       to_iso8601(std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now()))},
      {"merged", names},
      {"sources", sources_json(map.header)},
      {"notes", map.notes},
      {"projection", {{"name", map.header.projection}, {"wkt", map.header.wkt}}},
      {"grid",
       {{"columns", box.columns},
        {"rows", box.rows},
        {"cell_m", map.header.cell_m},
        {"geotransform", place.geotransform}}},
      {"figures",
       {{"seen_cells", figures.seen_cells},
        {"seen_area_m2", figures.seen_area_m2},
        {"ice_concentration", figures.ice_concentration}}}};
  WATERSKY_CHECK(write_file(folder / "run.json",
                            run.dump(2, ' ', false, json::error_handler_t::replace) + "\n"));
  WATERSKY_CHECK(partial.publish());
  return run;
}

Result<json> diff_json(const MapDiff& diff, const Progress& progress) {
  WATERSKY_TRY(const MapReference reference, reference_of(diff.header()));
  WATERSKY_TRY(const CellBox box, diff.seen());
  WATERSKY_TRY(const MapDiff::Counts counts, diff.count(progress));
  const double cell_m2 = ground_cell_m2(reference, box);
  json changes = json::object();
  for (std::size_t i = 0; i < counts.size(); ++i)
    changes[std::string(name_of(static_cast<CellChange>(i)))] = {
        {"cells", counts[i]}, {"area_m2", static_cast<double>(counts[i]) * cell_m2}};
  return json{{"changes", changes},
              {"cell_m", diff.header().cell_m},
              {"projection", diff.header().projection}};
}

Status write_diff(const MapDiff& diff, const fs::path& path, const Progress& progress) {
  WATERSKY_TRY(const MapReference reference, reference_of(diff.header()));
  WATERSKY_TRY(const CellBox box, diff.seen());
  const auto read = [&](const cv::Rect& part) -> Result<cv::Mat> {
    cv::Mat out(part.height, part.width, CV_8U, cv::Scalar(kNeitherSeen));
    WATERSKY_CHECK(detail::for_each_tile(
        detail::part_of(box, part),
        [&](const TileIndex& index, const cv::Rect& from, const cv::Rect& to) -> Status {
          if (!std::binary_search(diff.tiles().begin(), diff.tiles().end(), index)) return {};
          WATERSKY_TRY(TileChanges changes, diff.changes(index));
          cv::Mat(kTileCells, kTileCells, CV_8U, changes.data())(from).copyTo(out(to));
          return {};
        }));
    return out;
  };
  WATERSKY_CHECK(write_geotiff(
      path, StreamedRaster{box.columns, box.rows, CV_8U, read},
      {reference.geotransform(box), diff.header().wkt},
      text_of("what changed: 0 stayed water, 1 stayed ice, 2 became water, 3 became ice, 4 newly "
              "seen water, 5 newly seen ice, 6 seen before only",
              "1"),
      progress));
  std::vector<ClassStyle> classes;
  for (const auto& [change, color] : kChangeColors) {
    std::string label(name_of(change));
    std::replace(label.begin(), label.end(), '_', ' ');
    classes.push_back({static_cast<int>(change), color, label});
  }
  fs::path style = path;
  style.replace_extension(".qml");
  return write_file(style, classes_qml(classes));
}

Result<Products> continued_products_of(const MapRun& run, const StoredMap& earlier,
                                       const ice::ObjectParameters& parameters) {
  const StoredMap today = stored_map(run);
  WATERSKY_TRY(StoredMap merged,
               merge_maps({today, earlier}, {run.flight_name, "the earlier map"}));
  WATERSKY_TRY(const CellBox box, seen_box(merged.tiles));
  Products p = products_of(run, parameters);
  WATERSKY_TRY(p.rasters, rasters_of(merged, box));
  if (!run.uncertainty.empty()) {
    p.evidence_probability = p.rasters.probability;
    p.rasters.probability = run.uncertainty.softened(p.evidence_probability, box);
  }
  p.geotransform = run.reference.geotransform(box);
  if (!run.mosaic.empty()) p.mosaic_bgra = run.mosaic.bgra(box);
  p.scale = scale_at(run.reference, box);
  p.map = std::make_shared<const StoredMap>(std::move(merged));
  char text[120];
  std::snprintf(text, sizeof text, "The map goes on from an earlier one of %zu flights.",
                earlier.header.sources.size());
  p.notes.emplace_back(text);
  analyse(p);
  return p;
}

}  // namespace watersky
