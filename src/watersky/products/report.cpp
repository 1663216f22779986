// SPDX-License-Identifier: MIT
#include "watersky/products/report.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "watersky/io/files.hpp"
#include "watersky/products/detail/alignment_sections.hpp"
#include "watersky/products/detail/html.hpp"
#include "watersky/products/detail/report_map.hpp"
#include "watersky/products/detail/report_style.hpp"
#include "watersky/products/detail/versions.hpp"
#include "watersky/products/frame_figures.hpp"
#include "watersky/products/palette.hpp"

namespace watersky {

namespace {

using namespace detail;

constexpr std::size_t kMaxIcebergRows = 200;

std::string element(const char* name, const std::string& inner) {
  return std::string("<") + name + ">" + inner + "</" + name + ">";
}

std::string gradient(Ramp ramp) {
  std::string stops;
  for (const RampStop& s : ramp)
    stops.append(",").append(hex(s.color)).append(" ").append(number(100 * s.at, 0)).append("%");
  return "linear-gradient(90deg" + stops + ")";
}

std::string figure_card(const std::string& name, const std::string& value,
                        const std::string& more) {
  return "<div class=\"card\"><dt>" + name + "</dt><dd>" + value + "<small>" + more +
         "</small></dd></div>";
}

std::size_t iceberg_candidates(const Products& products) {
  return static_cast<std::size_t>(std::count_if(
      products.objects.begin(), products.objects.end(),
      [](const ice::IceObject& o) { return o.kind == ice::ObjectKind::IcebergCandidate; }));
}

double track_length_m(const Products& products) {
  const std::vector<TrackPoint> track = aircraft_track(products);
  double length_m = 0;
  for (std::size_t i = 1; i < track.size(); ++i)
    length_m += (track[i].easting_northing_m - track[i - 1].easting_northing_m).norm();
  return length_m;
}

std::string title(const Products& products, const FrameFigures& frames) {
  std::string place;
  const cv::Mat& p = products.rasters.probability;
  if (const auto middle =
          products.projection.inverse(products.easting_northing_m({p.cols / 2.0, p.rows / 2.0})))
    place = latitude(middle->latitude, 3) + ", " + longitude(middle->longitude, 3);
  std::string when = moment(frames.first_s, products.times_are_utc);
  if (std::isfinite(frames.first_s) && frames.last_s > frames.first_s)
    when += " to " + moment(frames.last_s, products.times_are_utc);
  return "<header><div><p class=\"kicker\">Watersky · sea ice map</p><h1>" +
         escaped(products.flight_name) + "</h1><p>" + when + "</p><p>" + place +
         "</p></div></header>";
}

std::string cards(const Products& products, const FrameFigures& frames) {
  const std::size_t candidates = iceberg_candidates(products);
  const ice::Concentration& c = products.concentration;
  const bool level = !(frames.max_height_m - frames.min_height_m > 1);
  return "<dl class=\"cards\">" +
         figure_card(
             "Ice concentration", percent(c.thresholded),
             "of the area seen is more likely ice than not; mean P(ice) " + percent(c.expected)) +
         figure_card("Area seen", square_metres(c.seen_area_m2),
                     "cells of " + metres(products.cell_m())) +
         figure_card(
             "Pieces of ice", std::to_string(products.objects.size()),
             std::to_string(products.floes.cut_by_edge) + " cut by the edge of what was seen") +
         figure_card("Iceberg candidates", std::to_string(candidates),
                     "alone, compact and seen whole") +
         figure_card(
             "Frames used",
             std::to_string(products.used.size()) + " of " + std::to_string(products.frames_total),
             products.left_out.empty()
                 ? "none left out"
                 : std::to_string(products.left_out.size()) + " left out, see below") +
         figure_card("Ground sample distance", metres(frames.median_gsd_m),
                     "median; up to " + number(frames.max_off_nadir_deg, 1) + "° off nadir") +
         figure_card("Height above the sea",
                     level ? metres(frames.max_height_m)
                           : rounded(frames.min_height_m) + " to " + metres(frames.max_height_m),
                     escaped(products.sea_level)) +
         figure_card(
             "Flown over the map", metres(track_length_m(products)),
             "in " + number(std::isfinite(frames.first_s) ? frames.last_s - frames.first_s : 0, 0) +
                 " s, first to last frame") +
         "</dl>";
}

std::string map_section(const Products& products, const std::string& svg) {
  const bool looks = !products.rasters.looks.empty();
  const bool mosaic = !products.mosaic_bgra.empty();
  const auto input = [](const char* type, const char* id, bool checked) {
    return std::string("<input type=\"") + type + "\" id=\"" + id + "\"" +
           (std::string_view(type) == "radio" ? " name=\"base\"" : "") +
           (checked ? " checked" : "") + ">";
  };
  const auto label = [](const char* id, const char* text) {
    return std::string("<label for=\"") + id + "\">" + text + "</label>";
  };
  const std::string ramp =
      "<span class=\"ramp\" style=\"background:" + gradient(kProbabilityRamp) + "\"></span>";
  const std::string looks_ramp =
      "<span class=\"ramp\" style=\"background:" + gradient(kCountRamp) + "\"></span>";
  return "<section class=\"sheet\"><h2>Map</h2>" + input("radio", "b-probability", true) +
         (mosaic ? input("radio", "b-mosaic", false) : "") +
         (looks ? input("radio", "b-looks", false) : "") +
         input("checkbox", "o-footprints", products.used.size() <= 40) +
         input("checkbox", "o-track", true) + input("checkbox", "o-icebergs", true) +
         input("checkbox", "o-graticule", true) + "<div class=\"switches\"><span class=\"group\">" +
         label("b-probability", "Probability of ice") +
         (mosaic ? label("b-mosaic", "Photographs") : "") +
         (looks ? label("b-looks", "Looks") : "") + "</span><span class=\"group\">" +
         label("o-track", "Flight") + label("o-footprints", "Footprints") +
         label("o-icebergs", "Iceberg candidates") + label("o-graticule", "Graticule") +
         "</span></div><figure>" + svg +
         "<figcaption><span class=\"key k-probability\"><b>P(ice)</b> water 0 " + ramp +
         " 1 ice</span>" +
         (looks ? "<span class=\"key k-looks\"><b>Looks</b> 1 " + looks_ramp + " " +
                      std::to_string(most_looks(products)) + "</span>"
                : "") +
         "<span class=\"key\"><i class=\"swatch unseen\"></i> not seen</span>"
         "<span class=\"key\"><i class=\"swatch line track\"></i> flight, from the open "
         "circle</span>"
         "<span class=\"key\"><i class=\"swatch line footprint\"></i> what a frame saw</span>"
         "<span class=\"key\"><i class=\"swatch ring\"></i> iceberg candidate</span>"
         "<span class=\"key\">" +
         escaped(products.projection.name()) + ", WGS-84</span></figcaption></figure></section>";
}

/// As a tick says it: 0.71, 5.7, 64.
std::string short_number(double value) {
  return number(value, value < 0.95 ? 2 : value < 9.5 ? 1 : 0);
}

std::string histogram(const ice::FloeStatistics& floes) {
  constexpr double kWidth = 640;
  constexpr double kHeight = 200;
  const double slot = kWidth / static_cast<double>(floes.bins.size());
  double most = 0;
  for (const ice::SizeBin& bin : floes.bins)
    most = std::max({most, static_cast<double>(bin.count) / static_cast<double>(floes.count),
                     bin.area_m2 / floes.area_m2});
  const double top = most > 0.8 ? 1.0 : most > 0.4 ? 0.8 : most > 0.2 ? 0.4 : 0.2;
  std::string svg =
      "<svg class=\"chart\" role=\"img\" aria-label=\"Floe sizes\" "
      "xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-46 -14 " +
      number(kWidth + 60, 0) + " " + number(kHeight + 62, 0) + "\">";
  for (int i = 0; i <= 4; ++i) {
    const std::string y = number(kHeight * (1 - i / 4.0), 1);
    svg += "<path class=\"grid\" d=\"M0," + y + "H" + number(kWidth, 0) +
           "\"/><text x=\"-6\" y=\"" + y + "\" dy=\"4\" text-anchor=\"end\">" +
           number(100 * top * i / 4, 0) + " %</text>";
  }
  const std::size_t every = floes.bins.size() / 10 + 1;
  for (std::size_t i = 0; i < floes.bins.size(); ++i) {
    const ice::SizeBin& bin = floes.bins[i];
    const double x = slot * static_cast<double>(i);
    const auto bar = [&](const char* kind, double share, double offset) {
      const double height = kHeight * share / top;
      return std::string("<rect class=\"") + kind + "\" x=\"" + number(x + slot * offset, 1) +
             "\" y=\"" + number(kHeight - height, 1) + "\" width=\"" + number(slot * 0.38, 1) +
             "\" height=\"" + number(height, 1) + "\"/>";
    };
    svg += "<g><title>" + rounded(bin.from_m) + " to " + metres(bin.to_m) + ": " +
           std::to_string(bin.count) + " pieces, " + square_metres(bin.area_m2) + "</title>" +
           bar("by-count", static_cast<double>(bin.count) / static_cast<double>(floes.count), 0.1) +
           bar("by-area", bin.area_m2 / floes.area_m2, 0.52) + "</g>";
    if (i % every == 0)
      svg += "<text x=\"" + number(x, 1) + "\" y=\"" + number(kHeight + 18, 0) +
             "\" text-anchor=\"middle\">" + short_number(bin.from_m) + "</text>";
  }
  return svg + "<text x=\"" + number(kWidth / 2, 0) + "\" y=\"" + number(kHeight + 40, 0) +
         "\" text-anchor=\"middle\">diameter of the circle of equal area, m</text></svg>";
}

std::string floe_section(const Products& products) {
  const ice::FloeStatistics& f = products.floes;
  std::string html = "<section><h2>Floe sizes</h2>";
  if (f.count == 0)
    return html + "<p>No piece of ice of at least " +
           std::to_string(products.object_parameters.min_cells) +
           " cells was seen whole.</p></section>";
  return html + histogram(f) +
         "<p class=\"keys\"><span class=\"key\"><i class=\"swatch by-count\"></i> share of the "
         "pieces</span>"
         "<span class=\"key\"><i class=\"swatch by-area\"></i> share of their area</span></p>"
         "<p>" +
         std::to_string(f.count) + " pieces seen whole; " + std::to_string(f.cut_by_edge) +
         " that touch the edge of what was seen are not counted. Mean diameter " +
         metres(f.mean_diameter_m) + " (weighted by area " +
         metres(f.area_weighted_mean_diameter_m) + "), mean length " + metres(f.mean_length_m) +
         " (weighted by area " + metres(f.area_weighted_mean_length_m) + "), longest " +
         metres(f.largest_length_m) + ".</p></section>";
}

std::string iceberg_section(const Products& products) {
  const std::size_t candidates = iceberg_candidates(products);
  std::string html = "<section><h2>Iceberg candidates</h2>";
  if (candidates == 0)
    return html + "<p>None: no piece of ice is alone, compact and seen whole.</p></section>";
  html += "<p>Pieces with at least " + short_number(products.object_parameters.isolation_gap_m) +
          " m of water around them, compact and seen whole. Without their height or temperature "
          "they cannot be told from small floes.</p>"
          "<div "
          "class=\"scroll\"><table><thead><tr><th>No.</th><th>Latitude</th><th>Longitude</"
          "th><th>Size</th><th class=\"n\">Length</th>"
          "<th class=\"n\">Width</th><th class=\"n\">Area</th><th class=\"n\">P(ice)</th><th "
          "class=\"n\">Looks</th><th>Last seen</th></tr></thead><tbody>";
  std::size_t rows = 0;
  for (const ice::IceObject& o : products.objects) {
    if (o.kind != ice::ObjectKind::IcebergCandidate) continue;
    if (++rows > kMaxIcebergRows) break;
    const auto place = products.projection.inverse(products.easting_northing_m(o.centroid));
    html += "<tr><td>" + std::to_string(o.id) + "</td><td>" +
            (place ? latitude(place->latitude, 3) : "–") + "</td><td>" +
            (place ? longitude(place->longitude, 3) : "–") + "</td><td>" + escaped(o.size_class) +
            "</td><td class=\"n\">" + metres(o.length_m) + "</td><td class=\"n\">" +
            metres(o.width_m) + "</td><td class=\"n\">" + square_metres(o.area_m2) +
            "</td><td class=\"n\">" + number(o.mean_probability, 2) + "</td><td class=\"n\">" +
            number(o.mean_looks, 1) + "</td><td>" + moment(o.last_seen_s, products.times_are_utc) +
            "</td></tr>";
  }
  html += "</tbody></table></div>";
  if (candidates > kMaxIcebergRows)
    html += "<p>The largest " + std::to_string(kMaxIcebergRows) + " of " +
            std::to_string(candidates) + "; all are in icebergs.geojson and ice.gpkg.</p>";
  return html + "</section>";
}

std::string left_out_section(const Products& products) {
  std::string html = "<section><h2>Frames left out</h2>";
  if (products.left_out.empty())
    return html + "<p>None. All " + std::to_string(products.frames_total) +
           " frames are in the map.</p></section>";
  std::map<std::string, std::vector<std::string>> files_of_reason;
  for (const LeftOut& frame : products.left_out)
    files_of_reason[frame.reason].push_back(frame.file);
  html += "<p>" + std::to_string(products.left_out.size()) + " of " +
          std::to_string(products.frames_total) + " frames.</p>";
  for (const auto& [reason, files] : files_of_reason) {
    std::string list;
    for (const std::string& file : files) list += "<li>" + escaped(file) + "</li>";
    html += std::string("<details") + (files.size() <= 12 ? " open" : "") + "><summary><b>" +
            std::to_string(files.size()) + "</b> " + escaped(reason) +
            "</summary><ul class=\"files\">" + list + "</ul></details>";
  }
  return html + "</section>";
}

std::string notes_section(const Products& products) {
  if (products.notes.empty()) return {};
  std::string list;
  for (const std::string& note : products.notes) list += element("li", escaped(note));
  return "<section><h2>Assumed, chosen and noticed</h2><ul>" + list + "</ul></section>";
}

std::string row(const std::string& name, const std::string& value) {
  return value.empty() ? "" : "<tr><th>" + name + "</th><td>" + escaped(value) + "</td></tr>";
}

std::string smoothing_line(const Products& products) {
  if (!products.smoothing) return {};
  const field::Smoothed& s = *products.smoothing;
  return "smoothed.tif and most_likely.tif: coupling " + number(s.coupling, 3) +
         (s.best_foretelling ? ", chosen from the map" : ", given") + "; " +
         std::to_string(s.iterations) + (s.iterations == 1 ? " iteration, " : " iterations, ") +
         number(s.wall_s(), 2) + " s. The map and the figures above are those of the looks alone.";
}

std::string making_section(const Products& products) {
  const Versions versions = detail::versions();
  std::string html =
      "<section><h2>How it was made</h2><div class=\"scroll\"><table class=\"facts\"><tbody>" +
      row("Sea level", products.sea_level) + row("Calibration", products.calibration) +
      row("Mount", products.mount) +
      row("Segmentation", std::string(name_of(products.options.method))) +
      row("Ice is", products.ice == IcePolarity::Darker     ? "darker than water"
                    : products.ice == IcePolarity::Brighter ? "brighter than water"
                                                            : "") +
      row("Smoothing", smoothing_line(products)) +
      row("Projection", products.projection.name() + " on WGS-84") +
      row("Programs", "Watersky " + versions.watersky + ", OpenCV " + versions.opencv + ", GDAL " +
                          versions.gdal + ", PROJ " + versions.proj) +
      row("Time to map", number(products.mapping_wall_s, 2) + " s, " +
                             std::to_string(products.options.threads) +
                             (products.options.threads == 1 ? " thread" : " threads")) +
      "</tbody></table></div><details><summary>Parameters</summary><div class=\"scroll\"><table "
      "class=\"facts\"><tbody>";
  const auto parameter = [&](const auto& value, const ParameterInfo& info) {
    std::string text;
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, bool>)
      text = value ? "yes" : "no";
    else
      text = number(static_cast<double>(value), 6);
    if (text.find('.') != std::string::npos) {
      text.erase(text.find_last_not_of('0') + 1);
      if (text.back() == '.') text.pop_back();
    }
    if (info.unit != "1") text += " " + std::string(info.unit);
    html += "<tr><th><code>" + escaped(info.name) + "</code></th><td class=\"n\">" + escaped(text) +
            "</td><td>" + escaped(info.help) + "</td></tr>";
  };
  MappingParameters::describe(products.options.parameters, parameter);
  ice::ObjectParameters::describe(products.object_parameters, parameter);
  if (products.alignment) AlignParameters::describe(products.alignment->parameters, parameter);
  if (products.smoothing)
    field::SmoothingParameters::describe(products.smoothing->parameters, parameter);
  return html + "</tbody></table></div></details></section>";
}

}  // namespace

Result<std::string> report_html(const Products& products) {
  WATERSKY_TRY(const std::string svg, map_svg(products));
  const FrameFigures frames = frame_figures(products);
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
         "<meta name=\"color-scheme\" content=\"light dark\"><title>Sea ice map: " +
         escaped(products.flight_name) + "</title><style>" + report_css() +
         "</style></head><body>" + title(products, frames) + "<main>" + cards(products, frames) +
         map_section(products, svg) + floe_section(products) + iceberg_section(products) +
         (products.alignment ? alignment_section(*products.alignment) : "") +
         left_out_section(products) + notes_section(products) + making_section(products) +
         "</main><footer>Probability, looks and times as GeoTIFF, outlines as GeoPackage and "
         "GeoJSON, every figure as run.json lie beside this page.</footer></body></html>\n";
}

Status write_report(const std::filesystem::path& path, const Products& products) {
  Result<std::string> html = report_html(products);
  if (!html) return html.error().at(path.string());
  return write_file(path, *html);
}

}  // namespace watersky
