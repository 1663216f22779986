// SPDX-License-Identifier: MIT
/// `watersky merge MAP… -o OUT`: the maps of several flights as one.
#include "cli.hpp"
#include "watersky/products/map_products.hpp"

namespace watersky::cli {

namespace {

struct Options {
  std::vector<std::string> maps;
  std::string out;
  bool overwrite = false;
  bool recover = false;
};

VerbResult run(const Options& o, const Common& common) {
  const WriteOptions write{.overwrite = o.overwrite};
  WATERSKY_CHECK(check_output(o.out, write));
  std::vector<StoredMap> maps;
  for (const std::string& path : o.maps) {
    WATERSKY_TRY(StoredMap map, open_map(disk(), path, o.recover));
    for (const std::string& note : map.notes) warn(common, note);
    maps.push_back(std::move(map));
  }
  WATERSKY_TRY(const StoredMap merged, merge_maps(maps, o.maps));
  const Progress progress = progress_bar(common);
  WATERSKY_TRY(nlohmann::json result, write_map_products(merged, o.maps, o.out, write, progress));
  for (const MapSource& source : merged.header.sources) say_more(common, "of " + source.name);
  char text[200];
  std::snprintf(text, sizeof text, "Merged %zu maps of %zu flights: %.6g m² seen, %.1f %% ice.",
                maps.size(), merged.header.sources.size(),
                result["figures"]["seen_area_m2"].get<double>(),
                100 * result["figures"]["ice_concentration"].get<double>());
  say(common, text);
  say(common, "Map:    " + o.out + "/probability.tif, " + o.out + "/" + kMapFileName);
  return result;
}

}  // namespace

void add_merge(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App& verb =
      add_verb(app, "merge",
               "Make one map of the maps of several flights; order and repeats make no difference",
               [o](const Common& common) { return run(*o, common); });
  verb.add_option("MAP", o->maps,
                  "map files (.wsmap), folders of 'watersky map' or 'merge', or folders of live "
                  "maps; of one projection, cell size and prior")
      ->required();
  verb.add_option("-o,--out", o->out, "folder to make with the merged map")->required();
  verb.add_flag("--recover", o->recover, "take what is whole of map files that are damaged");
  verb.add_flag("--overwrite", o->overwrite, "replace OUT if it is a map of ours");
}

}  // namespace watersky::cli
