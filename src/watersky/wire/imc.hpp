// SPDX-License-Identifier: MIT
#pragma once
/// IMC packets: bytes to messages and back, in both byte orders, driven by a Schema.
///
///   const auto step = imc::parse_packet(bytes, imc::Schema::builtin());
///   if (step.outcome == imc::ParseOutcome::Packet && step.packet.info) {
///     const auto state = imc::View::make(step.packet, imc::Schema::builtin());
///     if (state) use(state->number("phi"));
///   }
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/wire/imc_schema.hpp"

namespace watersky::imc {

/// The first two bytes as a number in the sender's order: IMC 5.4.
inline constexpr std::uint16_t kSync = 0xFE54;
/// The id of no message, the address of all systems.
inline constexpr std::uint16_t kNoMessage = 0xFFFF;
inline constexpr std::size_t kHeaderBytes = 20;
inline constexpr std::size_t kFooterBytes = 2;
inline constexpr std::size_t kMaxPacketBytes = 65535;
/// Inline messages in inline messages in …: deeper ones are refused. A stock plan needs five.
inline constexpr int kMaxDepth = 16;

/// CRC-16/ARC over `bytes`, continued from `crc`.
[[nodiscard]] std::uint16_t crc(std::span<const std::uint8_t> bytes, std::uint16_t crc = 0);

/// Who says it, when, to whom.
struct Header {
  double timestamp_s = 0.0;  ///< UTC since 1970
  std::uint16_t source = 0xFFFF;
  std::uint8_t source_entity = 0xFF;
  std::uint16_t destination = 0xFFFF;
  std::uint8_t destination_entity = 0xFF;
};

/// A packet found in bytes, its CRC checked; the spans point into them.
struct Packet {
  std::endian order = std::endian::little;  ///< the sender's
  std::uint16_t message_id = 0;
  const MessageInfo* info = nullptr;  ///< nullptr: an id that the schema does not know
  Header header;
  std::span<const std::uint8_t> payload;
  std::span<const std::uint8_t> bytes;  ///< all of it: what a router passes on
};

enum class ParseOutcome {
  Packet,     ///< `packet` is valid
  NeedMore,   ///< what is there may be the beginning of a packet
  NotAPacket  ///< wrong sync number, size or CRC: go on one byte further
};

struct ParseStep {
  ParseOutcome outcome = ParseOutcome::NotAPacket;
  Packet packet;
};

/// Looks for a packet at the first byte of `bytes`.
[[nodiscard]] ParseStep parse_packet(std::span<const std::uint8_t> bytes, const Schema& schema);

/// The fields of a packet where they lie, nothing copied or allocated. Asking for a field that
/// the message does not have, or for another kind than it is, is a contract violation.
class View {
 public:
  /// Walks over the payload once. InvalidInput, naming the field and the byte in the packet, when
  /// it ends early or late, an inline message is of a type that is unknown or not meant there, or
  /// inline messages are too deep; Unsupported for a packet without `info`.
  [[nodiscard]] static Result<View> make(const Packet& packet, const Schema& schema);

  [[nodiscard]] const MessageInfo& info() const { return *info_; }
  [[nodiscard]] std::endian order() const { return order_; }

  /// A field as a number, in the schema's unit. A 64 bit value beyond 2^53 is rounded.
  [[nodiscard]] double number(std::size_t field) const;
  [[nodiscard]] double number(std::string_view field) const { return number(info_->index(field)); }
  /// A whole-number field exactly.
  [[nodiscard]] std::int64_t integer(std::size_t field) const;
  [[nodiscard]] std::int64_t integer(std::string_view field) const {
    return integer(info_->index(field));
  }
  /// Text, without terminator.
  [[nodiscard]] std::string_view text(std::string_view field) const;

 private:
  friend class Message;
  View() = default;
  [[nodiscard]] std::size_t offset(std::size_t field) const {
    const FieldInfo& f = info_->fields[field];
    return f.has_offset ? f.offset : offsets_[field];
  }

  const MessageInfo* info_ = nullptr;
  std::endian order_ = std::endian::little;
  std::span<const std::uint8_t> payload_;
  std::array<std::uint16_t, Schema::kMaxFields> offsets_;  ///< where a field's place varies
};

/// A message as a value, its fields by name. Asking for a field that the message does not have, or
/// for another kind than it is, is a contract violation. It points into its schema.
class Message {
 public:
  /// No message: what stands on the wire as the id 65535.
  Message() = default;
  /// All fields zero or empty.
  explicit Message(const MessageInfo& info);
  /// A packet's; errors are those of View::make.
  [[nodiscard]] static Result<Message> decode(const Packet& packet, const Schema& schema);

  [[nodiscard]] bool is_none() const { return info_ == nullptr; }
  /// Of a message that is one.
  [[nodiscard]] const MessageInfo& info() const;

  [[nodiscard]] double number(std::string_view field) const;
  [[nodiscard]] std::int64_t integer(std::string_view field) const;
  /// Text or raw bytes.
  [[nodiscard]] const std::string& bytes(std::string_view field) const;
  /// Of a Message field; is_none() when there is none.
  [[nodiscard]] const Message& message(std::string_view field) const;
  /// Of a List field.
  [[nodiscard]] const std::vector<Message>& list(std::string_view field) const;

  /// Whole-number fields take the nearest whole number; beyond their range the nearest end, NaN
  /// zero.
  Message& set(std::string_view field, double value);
  Message& set_integer(std::string_view field, std::int64_t value);
  Message& set_bytes(std::string_view field, std::string_view value);
  Message& set_message(std::string_view field, Message value);
  Message& add(std::string_view field, Message value);

  /// All fields alike, bit by bit.
  bool operator==(const Message& other) const;

 private:
  struct Value;
  friend class Encoder;
  struct Decoder;
  [[nodiscard]] Value& at(std::string_view field, FieldType kind);
  [[nodiscard]] const Value& at(std::string_view field, FieldType kind) const;

  const MessageInfo* info_ = nullptr;
  std::vector<Value> values_;
};

struct Message::Value {
  std::uint64_t bits = 0;  ///< of a number, as wide as its field: NaNs keep theirs
  std::string bytes;
  std::vector<Message> messages;  ///< one for a Message field
  bool operator==(const Value&) const = default;
};

/// A packet. OutOfRange when it, or a field of it, is longer than IMC can say; InvalidInput when an
/// inline message is not of the type meant or too deep, or there is no message.
[[nodiscard]] Result<std::vector<std::uint8_t>> encode(const Message& message, const Header& header,
                                                       std::endian order = std::endian::little);

}  // namespace watersky::imc
