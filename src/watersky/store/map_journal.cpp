// SPDX-License-Identifier: MIT
#include "watersky/store/map_journal.hpp"

#include <algorithm>

#include "watersky/store/detail/store_state.hpp"
#include "watersky/store/map_file.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::ChainKey;
using detail::RecordKind;

/// A tile's changes since the last commit.
struct Change {
  std::uint64_t version = 0;
  TileChange tile;
};

}  // namespace

struct MapJournal::Body {
  Storage* storage = nullptr;
  fs::path folder;
  JournalOptions options;
  std::unique_ptr<StorageLock> lock;
  MapStore::State state;
  std::map<ChainKey, BlockDigests> committed;  ///< what is on the disk of tiles changed by us
  std::map<ChainKey, Change> changes;
  detail::JournalFile current;
  /// Of which nothing is known since a sync failed, or that could not be cut: write no more to it.
  bool current_is_lost = false;
  std::uint64_t journal_bytes = 0, snapshot_bytes = 0;
  std::uint32_t compacting = 0;      ///< the snapshot that is being written; 0: none
  std::vector<std::uint32_t> older;  ///< journals that it replaces

  [[nodiscard]] fs::path journal_path(std::uint32_t n) const {
    return folder / detail::journal_name(n);
  }

  /// Turns to a new journal: its name and header are on the disk when this returns.
  Status turn() {
    const std::uint32_t number = state.next_number;
    const std::uint32_t salt = detail::new_salt();
    const fs::path path = journal_path(number);
    WATERSKY_TRY(std::unique_ptr<StorageFile> file, storage->open(path, FileAccess::Create));
    Bytes bytes = detail::encode_preamble({detail::FileKind::Journal, salt});
    const std::string text = header_json(state.header);
    detail::append_record(bytes, RecordKind::Header, salt,
                          {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    // How far the map had come, for a restart from a snapshot with nothing after it.
    if (state.last)
      detail::append_record(bytes, RecordKind::Commit, salt,
                            detail::encode_commit_record({*state.last, 0, 0}));
    WATERSKY_CHECK(file->append(bytes));
    WATERSKY_CHECK(file->sync());
    WATERSKY_CHECK(storage->sync_folder(folder));
    state.next_number = number + 1;
    state.journals.push_back(number);
    current = {std::move(file), salt};
    current_is_lost = false;
    return {};
  }

  /// What a compaction that was cut short left behind.
  Status remove_leftovers() {
    WATERSKY_TRY(const std::vector<std::string> names, storage->list(folder));
    for (const std::string& name : names) {
      const bool part = name.starts_with("snapshot-") && name.ends_with(".part");
      const bool replaced =
          (name.starts_with("snapshot-") && name < detail::snapshot_name(state.snapshot)) ||
          (name.starts_with("journal-") && name < detail::journal_name(state.snapshot));
      if (part || replaced) WATERSKY_CHECK(storage->remove(folder / name));
    }
    return {};
  }

  /// What is on the disk of a tile that this process has not changed yet.
  [[nodiscard]] BlockDigests digests_on_disk(const ChainKey& key) const {
    const auto chain = state.chains.find(key);
    if (chain == state.chains.end()) return {};
    const auto tile = chain->second.load();
    // One that cannot be read is written anew, whole.
    return tile ? change_of(*tile, {}).digests : BlockDigests{};
  }
};

MapJournal::MapJournal(std::unique_ptr<Body> body) : body_(std::move(body)) {}
MapJournal::MapJournal(MapJournal&&) noexcept = default;
MapJournal::~MapJournal() = default;

Result<MapJournal> MapJournal::open(Storage& storage, const fs::path& folder,
                                    const MapHeader& header, const JournalOptions& options) {
  auto body = std::make_unique<Body>();
  body->storage = &storage;
  body->folder = folder;
  body->options = options;
  WATERSKY_CHECK(storage.make_folder(folder));
  WATERSKY_TRY(body->lock, storage.lock(folder));
  if (auto store = MapStore::open(storage, folder)) {
    body->state = *store->state();
    const auto between = tiles_between(header, body->state.header);
    if (!between || *between != TileIndex{})
      return Error{ErrorCode::Exists,
                   folder.string() + ": holds a map of another grid (" +
                       describe_grid(body->state.header) +
                       "); choose another folder, or give its projection, cell size and prior"};
    for (const MapSource& source : header.sources)
      if (!body->state.header.find_source(source.id)) body->state.header.sources.push_back(source);
  } else if (store.error().code == ErrorCode::NotFound) {
    body->state.header = header;
    // A journal that never came to hold a header is in nobody's way, but its number is taken.
    WATERSKY_TRY(const std::vector<std::string> names, storage.list(folder));
    while (std::find(names.begin(), names.end(), detail::journal_name(body->state.next_number)) !=
           names.end())
      ++body->state.next_number;
  } else {
    return store.error();
  }
  // What was read may stand in the page cache alone, left there by a process that was killed: it is
  // on the disk before anybody relies on it. Torn ends go.
  for (const std::uint32_t n : body->state.journals) {
    auto file = storage.open(body->journal_path(n), FileAccess::Append);
    if (!file) return file.error();
    for (const auto& [path, size] : body->state.to_cut)
      if (path == (*file)->path()) WATERSKY_CHECK((*file)->truncate(size));
    WATERSKY_CHECK((*file)->sync());
    body->journal_bytes += (*file)->size();
  }
  WATERSKY_CHECK(body->turn());
  WATERSKY_CHECK(body->remove_leftovers());
  return MapJournal(std::move(body));
}

const MapHeader& MapJournal::header() const { return body_->state.header; }
TileSet MapJournal::tiles() const {
  return detail::tiles_of(body_->state.header.sources, body_->state.chains);
}
std::optional<JournalCommit> MapJournal::last() const { return body_->state.last; }
const std::vector<std::string>& MapJournal::notes() const { return body_->state.notes; }
std::size_t MapJournal::uncommitted_tiles() const { return body_->changes.size(); }

void MapJournal::change(const TileIndex& index, std::uint64_t version, const MapTile& tile,
                        std::size_t source) {
  WATERSKY_REQUIRE(source < body_->state.header.sources.size());
  const ChainKey key{index, static_cast<std::uint32_t>(source)};
  auto known = body_->committed.find(key);
  if (known == body_->committed.end())
    known = body_->committed.emplace(key, body_->digests_on_disk(key)).first;
  TileChange change = change_of(tile, known->second);
  if (change.digests == known->second) {
    body_->changes.erase(key);
  } else {
    body_->changes[key] = {version, std::move(change)};
  }
}

Status MapJournal::commit(Time latest_look) {
  Body& b = *body_;
  if (b.changes.empty()) return {};
  if (b.current_is_lost) WATERSKY_CHECK(b.turn());
  StorageFile& file = *b.current.file;
  const std::uint64_t start = file.size();
  Bytes bytes;
  std::vector<std::uint64_t> offsets;
  for (const auto& [key, change] : b.changes) {
    offsets.push_back(start + bytes.size());
    const Bytes payload =
        detail::encode_patch_record(key.first, key.second, change.version, change.tile);
    detail::append_record(bytes, RecordKind::Patch, b.current.salt, payload);
  }
  const JournalCommit commit{(b.state.last ? b.state.last->sequence : 0) + 1, latest_look};
  const Bytes payload =
      detail::encode_commit_record({commit, start, static_cast<std::uint32_t>(b.changes.size())});
  detail::append_record(bytes, RecordKind::Commit, b.current.salt, payload);
  if (const Status appended = file.append(bytes); !appended) {
    b.current_is_lost = !file.truncate(start).ok();
    return appended;
  }
  if (const Status synced = file.sync(); !synced) {
    b.current_is_lost = true;
    return synced;
  }
  std::size_t i = 0;
  for (auto& [key, change] : b.changes) {
    detail::TileChain& chain = b.state.chains[key];
    chain.add({b.current, offsets[i++], change.tile.changed.blocks});
    chain.version = change.version;
    chain.digest = tile_digest(change.tile.digests);
    chain.present = change.tile.present();
    chain.seen_cells = change.tile.seen_cells;
    b.committed[key] = change.tile.digests;
  }
  b.changes.clear();
  b.state.last = commit;
  b.journal_bytes += bytes.size();
  return {};
}

bool MapJournal::compaction_due() const {
  const Body& b = *body_;
  constexpr std::size_t kMostJournals = 16;  // restart after restart, each with its own
  return b.compacting == 0 &&
         (b.journal_bytes > std::max(b.options.compact_above_bytes, b.snapshot_bytes) ||
          b.state.journals.size() > kMostJournals);
}

Result<MapJournal::Compaction> MapJournal::begin_compaction() {
  Body& b = *body_;
  if (b.compacting != 0)
    return Error{ErrorCode::Exists, b.folder.string() + ": a snapshot is being written already"};
  std::vector<std::uint32_t> older = b.state.journals;
  WATERSKY_CHECK(b.turn());
  b.older = std::move(older);
  b.compacting = b.state.journals.back();
  b.journal_bytes = 0;
  return Compaction([storage = b.storage, path = b.folder / detail::snapshot_name(b.compacting),
                     header = b.state.header,
                     tiles = tiles()] { return write_map_file(*storage, path, header, tiles); });
}

Status MapJournal::end_compaction() {
  Body& b = *body_;
  const std::uint32_t number = std::exchange(b.compacting, 0);
  if (number == 0) return {};
  const fs::path path = b.folder / detail::snapshot_name(number);
  // Not there: the work failed, and all that it would have replaced still is. Next time, then.
  WATERSKY_TRY(const MapFile snapshot, MapFile::open(*b.storage, path));
  for (const TileItem& item : snapshot.tiles().items()) {
    const auto source = b.state.header.find_source(snapshot.tiles().sources()[item.source].id);
    detail::TileChain& chain = b.state.chains.at({item.index, static_cast<std::uint32_t>(*source)});
    chain.base = item;
    // What was committed meanwhile is in the journal that begins with the snapshot, or later.
    std::erase_if(chain.patches, [&](const detail::Patch& patch) {
      const fs::path journal = patch.journal.file->path();
      return std::any_of(b.older.begin(), b.older.end(),
                         [&](std::uint32_t n) { return journal == b.journal_path(n); });
    });
  }
  b.snapshot_bytes = snapshot.bytes();
  for (const std::uint32_t n : b.older) {
    WATERSKY_CHECK(b.storage->remove(b.journal_path(n)));
    std::erase(b.state.journals, n);
  }
  if (b.state.snapshot != 0)
    WATERSKY_CHECK(b.storage->remove(b.folder / detail::snapshot_name(b.state.snapshot)));
  b.state.snapshot = number;
  return b.storage->sync_folder(b.folder);
}

Status MapJournal::compact() {
  WATERSKY_TRY(const Compaction work, begin_compaction());
  const Status written = work();
  const Status ended = end_compaction();
  return written ? ended : written;
}

}  // namespace watersky
