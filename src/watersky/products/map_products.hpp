// SPDX-License-Identifier: MIT
#pragma once
/// Products of maps as they lie on disk, of whatever size: tile by tile, in bounded memory.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/products/products.hpp"
#include "watersky/store/map_diff.hpp"
#include "watersky/store/stored_map.hpp"

namespace watersky {

/// A UUID of a flight as it was recorded: of its name, its frames' and their times. Ask before it
/// is aligned, which changes times.
[[nodiscard]] std::string source_id_of(const Flight& flight);

/// What map.wsmap holds of a run. Its source is the run's, and its tiles' version when it was made,
/// so that of one flight mapped twice the later map counts and its evidence is not counted twice.
[[nodiscard]] StoredMap stored_map(const MapRun& run);

/// Where a stored map's grid lies. InvalidInput when PROJ does not know its projection.
[[nodiscard]] Result<MapReference> reference_of(const MapHeader& header);

/// Of the cells seen, on the ground.
struct StoredMapFigures {
  std::size_t seen_cells = 0;
  double seen_area_m2 = 0.0;
  double ice_concentration = 0.0;  ///< the mean of P(ice); NaN when nothing was seen
};
[[nodiscard]] Result<StoredMapFigures> figures_of(const StoredMap& map,
                                                  const Progress& progress = {});

/// The rasters of a part of the map: P(ice), looks and last look, as Products has them.
[[nodiscard]] Result<ice::Rasters> rasters_of(const StoredMap& map, const CellBox& box);

/// P(ice) of all cells seen, as probability.tif has it. Memory does not grow with the map.
Status export_probability(const StoredMap& map, const std::filesystem::path& path,
                          const Progress& progress = {});

/// probability.tif, looks.tif, last_seen.tif with their styles, map.wsmap and run.json, into a
/// folder that is there whole or not at all; `names` are those of the maps that were merged.
/// Returns what run.json says. Memory does not grow with the map.
[[nodiscard]] Result<nlohmann::json> write_map_products(const StoredMap& map,
                                                        const std::vector<std::string>& names,
                                                        const std::filesystem::path& out,
                                                        const WriteOptions& options = {},
                                                        const Progress& progress = {});

/// What changed, cells and areas on the ground.
[[nodiscard]] Result<nlohmann::json> diff_json(const MapDiff& diff, const Progress& progress = {});
/// The changes as a raster of classes (CellChange), for QGIS with a style beside it.
Status write_diff(const MapDiff& diff, const std::filesystem::path& path,
                  const Progress& progress = {});

/// The products of a flight that goes on with an earlier map: rasters, objects and figures are
/// those of both together, the frames and the mosaic the flight's. InvalidInput when they do not
/// share a grid.
[[nodiscard]] Result<Products> continued_products_of(const MapRun& run, const StoredMap& earlier,
                                                     const ice::ObjectParameters& parameters = {});

}  // namespace watersky
