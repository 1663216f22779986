// SPDX-License-Identifier: MIT
#pragma once
/// The frame that map files and journals share: a preamble, then records that each carry their
/// checksum. docs/map_file.md has the layout.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "watersky/base/bytes.hpp"
#include "watersky/store/storage.hpp"

namespace watersky::detail {

inline constexpr std::uint16_t kFormatVersion = 1;
inline constexpr std::size_t kPreambleBytes = 24;
inline constexpr std::size_t kRecordHeadBytes = 24;
/// Larger payloads are damage; an index of 10^7 tiles stays below.
inline constexpr std::uint32_t kMostPayloadBytes = std::uint32_t{1} << 30;

enum class FileKind : std::uint16_t { Map = 1, Journal = 2 };
enum class RecordKind : std::uint8_t {
  Header = 1,
  Tile = 2,
  Overview = 3,
  Commit = 4,
  Index = 5,
  Patch = 6
};

struct Preamble {
  FileKind kind = FileKind::Map;
  /// Drawn for each file and repeated in its records: what an older file left on the same part of
  /// the disk is not taken for one of them.
  std::uint32_t salt = 0;
};

struct Record {
  RecordKind kind = RecordKind::Header;
  std::uint64_t offset = 0;  ///< of its head in the file
  std::uint32_t salt = 0;
  Bytes payload;
  [[nodiscard]] std::uint64_t end() const;
};

[[nodiscard]] std::uint64_t checksum(std::span<const std::uint8_t> bytes);

/// The size of a record with its head and padding.
[[nodiscard]] constexpr std::uint64_t record_bytes(std::uint64_t payload_bytes) {
  return kRecordHeadBytes + (payload_bytes + 7) / 8 * 8;
}

[[nodiscard]] std::uint32_t new_salt();
[[nodiscard]] Bytes encode_preamble(const Preamble& preamble);
/// InvalidInput (no such file, cut, damaged) or Unsupported (a newer version), with the remedy.
[[nodiscard]] Result<Preamble> read_preamble(const StorageFile& file, FileKind expected);

void append_record(Bytes& out, RecordKind kind, std::uint32_t salt,
                   std::span<const std::uint8_t> payload);

/// InvalidInput, naming file and byte, when there is no whole record of this file at `offset`.
[[nodiscard]] Result<Record> read_record(const StorageFile& file, std::uint64_t offset,
                                         std::uint32_t salt);

/// The next whole record at `from` or behind it; nullopt when there is none. Without a salt, of
/// whatever file. Gives up where false starts cost more than reading the file eight times.
[[nodiscard]] std::optional<Record> find_record(const StorageFile& file, std::uint64_t from,
                                                std::optional<std::uint32_t> salt);

}  // namespace watersky::detail
