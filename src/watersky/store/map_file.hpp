// SPDX-License-Identifier: MIT
#pragma once
/// A map as one file (.wsmap): a header that says what it is, tiles that are each compressed and
/// checksummed, overviews for display, and an index at the end, so that opening it costs its index
/// and a look costs its tiles. docs/map_file.md describes the bytes.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/store/map_header.hpp"
#include "watersky/store/map_view.hpp"
#include "watersky/store/overviews.hpp"
#include "watersky/store/storage.hpp"
#include "watersky/store/tile_set.hpp"

namespace watersky {

class MapFile {
 public:
  /// Reads the header and the index. NotFound, InvalidInput (no map, cut, damaged) or Unsupported
  /// (a newer version), naming file, byte and remedy. A damaged tile shows when it is read.
  [[nodiscard]] static Result<MapFile> open(std::unique_ptr<StorageFile> file);
  [[nodiscard]] static Result<MapFile> open(Storage& storage, const std::filesystem::path& path);

  /// What is whole of a damaged file, found without its index; `notes` say what is not.
  /// InvalidInput when its header is lost as well: then nobody knows where its cells lie.
  [[nodiscard]] static Result<MapFile> recover(std::unique_ptr<StorageFile> file);

  [[nodiscard]] const MapHeader& header() const;
  [[nodiscard]] const TileSet& tiles() const;
  [[nodiscard]] const std::vector<std::string>& notes() const;
  [[nodiscard]] std::uint64_t bytes() const;

  /// Levels above the map itself; 0: none.
  [[nodiscard]] int levels() const;
  /// Tiles of a level, from 1; in order.
  [[nodiscard]] std::vector<TileIndex> overviews(int level) const;
  /// nullopt when nothing was seen there.
  [[nodiscard]] Result<std::optional<OverviewTile>> overview(int level,
                                                             const TileIndex& index) const;

 private:
  class Body;
  explicit MapFile(std::shared_ptr<const Body> body) : body_(std::move(body)) {}
  std::shared_ptr<const Body> body_;
};

/// Writes a map file, tile by tile, under a temporary name until finish().
class MapFileWriter {
 public:
  [[nodiscard]] static Result<MapFileWriter> begin(Storage& storage,
                                                   const std::filesystem::path& path,
                                                   const MapHeader& header);
  ~MapFileWriter();
  MapFileWriter(MapFileWriter&&) noexcept;
  MapFileWriter& operator=(MapFileWriter&&) = delete;

  /// In any order, each (source, tile) once.
  Status add(std::size_t source, const TileIndex& index, std::uint64_t version,
             const PackedTile& tile);
  Status add_overview(int level, const TileIndex& index, const OverviewTile& tile);
  /// Writes the index, brings all to the disk and puts the file in its place.
  Status finish();

 private:
  struct Body;
  explicit MapFileWriter(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

/// The set as one file with its overviews, a tile at a time. `header`'s sources are those of the
/// set, whatever it says.
Status write_map_file(Storage& storage, const std::filesystem::path& path, const MapHeader& header,
                      const TileSet& tiles, const Progress& progress = {});

}  // namespace watersky
