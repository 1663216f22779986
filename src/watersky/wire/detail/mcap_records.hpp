// SPDX-License-Identifier: MIT
#pragma once
/// MCAP's records, content only: bytes to structs and back. What stands behind the fields that we
/// know is skipped, as the format wants it.
#include <array>

#include "watersky/wire/detail/cursor.hpp"
#include "watersky/wire/mcap.hpp"

namespace watersky::mcap::detail {

using watersky::detail::Cursor;

inline constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
inline constexpr std::size_t kHeadBytes = 9;  ///< opcode and length
inline constexpr std::size_t kFooterBytes = 20;
/// Footer and magic, at the end of a whole file.
inline constexpr std::size_t kTailBytes = kHeadBytes + kFooterBytes + kMagic.size();

enum class Op : std::uint8_t {
  Header = 1,
  Footer = 2,
  Schema = 3,
  Channel = 4,
  Message = 5,
  Chunk = 6,
  MessageIndex = 7,
  ChunkIndex = 8,
  Attachment = 9,
  AttachmentIndex = 10,
  Statistics = 11,
  Metadata = 12,
  MetadataIndex = 13,
  SummaryOffset = 14,
  DataEnd = 15
};

/// "Chunk", "record 0x80".
[[nodiscard]] std::string name_of(std::uint8_t op);

struct Footer {
  std::uint64_t summary_start = 0;
  std::uint64_t summary_offset_start = 0;
  std::uint32_t summary_crc = 0;
};

/// A chunk's fields; `records` points into what was parsed.
struct Chunk {
  Time first, last;
  std::uint64_t uncompressed_bytes = 0;
  std::uint32_t crc = 0;
  std::string compression;
  std::span<const std::uint8_t> records;
};

[[nodiscard]] Time time_of(std::uint64_t ns);
[[nodiscard]] std::uint64_t ns_of(Time time);

// `offset`: of the content in the file, for errors. InvalidInput names the byte.
[[nodiscard]] Result<Header> parse_header(std::span<const std::uint8_t> c, std::uint64_t offset);
[[nodiscard]] Result<Footer> parse_footer(std::span<const std::uint8_t> c, std::uint64_t offset);
[[nodiscard]] Result<Schema> parse_schema(std::span<const std::uint8_t> c, std::uint64_t offset);
[[nodiscard]] Result<Channel> parse_channel(std::span<const std::uint8_t> c, std::uint64_t offset);
[[nodiscard]] Result<Message> parse_message(std::span<const std::uint8_t> c, std::uint64_t offset);
[[nodiscard]] Result<Chunk> parse_chunk(std::span<const std::uint8_t> c, std::uint64_t offset);
[[nodiscard]] Result<ChunkIndex> parse_chunk_index(std::span<const std::uint8_t> c,
                                                   std::uint64_t offset);
/// Checks the CRC.
[[nodiscard]] Result<Attachment> parse_attachment(std::span<const std::uint8_t> c,
                                                  std::uint64_t offset);
[[nodiscard]] Result<AttachmentIndex> parse_attachment_index(std::span<const std::uint8_t> c,
                                                             std::uint64_t offset);
[[nodiscard]] Result<Metadata> parse_metadata(std::span<const std::uint8_t> c,
                                              std::uint64_t offset);
[[nodiscard]] Result<MetadataIndex> parse_metadata_index(std::span<const std::uint8_t> c,
                                                         std::uint64_t offset);
[[nodiscard]] Result<Statistics> parse_statistics(std::span<const std::uint8_t> c,
                                                  std::uint64_t offset);

/// Appends head and content; `fill` appends the content.
template <class Fill>
void put_record(Bytes& out, Op op, Fill&& fill) {
  put(out, static_cast<std::uint8_t>(op));
  const std::size_t at = out.size();
  put(out, std::uint64_t{0});
  fill(out);
  const std::uint64_t size = out.size() - at - 8;
  std::memcpy(out.data() + at, &size, sizeof size);
}

void put_header(Bytes& out, const Header& header);
void put_schema(Bytes& out, const Schema& schema);
void put_channel(Bytes& out, const Channel& channel);
void put_message(Bytes& out, const Message& message);
void put_chunk_index(Bytes& out, const ChunkIndex& index);
void put_attachment(Bytes& out, const Attachment& attachment);
void put_attachment_index(Bytes& out, const AttachmentIndex& index);
void put_metadata(Bytes& out, const Metadata& metadata);
void put_metadata_index(Bytes& out, const MetadataIndex& index);
void put_statistics(Bytes& out, const Statistics& statistics);

}  // namespace watersky::mcap::detail
