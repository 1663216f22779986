// SPDX-License-Identifier: MIT
#pragma once
/// Reads MCAP: by its summary where there is a good one, else by going through it once, as what a
/// crash left has none. CRCs are checked. What is damaged is left out and told; the rest is read.
///
///   WATERSKY_TRY(const auto reader, mcap::Reader::open(source));
///   WATERSKY_TRY(const auto damage, reader.for_each([&](const mcap::Message& m, mcap::Location) {
///     use(reader.channels().at(m.channel).topic, m.data);
///   }));
#include <functional>
#include <memory>
#include <optional>
#include <set>

#include "watersky/wire/byte_source.hpp"
#include "watersky/wire/mcap.hpp"

namespace watersky::mcap {

struct ReaderOptions {
  /// Chunks and records that claim more are damage. What is allocated grows with what is there.
  std::uint64_t max_record_bytes = std::uint64_t{1} << 30;
  bool use_summary = true;  ///< false: go through the file even if it has one
};

/// Which messages are wanted.
struct Selection {
  std::optional<std::set<std::uint16_t>> channels{};
  std::optional<Time> first{}, last{};  ///< of log times, both included
};

class Reader {
 public:
  /// InvalidInput, naming the byte, when it is no MCAP or nothing of it can be read.
  [[nodiscard]] static Result<Reader> open(std::shared_ptr<const ByteSource> source,
                                           const ReaderOptions& options = {});

  [[nodiscard]] const Header& header() const { return header_; }
  /// Whether the summary was used.
  [[nodiscard]] bool indexed() const { return indexed_; }
  [[nodiscard]] const std::map<std::uint16_t, Schema>& schemas() const { return schemas_; }
  [[nodiscard]] const std::map<std::uint16_t, Channel>& channels() const { return channels_; }
  /// As the summary has them or, without one, counted. nullopt when the summary has none.
  [[nodiscard]] const std::optional<Statistics>& statistics() const { return statistics_; }
  /// In the order of the file; empty when messages stand in no chunk.
  [[nodiscard]] const std::vector<ChunkIndex>& chunks() const { return chunks_; }
  [[nodiscard]] const std::vector<AttachmentIndex>& attachments() const { return attachments_; }
  [[nodiscard]] const std::vector<MetadataIndex>& metadata() const { return metadata_; }
  /// What was met while opening: a bad summary; without one, all that is damaged.
  [[nodiscard]] const std::vector<Damage>& damage() const { return damage_; }

  /// Calls `use` for the messages in the order of the file, which is that of their log times only
  /// as far as their writer kept it. Returns what could not be read. Io as the source says.
  [[nodiscard]] Result<std::vector<Damage>> for_each(
      const std::function<void(const Message&, const Location&)>& use,
      const Selection& selection = {}) const;

  /// A message's data alone. May be called from several threads; a few chunks are kept unpacked
  /// for those that ask next.
  [[nodiscard]] Result<std::vector<std::uint8_t>> read(const Location& location) const;

  [[nodiscard]] Result<Attachment> read(const AttachmentIndex& index) const;
  [[nodiscard]] Result<Metadata> read(const MetadataIndex& index) const;

 private:
  struct Cache;
  struct Scan;
  using Use = std::function<void(const Message&, const Location&)>;

  Reader(std::shared_ptr<const ByteSource> source, const ReaderOptions& options);
  /// false: there is none, or damage_ says what is wrong with it.
  [[nodiscard]] Result<bool> read_summary();
  [[nodiscard]] Status scan();
  /// Goes over the records of the data section.
  [[nodiscard]] Status walk(Scan& scan) const;
  /// The content of the record at `offset`, which must be of this kind.
  [[nodiscard]] Result<std::vector<std::uint8_t>> content(std::uint64_t offset, std::uint8_t op,
                                                          std::uint64_t bytes) const;
  [[nodiscard]] Result<std::vector<std::uint8_t>> unpacked_chunk(std::uint64_t offset,
                                                                 std::uint64_t bytes) const;
  void add_schema(Schema schema, std::uint64_t offset);
  void add_channel(Channel channel, std::uint64_t offset);

  std::shared_ptr<const ByteSource> source_;
  ReaderOptions options_;
  Header header_;
  bool indexed_ = false;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::optional<Statistics> statistics_;
  std::vector<ChunkIndex> chunks_;
  std::vector<AttachmentIndex> attachments_;
  std::vector<MetadataIndex> metadata_;
  std::vector<Damage> damage_;
  std::shared_ptr<Cache> cache_;
};

}  // namespace watersky::mcap
