// SPDX-License-Identifier: MIT
#pragma once
/// ArduPilot's own logs (.bin, "DataFlash"): records whose layout the log itself describes.
///
///   dataflash::Reader reader(bytes);
///   while (const auto record = reader.next())
///     if (record->format->name == "ATT") use(record->number("Roll"));
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky::dataflash {

struct Field {
  std::string name;
  char type = 'B';         ///< the letter of FMT: 'L' is degE7, 'c' an i16 of hundredths, …
  std::size_t offset = 0;  ///< behind the three bytes of the record's head
  /// By FMTU, UNIT and MULT: "deg", "m"; empty: none or not told. Only Reader::formats() has it.
  std::string unit;
  /// What number() is to be multiplied by to be in `unit`. 1 where the letter has done so already,
  /// although FMTU says it again.
  double multiplier = 1.0;
};

struct Format {
  std::uint8_t type = 0;   ///< differs from log to log
  std::string name;        ///< "ATT"
  std::size_t length = 0;  ///< bytes of a record, head included
  /// Empty when FMT contradicts itself: then records can be passed over but not read.
  std::vector<Field> fields;

  /// The field's place in `fields`; fields.size() when there is none.
  [[nodiscard]] std::size_t index(std::string_view field_name) const;
  [[nodiscard]] bool has(std::string_view field_name) const {
    return index(field_name) < fields.size();
  }
};

/// A record where it lies. Asking for a field that it does not have, or for another kind than it
/// is, is a contract violation.
struct Record {
  const Format* format = nullptr;  ///< of the reader; valid until it reads on
  std::size_t offset = 0;          ///< of the record in the log
  std::span<const std::uint8_t> payload;

  /// A field as a number, the scale of its letter applied: degrees for 'L', units for the
  /// hundredths of c, C, e, E. A 64 bit value beyond 2^53 is rounded.
  [[nodiscard]] double number(std::size_t field) const;
  [[nodiscard]] double number(std::string_view field) const { return number(format->index(field)); }
  /// A whole-number field as it lies in the log.
  [[nodiscard]] std::int64_t integer(std::string_view field) const;
  /// Text up to its first zero.
  [[nodiscard]] std::string_view text(std::string_view field) const;
};

/// Walks over a log. What no FMT describes, or is no record, is skipped byte by byte until a
/// record stands before another, or before the end: records have no checksum.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// The next record, FMT, FMTU, UNIT and MULT included; nullopt at the end.
  [[nodiscard]] std::optional<Record> next();

  /// What the log has described so far, with units, by rising type.
  [[nodiscard]] std::vector<Format> formats() const;
  /// Bytes that belonged to no record, up to where the reader is.
  [[nodiscard]] std::size_t skipped_bytes() const { return skipped_; }
  /// How often the reader had to look for the next record, and where first.
  [[nodiscard]] std::size_t gaps() const { return gaps_; }
  [[nodiscard]] std::size_t first_gap_at() const { return first_gap_at_; }
  /// After the end: bytes of a last record that the log cuts short.
  [[nodiscard]] std::size_t truncated_bytes() const { return truncated_; }

 private:
  enum class Check { Record, CutShort, No };
  [[nodiscard]] Check check(std::size_t at) const;
  [[nodiscard]] bool head_may_stand(std::size_t at) const;
  void learn(const Record& record);

  std::span<const std::uint8_t> bytes_;
  std::array<std::optional<Format>, 256> formats_;
  struct Units {
    std::string units, multipliers;
  };
  std::array<std::optional<Units>, 256> field_units_;
  std::array<std::string, 256> unit_labels_;
  std::array<std::optional<double>, 256> multipliers_;
  std::size_t at_ = 0;
  std::size_t skipped_ = 0;
  std::size_t gaps_ = 0;
  std::size_t first_gap_at_ = 0;
  std::size_t truncated_ = 0;
};

/// Why a reader found no format in `bytes`.
[[nodiscard]] Error no_format_error(std::span<const std::uint8_t> bytes);

}  // namespace watersky::dataflash
