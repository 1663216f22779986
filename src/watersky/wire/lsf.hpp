// SPDX-License-Identifier: MIT
#pragma once
/// DUNE's logs (Data.lsf, Data.lsf.gz): IMC packets one behind the other, nothing else.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "watersky/wire/imc.hpp"

namespace watersky::imc {

/// A packet and where it begins; the spans point into the log's bytes.
struct LsfRecord {
  std::size_t offset = 0;
  Packet packet;
};

/// Walks over an unpacked log (gzip.hpp unpacks). What is no packet, or is one with a wrong CRC,
/// is skipped byte by byte.
class LsfReader {
 public:
  /// The schema must outlive what is read.
  LsfReader(std::span<const std::uint8_t> bytes, const Schema& schema)
      : bytes_(bytes), schema_(&schema) {}

  /// The next record; nullopt at the end.
  [[nodiscard]] std::optional<LsfRecord> next();

  /// Bytes that belonged to no packet, up to where the reader is.
  [[nodiscard]] std::size_t skipped_bytes() const { return skipped_; }
  /// How often the reader had to look for the next packet, and where first.
  [[nodiscard]] std::size_t gaps() const { return gaps_; }
  [[nodiscard]] std::size_t first_gap_at() const { return first_gap_at_; }
  /// After the end: bytes of a last packet that the log cuts short.
  [[nodiscard]] std::size_t truncated_bytes() const { return truncated_; }

 private:
  void skip_to(std::size_t at);

  std::span<const std::uint8_t> bytes_;
  const Schema* schema_;
  std::size_t at_ = 0;
  std::size_t skipped_ = 0;
  std::size_t gaps_ = 0;
  std::size_t first_gap_at_ = 0;
  std::size_t truncated_ = 0;
};

}  // namespace watersky::imc
