// SPDX-License-Identifier: MIT
#pragma once
/// What a live map's folder holds, as its reader and its writer know it.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "watersky/store/detail/tile_record.hpp"
#include "watersky/store/map_store.hpp"

namespace watersky::detail {

/// A journal that is read from, perhaps while it grows.
struct JournalFile {
  std::shared_ptr<StorageFile> file;
  std::uint32_t salt = 0;
};

/// Blocks of a tile, in a journal.
struct Patch {
  JournalFile journal;
  std::uint64_t offset = 0;
  std::uint64_t blocks = 0;
};

/// A tile as what the snapshot has of it and what was written since, oldest first.
struct TileChain {
  std::optional<TileItem> base;
  std::vector<Patch> patches;
  std::uint64_t version = 0;
  std::uint64_t digest = 0;
  std::uint64_t present = ~std::uint64_t{0};  ///< blocks that the tile has, of all that are found
  std::uint32_t seen_cells = 0;

  /// Forgets patches of which later ones hold every block, so that there are 64 at most.
  void add(Patch patch);
  [[nodiscard]] Result<MapTile> load() const;
};

using ChainKey = std::pair<TileIndex, std::uint32_t>;  ///< tile, source
using TileChains = std::map<ChainKey, TileChain>;

/// The chains as they are now; later changes do not reach the set.
[[nodiscard]] TileSet tiles_of(const std::vector<MapSource>& sources, const TileChains& chains);

/// A patch record: what the whole tile comes to, and the changed blocks as a tile record.
struct PatchRecord {
  std::uint64_t digest = 0;   ///< of the whole tile
  std::uint64_t present = 0;  ///< blocks of the whole tile
  std::uint32_t seen_cells = 0;
  TileRecord changed;
};
[[nodiscard]] Bytes encode_patch_record(const TileIndex& index, std::uint32_t source,
                                        std::uint64_t version, const TileChange& change);
[[nodiscard]] Result<PatchRecord> parse_patch_record(const Record& record);

struct CommitRecord {
  JournalCommit commit;
  std::uint64_t batch_offset = 0;  ///< of its first record
  std::uint32_t records = 0;       ///< in the batch, without the commit
};
[[nodiscard]] Bytes encode_commit_record(const CommitRecord& commit);
[[nodiscard]] Result<CommitRecord> parse_commit_record(const Record& record);

[[nodiscard]] std::string snapshot_name(std::uint32_t number);
[[nodiscard]] std::string journal_name(std::uint32_t number);

}  // namespace watersky::detail

namespace watersky {

struct MapStore::State {
  MapHeader header;
  detail::TileChains chains;
  TileSet tiles;
  std::optional<JournalCommit> last;
  std::vector<std::string> notes;
  std::uint32_t snapshot = 0;           ///< the number of the one that was read; 0: none
  std::vector<std::uint32_t> journals;  ///< numbers of those that were read
  std::uint32_t next_number = 1;        ///< above all that is there
  /// Journals of which a torn end has to be cut before anything is written.
  std::vector<std::pair<std::filesystem::path, std::uint64_t>> to_cut;
};

}  // namespace watersky
