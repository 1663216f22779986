// SPDX-License-Identifier: MIT
#pragma once
/// A journal off the mapping thread: offer() copies changed tiles and returns; a thread of its own
/// commits them, compacts, and tries again when the disk was full. The map in memory is never held
/// up by it.
///
///   WATERSKY_TRY(auto writer, JournalWriter::start(disk(), folder, header));   // or warn, and fly
///   …each frame: map.update(…);
///   if (writer->due()) writer->offer(changed tiles, time of the frame);
///   if (const auto trouble = writer->trouble()) warn(*trouble);
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "watersky/store/map_journal.hpp"

namespace watersky {

struct JournalWriterOptions {
  JournalOptions journal{};
  /// Between two offers: what a power cut may take is this and one commit. A quarter of a second
  /// leaves the rest of the one promised to the disk.
  std::chrono::milliseconds commit_every{250};
  std::chrono::milliseconds retry_after{1000};
};

struct OfferedTile {
  TileIndex index;
  std::uint64_t version = 0;
  MapTile tile;
};

class JournalWriter {
 public:
  /// As MapJournal::open: its errors are those of the start, when they can still be mended.
  [[nodiscard]] static Result<std::unique_ptr<JournalWriter>> start(
      Storage& storage, const std::filesystem::path& folder, const MapHeader& header,
      const std::string& source_id, const JournalWriterOptions& options = {});
  /// Commits what was offered, if the disk lets it.
  ~JournalWriter();
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;

  /// What the folder held at the start.
  [[nodiscard]] const TileSet& restored() const;
  [[nodiscard]] const MapHeader& header() const;

  /// Whether it is time for the next offer.
  [[nodiscard]] bool due() const;
  /// Takes the tiles that changed since the last offer. A tile offered again replaces what waits.
  void offer(std::vector<OfferedTile> tiles, Time latest_look);
  /// Waits until all that was offered is on the disk; the error of the last try when it is not.
  Status flush();
  /// Why what was offered is not on the disk, or why the journals cannot be summed up in a
  /// snapshot, as one sentence; nullopt when all is well, and again when it has recovered.
  [[nodiscard]] std::optional<std::string> trouble() const;

 private:
  struct Body;
  explicit JournalWriter(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

}  // namespace watersky
