// SPDX-License-Identifier: MIT
#pragma once
/// Writes MCAP: messages in chunks with their indexes, statistics, CRCs.
///
///   WATERSKY_TRY(auto writer, mcap::Writer::open(sink));
///   const auto channel = writer.add_channel({.topic = "/fix", …});
///   WATERSKY_CHECK(writer.write({.channel = channel, .log_time = now, .data = bytes}));
///   WATERSKY_CHECK(writer.close());
///
/// Crash-safe: what a chunk holds is in the sink when it is full, or after flush(), and is read
/// back (mcap_reader.hpp) whatever becomes of the process. Only close() makes the file complete.
#include <optional>

#include "watersky/wire/byte_source.hpp"
#include "watersky/wire/compression.hpp"
#include "watersky/wire/mcap.hpp"

namespace watersky::mcap {

struct WriterOptions {
  std::string profile;
  std::string library = "watersky";
  Compression compression = Compression::Zstd;  ///< None, Lz4 or Zstd
  /// A chunk is written when its messages are this large: what a crash may take.
  std::size_t chunk_bytes = std::size_t{1} << 20;
};

class Writer {
 public:
  /// Sends the beginning of the file. Usage for a compression that MCAP has not.
  [[nodiscard]] static Result<Writer> open(ByteSink sink, WriterOptions options = {});

  /// Both give the id; the one set in the argument does not count. The first 65535 of each have
  /// one: more are OutOfRange. NotFound for a channel of a schema that was not added (0: none).
  [[nodiscard]] Result<std::uint16_t> add_schema(Schema schema);
  [[nodiscard]] Result<std::uint16_t> add_channel(Channel channel);

  /// NotFound for a channel that was not added. Messages larger than a chunk get one of their own.
  [[nodiscard]] Status write(const Message& message);
  /// At once: an attachment and a metadata record are no part of a chunk.
  [[nodiscard]] Status attach(const Attachment& attachment);
  [[nodiscard]] Status add_metadata(const Metadata& metadata);

  /// Sends the chunk begun, full or not.
  [[nodiscard]] Status flush();
  /// Sends what is left and the summary. Nothing can be written after it.
  [[nodiscard]] Status close();

  [[nodiscard]] std::uint64_t bytes_sent() const { return sent_; }

 private:
  Writer(ByteSink sink, WriterOptions options)
      : sink_(std::move(sink)), options_(std::move(options)) {}
  [[nodiscard]] Status send(std::span<const std::uint8_t> bytes);
  [[nodiscard]] Status check_open() const;

  /// Where a message of the chunk begun lies in it.
  struct Entry {
    Time time;
    std::uint64_t offset;
  };

  ByteSink sink_;
  WriterOptions options_;
  std::optional<Error> failed_;
  bool closed_ = false;
  std::uint64_t sent_ = 0;
  std::uint32_t crc_ = 0;  ///< of all that was sent
  std::vector<std::uint8_t> chunk_;
  std::map<std::uint16_t, std::vector<Entry>> entries_;
  std::vector<Schema> schemas_;    ///< by id, from 1
  std::vector<Channel> channels_;  ///< by id, from 1
  std::vector<ChunkIndex> chunks_;
  std::vector<AttachmentIndex> attachments_;
  std::vector<MetadataIndex> metadata_;
  Statistics statistics_;
};

}  // namespace watersky::mcap
