// SPDX-License-Identifier: MIT
#include "watersky/products/run_json.hpp"

#include <nlohmann/json.hpp>

#include "watersky/base/time.hpp"
#include "watersky/products/alignment_report.hpp"
#include "watersky/products/detail/versions.hpp"
#include "watersky/products/frame_figures.hpp"

namespace watersky {

namespace {

using nlohmann::json;

template <class Parameters>
json described(const Parameters& parameters) {
  json object = json::object();
  Parameters::describe(parameters, [&](const auto& value, const ParameterInfo& info) {
    object[std::string(info.name)] = {{"value", value}, {"unit", info.unit}, {"help", info.help}};
  });
  return object;
}

json text_or_null(const std::string& text) { return text.empty() ? json() : json(text); }

/// ISO 8601; without the Z when the clock's zone is not known.
json time_or_null(double seconds_utc, bool is_utc) {
  const auto time = time_from_seconds(seconds_utc);
  if (!time) return {};
  std::string text = to_iso8601(*time);
  if (!is_utc) text.pop_back();
  return text;
}

json extent(const Products& products) {
  const cv::Mat& p = products.rasters.probability;
  const Eigen::Vector2d north_west = products.easting_northing_m({-0.5, -0.5});
  const Eigen::Vector2d south_east = products.easting_northing_m({p.cols - 0.5, p.rows - 0.5});
  json corners = json::array();
  for (const Eigen::Vector2d& corner :
       {north_west, Eigen::Vector2d(south_east.x(), north_west.y()), south_east,
        Eigen::Vector2d(north_west.x(), south_east.y())}) {
    const auto place = products.projection.inverse(corner);
    corners.push_back(place ? json{{"lat_deg", place->latitude.degrees()},
                                   {"lon_deg", place->longitude.degrees()}}
                            : json());
  }
  return {{"west_m", north_west.x()},
          {"east_m", south_east.x()},
          {"south_m", south_east.y()},
          {"north_m", north_west.y()},
          {"corners_from_north_west_clockwise", corners}};
}

json smoothing(const field::Smoothed& s) {
  return {{"coupling", s.coupling},
          {"coupling_is", s.best_foretelling ? "chosen from the map" : "given"},
          {"coupling_best_foretelling", s.best_foretelling ? json(*s.best_foretelling) : json()},
          {"iterations", s.iterations},
          {"last_change", s.last_change},
          {"seconds",
           {{"coupling", s.coupling_s}, {"marginals", s.marginals_s}, {"most_likely", s.cut_s}}}};
}

json figures(const Products& products) {
  const FrameFigures frames = frame_figures(products);
  const ice::FloeStatistics& floes = products.floes;
  std::size_t candidates = 0;
  for (const ice::IceObject& o : products.objects)
    candidates += o.kind == ice::ObjectKind::IcebergCandidate ? 1 : 0;
  json bins = json::array();
  for (const ice::SizeBin& bin : floes.bins)
    bins.push_back({{"from_m", bin.from_m},
                    {"to_m", bin.to_m},
                    {"count", bin.count},
                    {"area_m2", bin.area_m2}});
  return {{"seen_area_m2", products.concentration.seen_area_m2},
          {"seen_cells", products.concentration.seen_cells},
          {"ice_concentration", products.concentration.expected},
          {"ice_concentration_thresholded", products.concentration.thresholded},
          {"floes", products.objects.size() - candidates},
          {"iceberg_candidates", candidates},
          {"gsd_median_m", frames.median_gsd_m},
          {"height_above_sea_min_m", frames.min_height_m},
          {"height_above_sea_max_m", frames.max_height_m},
          {"off_nadir_max_deg", frames.max_off_nadir_deg},
          {"first_frame", time_or_null(frames.first_s, products.times_are_utc)},
          {"last_frame", time_or_null(frames.last_s, products.times_are_utc)},
          {"floe_sizes",
           {{"whole_pieces", floes.count},
            {"pieces_cut_by_edge", floes.cut_by_edge},
            {"mean_diameter_m", floes.mean_diameter_m},
            {"area_weighted_mean_diameter_m", floes.area_weighted_mean_diameter_m},
            {"mean_length_m", floes.mean_length_m},
            {"area_weighted_mean_length_m", floes.area_weighted_mean_length_m},
            {"largest_length_m", floes.largest_length_m},
            {"diameter_bins", bins}}}};
}

}  // namespace

json run_json(const Products& products) {
  const detail::Versions versions = detail::versions();
  json left_out = json::array();
  for (const LeftOut& frame : products.left_out)
    left_out.push_back({{"file", frame.file}, {"reason", frame.reason}});
  const Geodetic& datum = products.datum.origin();
  const cv::Mat& p = products.rasters.probability;
  return {
      {"watersky", versions.watersky},
      {"versions",
       {{"watersky", versions.watersky},
        {"opencv", versions.opencv},
        {"gdal", versions.gdal},
        {"proj", versions.proj}}},
      {"flight", products.flight_name},
      {"made_at",
       to_iso8601(std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now()))},
      {"frames",
       {{"total", products.frames_total}, {"used", products.used.size()}, {"left_out", left_out}}},
      {"figures", figures(products)},
      {"notes", products.notes},
      {"parameters",
       {{"mapping", described(products.options.parameters)},
        {"objects", described(products.object_parameters)},
        {"alignment", products.alignment ? described(products.alignment->parameters) : json()},
        {"smoothing", products.smoothing ? described(products.smoothing->parameters) : json()}}},
      {"threads", products.options.threads},
      {"segmentation", name_of(products.options.method)},
      {"model",
       text_or_null(model_name(products.options.method, products.options.parameters.segmentation))},
      {"pond_is", products.options.parameters.segmentation.learned.ponds_are_ice ? "ice" : "water"},
      {"ice", {{"asked", name_of(products.options.ice)}, {"used", name_of(products.ice)}}},
      {"sea_level", text_or_null(products.sea_level)},
      {"calibration", text_or_null(products.calibration)},
      {"times_are_utc", products.times_are_utc},
      {"mount", text_or_null(products.mount)},
      {"datum",
       {{"lat_deg", datum.latitude.degrees()},
        {"lon_deg", datum.longitude.degrees()},
        {"height_ellipsoid_m", datum.height_ellipsoid_m},
        {"x_azimuth_deg", products.datum.x_azimuth().degrees()}}},
      {"projection", {{"name", products.projection.name()}, {"wkt", products.projection.wkt()}}},
      {"grid",
       {{"columns", p.cols},
        {"rows", p.rows},
        {"cell_m", products.cell_m()},
        {"scale", products.scale},
        {"geotransform", products.geotransform}}},
      {"extent", extent(products)},
      {"alignment", products.alignment ? alignment_summary_json(*products.alignment) : json()},
      {"smoothing", products.smoothing ? smoothing(*products.smoothing) : json()},
      {"timings_s",
       {{"mapping", products.mapping_wall_s},
        {"alignment", products.alignment ? json(products.alignment->wall_s) : json()},
        {"smoothing", products.smoothing ? json(products.smoothing->wall_s()) : json()}}},
  };
}

std::string run_json_text(const Products& products) {
  return run_json(products).dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace watersky
