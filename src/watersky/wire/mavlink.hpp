// SPDX-License-Identifier: MIT
#pragma once
/// MAVLink 1 and 2: bytes to messages and back, driven by one table (mavlink_messages.cpp).
///
///   const auto step = mavlink::parse_frame(bytes);
///   if (step.outcome == mavlink::ParseOutcome::Frame && step.frame.info) {
///     const mavlink::Message m(step.frame);
///     use(m.number("roll"));
///   }
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky::mavlink {

enum class FieldType : std::uint8_t { U8, I8, U16, I16, U32, I32, U64, I64, F32, F64, Char };

[[nodiscard]] std::size_t size_bytes(FieldType type);

struct FieldInfo {
  std::string_view name;
  FieldType type = FieldType::U8;
  std::uint8_t count = 0;   ///< elements of an array; 0: a plain value
  std::uint8_t offset = 0;  ///< in the payload
  std::string_view unit;    ///< as MAVLink writes it: "degE7", "mm", "cdeg"; empty: none
  bool extension = false;   ///< only in MAVLink 2
};

struct MessageInfo {
  std::uint32_t id = 0;
  std::string_view name;
  std::uint8_t crc_extra = 0;
  std::uint8_t min_length = 0;  ///< payload without extensions: what MAVLink 1 sends
  std::uint8_t max_length = 0;  ///< payload with the extensions that we know
  std::vector<FieldInfo> fields;

  /// nullptr when the message has no such field.
  [[nodiscard]] const FieldInfo* field(std::string_view field_name) const;
};

/// Every message that we know, by rising id.
[[nodiscard]] std::span<const MessageInfo> messages();
/// nullptr when we do not know it.
[[nodiscard]] const MessageInfo* find_message(std::uint32_t id);
[[nodiscard]] const MessageInfo* find_message(std::string_view name);

/// CRC-16/MCRF4XX over `bytes`, continued from `crc`.
[[nodiscard]] std::uint16_t crc(std::span<const std::uint8_t> bytes, std::uint16_t crc = 0xFFFF);
/// CRC_EXTRA as MAVLink computes it from a message's name and its fields without extensions.
[[nodiscard]] std::uint8_t compute_crc_extra(const MessageInfo& info);

/// A frame found in bytes; the spans point into them.
struct Frame {
  int version = 2;  ///< 1 or 2
  std::uint8_t sequence = 0;
  std::uint8_t system = 0;
  std::uint8_t component = 0;
  std::uint32_t message_id = 0;
  const MessageInfo* info = nullptr;  ///< nullptr: unknown id, and so the CRC was not checked
  bool is_signed = false;
  std::span<const std::uint8_t> payload;
  std::span<const std::uint8_t>
      bytes;  ///< the whole frame, signature included: what a router forwards
};

enum class ParseOutcome {
  Frame,     ///< `frame` is valid
  NeedMore,  ///< what is there may be the beginning of a frame
  NotAFrame  ///< wrong magic, flags, length or CRC: go on one byte further
};

struct ParseStep {
  ParseOutcome outcome = ParseOutcome::NotAFrame;
  Frame frame;
};

/// Looks for a frame at the first byte of `bytes`.
[[nodiscard]] ParseStep parse_frame(std::span<const std::uint8_t> bytes);

/// A message of a known kind, its fields by name. Asking for a field or an element that the
/// message does not have is a contract violation.
class Message {
 public:
  /// All fields zero.
  explicit Message(const MessageInfo& info) : info_(&info) {}
  /// From a frame whose `info` is set. What MAVLink 2 cut off is zero, what we do not know is
  /// ignored.
  explicit Message(const Frame& frame);

  [[nodiscard]] const MessageInfo& info() const { return *info_; }
  [[nodiscard]] std::uint8_t system() const { return system_; }
  [[nodiscard]] std::uint8_t component() const { return component_; }
  [[nodiscard]] std::span<const std::uint8_t> payload() const {
    return {payload_.data(), info_->max_length};
  }

  /// A field as a number, in the unit of the table. A 64 bit value beyond 2^53 is rounded.
  [[nodiscard]] double number(std::string_view field, std::size_t index = 0) const {
    return number(checked(field, index), index);
  }
  /// The same of a field of info() that was looked up before.
  [[nodiscard]] double number(const FieldInfo& field, std::size_t index = 0) const;
  /// A whole-number field exactly; a u64 beyond 2^63 wraps.
  [[nodiscard]] std::int64_t integer(std::string_view field, std::size_t index = 0) const;
  /// A char array up to its first zero.
  [[nodiscard]] std::string text(std::string_view field) const;

  /// Whole-number fields take the nearest whole number; beyond their range the nearest end, NaN
  /// zero.
  Message& set(std::string_view field, double value, std::size_t index = 0);
  Message& set_integer(std::string_view field, std::int64_t value, std::size_t index = 0);
  Message& set_text(std::string_view field, std::string_view value);

 private:
  [[nodiscard]] const FieldInfo& checked(std::string_view field, std::size_t index) const;

  const MessageInfo* info_;
  std::uint8_t system_ = 0;
  std::uint8_t component_ = 0;
  std::array<std::uint8_t, 255> payload_{};
};

/// Who sends.
struct Sender {
  std::uint8_t system = 1;
  std::uint8_t component = 1;
  std::uint8_t sequence = 0;
};

/// A message as an unsigned frame of MAVLink 2 (trailing zeros cut, extensions included) or 1.
/// Unsupported for a message whose id MAVLink 1 cannot carry.
[[nodiscard]] Result<std::vector<std::uint8_t>> encode(const Message& message, const Sender& sender,
                                                       int version = 2);

}  // namespace watersky::mavlink
