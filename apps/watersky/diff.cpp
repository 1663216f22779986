// SPDX-License-Identifier: MIT
/// `watersky diff A B`: what changed from one map to another.
#include "cli.hpp"
#include "watersky/products/map_products.hpp"

namespace watersky::cli {

namespace {

struct Options {
  std::string before, after, out;
  double ice_probability = 0.5;
};

VerbResult run(const Options& o, const Common& common) {
  WATERSKY_TRY(const StoredMap before, open_map(disk(), o.before));
  WATERSKY_TRY(const StoredMap after, open_map(disk(), o.after));
  WATERSKY_TRY(const MapDiff diff,
               MapDiff::of(before, after, o.before, o.after, o.ice_probability));
  const Progress progress = progress_bar(common);
  WATERSKY_TRY(nlohmann::json result, diff_json(diff, progress));
  if (!o.out.empty()) {
    WATERSKY_CHECK(write_diff(diff, o.out, progress));
    result["raster"] = o.out;
  }
  for (std::size_t i = 0; i < kCellChanges; ++i) {
    std::string name(name_of(static_cast<CellChange>(i)));
    const nlohmann::json& change = result["changes"][name];
    std::replace(name.begin(), name.end(), '_', ' ');
    char text[120];
    std::snprintf(text, sizeof text, "%-14s %12zu cells %14.6g m²", name.c_str(),
                  change["cells"].get<std::size_t>(), change["area_m2"].get<double>());
    say(common, text);
  }
  if (!o.out.empty()) say(common, "Raster: " + o.out);
  return result;
}

}  // namespace

void add_diff(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App& verb = add_verb(app, "diff", "Say what changed from one map to another",
                            [o](const Common& common) { return run(*o, common); });
  verb.add_option("A", o->before, "the earlier map: a map file or a folder that holds one")
      ->required();
  verb.add_option("B", o->after, "the later map, of the same projection, cell size and prior")
      ->required();
  verb.add_option("-o,--out", o->out,
                  "GeoTIFF to write, a class for each cell (became ice, became water, newly seen, "
                  "…), with a style for QGIS");
  verb.add_option("--ice-probability", o->ice_probability, "cells with P(ice) above it are ice")
      ->check(CLI::Range(0.001, 0.999))
      ->capture_default_str();
}

}  // namespace watersky::cli
