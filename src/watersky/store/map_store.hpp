// SPDX-License-Identifier: MIT
#pragma once
/// A live map's folder, as it can be read at any moment, after whatever end: the latest snapshot
/// (a map file) and the journals written since.
///
///   snapshot-00000007.wsmap   the map as of the beginning of journal 7
///   journal-00000007.wsj      what changed since, in batches that count when they are whole
///   journal-00000008.wsj      a later one: after a restart, or while snapshot 8 is being written
///
/// Nothing is unfolded when it is opened: a tile is read from where its blocks lie when it is asked
/// for.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "watersky/store/map_header.hpp"
#include "watersky/store/storage.hpp"
#include "watersky/store/tile_set.hpp"

namespace watersky {

/// The end of a batch.
struct JournalCommit {
  std::uint64_t sequence = 0;  ///< counts on over restarts, from 1
  Time time{};                 ///< as it was given: the latest look in the map
};

class MapStore {
 public:
  /// NotFound when the folder holds no map. Damage is not an error: what is whole is there, and
  /// notes() say what is not.
  [[nodiscard]] static Result<MapStore> open(Storage& storage, const std::filesystem::path& folder);

  [[nodiscard]] const MapHeader& header() const;
  [[nodiscard]] const TileSet& tiles() const;
  /// The last batch that was restored; nullopt when there was none yet.
  [[nodiscard]] std::optional<JournalCommit> last() const;
  [[nodiscard]] const std::vector<std::string>& notes() const;

  struct State;
  /// For the journal, which goes on from here.
  [[nodiscard]] const std::shared_ptr<State>& state() const { return state_; }

 private:
  explicit MapStore(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

}  // namespace watersky
