// SPDX-License-Identifier: MIT
#pragma once
/// Which messages IMC (LSTS's Inter-Module Communication) has: ours, or a log's own IMC.xml.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky::imc {

/// The last four take as many bytes as they hold; their length is on the wire.
enum class FieldType : std::uint8_t {
  U8,
  I8,
  U16,
  I16,
  U32,
  I32,
  I64,
  F32,
  F64,
  Raw,      ///< u16 length, bytes
  Text,     ///< likewise
  Message,  ///< u16 id, that message's fields; id 65535: none
  List      ///< u16 count, so many of Message
};

/// Bytes on the wire; 0 for those that vary.
[[nodiscard]] std::size_t size_bytes(FieldType type);

struct FieldInfo {
  std::string name;
  FieldType type = FieldType::U8;
  std::string unit;          ///< as IMC.xml writes it: "rad", "m/s"; empty: none
  std::string message_type;  ///< of Message and List: the message or group meant; empty: any
  std::size_t offset = 0;    ///< in the payload, when `has_offset`
  bool has_offset = false;   ///< no field before it varies
  std::vector<std::uint16_t> accepts;  ///< `message_type` as rising ids; empty: any
};

struct MessageInfo {
  std::uint16_t id = 0;
  std::string name;
  std::vector<FieldInfo> fields;
  std::size_t fixed_bytes = 0;  ///< of the fields that do not vary
  bool varies = false;          ///< has a field that varies

  /// The field's place in `fields`; fields.size() when the message has no such field.
  [[nodiscard]] std::size_t index(std::string_view field_name) const;
};

/// A message group: `name` may stand where one of `members` is meant.
struct MessageGroup {
  std::string name;
  std::vector<std::string> members;
};

/// A set of messages. What is read through it points into it: it must live as long.
class Schema {
 public:
  /// No message has more fields, so that a decoder needs no memory of its own.
  static constexpr std::size_t kMaxFields = 64;

  /// The messages of IMC 5.4.31 that a vehicle, a console and their plans speak (imc_messages.cpp).
  [[nodiscard]] static const Schema& builtin();
  /// From the text of an IMC.xml, as DUNE leaves it beside its logs. InvalidInput with the line
  /// when it is no XML or contradicts itself.
  [[nodiscard]] static Result<Schema> from_xml(std::string_view text);
  /// InvalidInput when an id or name comes twice, a message has more than kMaxFields fields, or a
  /// field or group names what there is not.
  [[nodiscard]] static Result<Schema> make(std::vector<MessageInfo> messages,
                                           const std::vector<MessageGroup>& groups);

  Schema(Schema&&) = default;
  Schema& operator=(Schema&&) = default;

  /// By rising id.
  [[nodiscard]] std::span<const MessageInfo> messages() const { return messages_; }
  /// nullptr when there is none.
  [[nodiscard]] const MessageInfo* find(std::uint16_t id) const {
    const std::uint16_t at = id < by_id_.size() ? by_id_[id] : 0;
    return at == 0 ? nullptr : &messages_[at - 1];
  }
  [[nodiscard]] const MessageInfo* find(std::string_view name) const;

 private:
  Schema() = default;
  std::vector<MessageInfo> messages_;
  std::vector<std::uint16_t> by_id_;  ///< 1 + place in messages_; 0: none
};

}  // namespace watersky::imc
