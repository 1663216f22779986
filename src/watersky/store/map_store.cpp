// SPDX-License-Identifier: MIT
#include "watersky/store/map_store.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "watersky/store/detail/store_state.hpp"
#include "watersky/store/map_file.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::FileKind;
using detail::Record;
using detail::RecordKind;

/// The number in "journal-00000007.wsj"; nullopt for other names.
std::optional<std::uint32_t> number_of(std::string_view name, std::string_view before,
                                       std::string_view after) {
  if (!name.starts_with(before) || !name.ends_with(after) ||
      name.size() <= before.size() + after.size())
    return std::nullopt;
  name.remove_prefix(before.size());
  name.remove_suffix(after.size());
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc() || end != name.data() + name.size()) return std::nullopt;
  return number;
}

struct Found {
  std::vector<std::uint32_t> snapshots, journals;  ///< ascending
};

Found find_files(const std::vector<std::string>& names) {
  Found found;
  for (const std::string& name : names) {
    if (const auto n = number_of(name, "snapshot-", ".wsmap")) found.snapshots.push_back(*n);
    if (const auto n = number_of(name, "journal-", ".wsj")) found.journals.push_back(*n);
  }
  std::sort(found.snapshots.begin(), found.snapshots.end());
  std::sort(found.journals.begin(), found.journals.end());
  return found;
}

/// Reads one journal into a state.
class Replay {
 public:
  Replay(MapStore::State& state, std::unique_ptr<StorageFile> file)
      : state_(state), journal_{std::move(file), 0} {}

  void run() {
    std::uint64_t at = 0;
    if (const auto preamble = detail::read_preamble(file(), FileKind::Journal)) {
      journal_.salt = preamble->salt;
      at = good_end_ = detail::kPreambleBytes;
    } else if (const auto first = detail::find_record(file(), 0, std::nullopt)) {
      // Its first bytes are damaged, but what they said stands in every record.
      journal_.salt = first->salt;
      at = first->offset;
      damaged_ = true;
    } else {
      return;  // made, but nothing had reached the disk
    }
    while (at < file().size()) {
      auto record = detail::read_record(file(), at, journal_.salt);
      if (!record) {
        damaged_ = true;
        auto next = detail::find_record(file(), at + 8, journal_.salt);
        if (!next) break;
        take(*next);
        at = next->end();
        continue;
      }
      take(*record);
      at = record->end();
    }
    if (good_end_ > 0 && good_end_ < file().size())
      state_.to_cut.emplace_back(file().path(), good_end_);
  }

 private:
  struct Pending {
    detail::ChainKey key;
    std::uint64_t version = 0, digest = 0, present = 0, blocks = 0, offset = 0;
    std::uint32_t seen_cells = 0;
  };

  [[nodiscard]] const StorageFile& file() const { return *journal_.file; }

  void take(const Record& record) {
    if (record.kind == RecordKind::Header) return take_header(record);
    if (record.kind == RecordKind::Commit) return take_commit(record);
    if (records_ == 0) batch_offset_ = record.offset;
    ++records_;
    const auto patch = detail::parse_patch_record(record);
    const auto source = patch ? number_in_state(patch->changed.source) : std::nullopt;
    if (!source) return;
    batch_.push_back({{patch->changed.index, *source},
                      patch->changed.version,
                      patch->digest,
                      patch->present,
                      patch->changed.tile.blocks,
                      record.offset,
                      patch->seen_cells});
  }

  void take_header(const Record& record) {
    const auto header =
        parse_header({reinterpret_cast<const char*>(record.payload.data()), record.payload.size()});
    if (!header) return;
    if (state_.header.wkt.empty()) state_.header = *header;
    numbers_.clear();
    for (const MapSource& source : header->sources) {
      const auto known = state_.header.find_source(source.id);
      numbers_.push_back(static_cast<std::uint32_t>(known.value_or(state_.header.sources.size())));
      if (!known) state_.header.sources.push_back(source);
    }
    good_end_ = record.end();
  }

  /// Each file counts sources in its own header's order.
  [[nodiscard]] std::optional<std::uint32_t> number_in_state(std::uint32_t source) const {
    if (source < numbers_.size()) return numbers_[source];
    // Its header is lost: with one source there is no doubt.
    if (numbers_.empty() && state_.header.sources.size() == 1 && source == 0) return 0;
    return std::nullopt;
  }

  void take_commit(const Record& record) {
    const auto commit = detail::parse_commit_record(record);
    const bool whole = commit && commit->records == records_ &&
                       (records_ == 0 || commit->batch_offset == batch_offset_);
    if (whole) {
      // A batch is on the disk before the next begins: what is damaged before a whole one was no
      // power cut's torn end, and what is whole of it counts.
      if (damaged_ && !told_) {
        told_ = true;
        state_.notes.push_back(file().path().string() +
                               ": a part of it is damaged; the changes that stood there are lost.");
      }
      for (const Pending& p : uncertain_) apply(p);
      uncertain_.clear();
      for (const Pending& p : batch_) apply(p);
      if (!state_.last || commit->commit.sequence > state_.last->sequence)
        state_.last = commit->commit;
      good_end_ = record.end();
    } else {
      uncertain_.insert(uncertain_.end(), batch_.begin(), batch_.end());
    }
    batch_.clear();
    records_ = 0;
  }

  void apply(const Pending& p) {
    detail::TileChain& chain = state_.chains[p.key];
    chain.add({journal_, p.offset, p.blocks});
    chain.version = p.version;
    chain.digest = p.digest;
    chain.present = p.present;
    chain.seen_cells = p.seen_cells;
  }

  MapStore::State& state_;
  detail::JournalFile journal_;
  std::vector<std::uint32_t> numbers_;  ///< in the state, of the sources of this journal
  std::vector<Pending> batch_, uncertain_;
  std::uint64_t batch_offset_ = 0, good_end_ = 0;
  std::uint32_t records_ = 0;
  bool damaged_ = false, told_ = false;
};

void take_snapshot(MapStore::State& state, const MapFile& file) {
  state.header = file.header();
  // The set numbers sources by their ids, the header by their order.
  std::vector<std::uint32_t> number;
  for (const MapSource& source : file.tiles().sources())
    number.push_back(static_cast<std::uint32_t>(*file.header().find_source(source.id)));
  for (const TileItem& item : file.tiles().items())
    state.chains[{item.index, number[item.source]}] = {.base = item,
                                                       .patches = {},
                                                       .version = item.version,
                                                       .digest = item.digest,
                                                       .seen_cells = item.seen_cells};
  state.notes.insert(state.notes.end(), file.notes().begin(), file.notes().end());
}

}  // namespace

Result<MapStore> MapStore::open(Storage& storage, const fs::path& folder) {
  WATERSKY_TRY(const std::vector<std::string> names, storage.list(folder));
  const Found found = find_files(names);
  const Error none{ErrorCode::NotFound,
                   folder.string() + ": holds no map (no snapshot and no journal of watersky)"};
  if (found.snapshots.empty() && found.journals.empty()) return none;
  auto state = std::make_shared<State>();
  for (const auto* numbers : {&found.snapshots, &found.journals})
    if (!numbers->empty()) state->next_number = std::max(state->next_number, numbers->back() + 1);

  for (auto n = found.snapshots.rbegin(); n != found.snapshots.rend() && state->snapshot == 0;
       ++n) {
    const fs::path path = folder / detail::snapshot_name(*n);
    auto file = MapFile::open(storage, path);
    if (!file) {
      if (file.error().code == ErrorCode::Unsupported) return file.error();
      state->notes.push_back(file.error().message);
      auto again = storage.open(path, FileAccess::Read);
      if (!again) continue;
      file = MapFile::recover(*std::move(again));
      if (!file) continue;
    }
    take_snapshot(*state, *file);
    state->snapshot = *n;
  }
  for (const std::uint32_t n : found.journals) {
    if (n < state->snapshot) continue;
    const fs::path path = folder / detail::journal_name(n);
    auto file = storage.open(path, FileAccess::Read);
    if (!file) {
      state->notes.push_back(file.error().message);
      continue;
    }
    const auto preamble = detail::read_preamble(**file, FileKind::Journal);
    if (!preamble && preamble.error().code == ErrorCode::Unsupported) return preamble.error();
    Replay(*state, *std::move(file)).run();
    state->journals.push_back(n);
  }
  if (state->header.sources.empty()) return none;
  state->tiles = detail::tiles_of(state->header.sources, state->chains);
  return MapStore(std::move(state));
}

const MapHeader& MapStore::header() const { return state_->header; }
const TileSet& MapStore::tiles() const { return state_->tiles; }
std::optional<JournalCommit> MapStore::last() const { return state_->last; }
const std::vector<std::string>& MapStore::notes() const { return state_->notes; }

}  // namespace watersky
