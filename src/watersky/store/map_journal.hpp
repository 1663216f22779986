// SPDX-License-Identifier: MIT
#pragma once
/// The writing side of a live map's folder (map_store.hpp has the reading side).
///
/// Changed blocks are collected, and commit() writes them as one batch and brings it to the disk:
/// what a commit() acknowledged is there after kill -9 or a power cut at any later instant, and a
/// batch is there whole or not at all. compact() writes a snapshot from what the files hold, while
/// batches go on into the next journal; the older files are removed when the snapshot is on the
/// disk under its name.
///
/// One thread at a time; JournalWriter takes it off the mapping thread.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "watersky/store/map_store.hpp"

namespace watersky {

struct JournalOptions {
  /// compact() is due when the journals hold more than this and more than the snapshot does.
  std::uint64_t compact_above_bytes = std::uint64_t{64} << 20;
};

class MapJournal {
 public:
  /// Goes on with the map in the folder, or begins one as `header` says. Exists when another
  /// process writes there, or a map of another grid lies there; Io for a folder that cannot be
  /// written: say so at the start, not in the air.
  [[nodiscard]] static Result<MapJournal> open(Storage& storage,
                                               const std::filesystem::path& folder,
                                               const MapHeader& header,
                                               const JournalOptions& options = {});
  ~MapJournal();
  MapJournal(MapJournal&&) noexcept;
  MapJournal& operator=(MapJournal&&) = delete;

  /// Of the map in the folder: for a new flight, another source, its number here.
  [[nodiscard]] const MapHeader& header() const;
  /// What the folder held, and what the commits since then added; what is not committed is not in
  /// it. Cheap: nothing is unfolded.
  [[nodiscard]] TileSet tiles() const;
  [[nodiscard]] std::optional<JournalCommit> last() const;
  [[nodiscard]] const std::vector<std::string>& notes() const;

  /// Says that a tile is now so. Of several before one commit the last counts.
  void change(const TileIndex& index, std::uint64_t version, const MapTile& tile,
              std::size_t source = 0);
  /// Brings the changes to the disk. Io when that fails (a full disk, say): the changes are kept,
  /// and the next commit tries again.
  Status commit(Time latest_look);
  [[nodiscard]] std::size_t uncommitted_tiles() const;

  [[nodiscard]] bool compaction_due() const;
  /// A snapshot's work, which needs nothing of the journal and may be done by another thread.
  using Compaction = std::function<Status()>;
  /// Turns to a new journal and gives the work of writing all that is older as a snapshot.
  [[nodiscard]] Result<Compaction> begin_compaction();
  /// After the work succeeded: reads from the snapshot from now on, and removes older files.
  Status end_compaction();
  /// The three in turn.
  Status compact();

 private:
  struct Body;
  explicit MapJournal(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

}  // namespace watersky
