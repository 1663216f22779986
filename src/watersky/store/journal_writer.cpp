// SPDX-License-Identifier: MIT
#include "watersky/store/journal_writer.hpp"

#include <condition_variable>
#include <future>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

namespace watersky {

using Clock = std::chrono::steady_clock;

struct JournalWriter::Body {
  explicit Body(MapJournal opened) : journal(std::move(opened)) {}

  MapJournal journal;  ///< the thread's alone, once it runs
  MapHeader header;
  TileSet restored;
  std::size_t source = 0;
  JournalWriterOptions options;

  mutable std::mutex mutex;
  std::condition_variable_any changed;
  std::map<TileIndex, OfferedTile> waiting;
  Time latest_look{};
  Clock::time_point last_offer = Clock::now();
  bool busy = false;  ///< the thread holds tiles that are not on the disk yet
  std::uint64_t tries = 0;
  Status last_try, last_snapshot;

  std::future<Status> compaction;
  std::jthread thread;

  void run(const std::stop_token& stop) {
    while (true) {
      std::map<TileIndex, OfferedTile> taken;
      Time look{};
      {
        std::unique_lock lock(mutex);
        const auto wake = [&] { return !waiting.empty(); };
        // With changes left over from a failed try: again, after a while.
        if (busy) {
          changed.wait_for(lock, stop, options.retry_after, [] { return false; });
        } else {
          changed.wait(lock, stop, wake);
        }
        if (waiting.empty() && stop.stop_requested() && (!busy || tries_after_stop++ > 0)) break;
        taken = std::exchange(waiting, {});
        look = latest_look;
        busy = true;
      }
      for (const auto& [index, offered] : taken)
        journal.change(index, offered.version, offered.tile, source);
      Status status = journal.commit(look);
      if (status) compact();
      {
        const std::lock_guard lock(mutex);
        busy = !status.ok();
        last_try = std::move(status);
        ++tries;
      }
      changed.notify_all();
    }
    end_compaction();
  }

  void end_compaction() {
    if (!compaction.valid()) return;
    Status written = compaction.get();
    const Status ended = journal.end_compaction();
    const std::lock_guard lock(mutex);
    last_snapshot = written ? ended : std::move(written);
  }

  /// A snapshot takes seconds, so it has a thread of its own. When it fails the journals stay, and
  /// it is tried again when they have grown.
  void compact() {
    if (compaction.valid() &&
        compaction.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      return;
    end_compaction();
    if (!journal.compaction_due()) return;
    if (auto work = journal.begin_compaction())
      compaction = std::async(std::launch::async, *std::move(work));
  }

  int tries_after_stop = 0;
};

JournalWriter::JournalWriter(std::unique_ptr<Body> body) : body_(std::move(body)) {}

Result<std::unique_ptr<JournalWriter>> JournalWriter::start(Storage& storage,
                                                            const std::filesystem::path& folder,
                                                            const MapHeader& header,
                                                            const std::string& source_id,
                                                            const JournalWriterOptions& options) {
  WATERSKY_TRY(MapJournal journal, MapJournal::open(storage, folder, header, options.journal));
  auto body = std::make_unique<Body>(std::move(journal));
  body->header = body->journal.header();
  body->restored = body->journal.tiles();
  body->options = options;
  const auto source = body->header.find_source(source_id);
  if (!source)
    return Error{ErrorCode::InvalidInput,
                 folder.string() + ": the map there knows no source " + source_id};
  body->source = *source;
  Body& b = *body;
  body->thread = std::jthread([&b](const std::stop_token& stop) { b.run(stop); });
  return std::unique_ptr<JournalWriter>(new JournalWriter(std::move(body)));
}

JournalWriter::~JournalWriter() {
  body_->thread.request_stop();
  body_->thread.join();
}

const TileSet& JournalWriter::restored() const { return body_->restored; }
const MapHeader& JournalWriter::header() const { return body_->header; }

bool JournalWriter::due() const {
  const std::lock_guard lock(body_->mutex);
  return Clock::now() - body_->last_offer >= body_->options.commit_every;
}

void JournalWriter::offer(std::vector<OfferedTile> tiles, Time latest_look) {
  {
    const std::lock_guard lock(body_->mutex);
    for (OfferedTile& tile : tiles) {
      const TileIndex index = tile.index;
      body_->waiting.insert_or_assign(index, std::move(tile));
    }
    body_->latest_look = std::max(body_->latest_look, latest_look);
    body_->last_offer = Clock::now();
  }
  body_->changed.notify_all();
}

Status JournalWriter::flush() {
  std::unique_lock lock(body_->mutex);
  const std::uint64_t before = body_->tries;
  body_->changed.wait(lock, [&] {
    const bool all = body_->waiting.empty() && !body_->busy;
    return all || (body_->tries > before && !body_->last_try.ok());
  });
  return body_->last_try;
}

std::optional<std::string> JournalWriter::trouble() const {
  const std::lock_guard lock(body_->mutex);
  if (body_->last_try.ok() && !body_->last_snapshot.ok())
    return "The map is safe, but its journals grow: " + body_->last_snapshot.error().message + ".";
  if (body_->last_try.ok()) return std::nullopt;
  return "The map is kept in memory only for now: " + body_->last_try.error().message + ".";
}

}  // namespace watersky
