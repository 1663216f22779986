// SPDX-License-Identifier: MIT
#include "watersky/wire/imc.hpp"

#include <algorithm>

#include "watersky/wire/detail/crc16.hpp"
#include "watersky/wire/detail/imc_bytes.hpp"
#include "watersky/wire/detail/nearest.hpp"

namespace watersky::imc {

using detail::load;
using detail::load_bits;

namespace {

constexpr std::uint16_t kReflectedPolynomial = 0xA001;

struct Fault {
  const MessageInfo* message = nullptr;
  const FieldInfo* field = nullptr;  ///< nullptr: behind the last
  std::size_t at = 0;                ///< in the payload
  std::string what;

  [[nodiscard]] Error error() const {
    return {ErrorCode::InvalidInput, message->name + (field ? "." + field->name : std::string()) +
                                         ", byte " + std::to_string(kHeaderBytes + at) +
                                         " of the packet: " + what};
  }
};

bool accepts(const FieldInfo& field, std::uint16_t id) {
  return field.accepts.empty() ||
         std::binary_search(field.accepts.begin(), field.accepts.end(), id);
}

std::string not_meant(const FieldInfo& field, const MessageInfo& message) {
  return "holds a " + message.name + " where " + field.message_type + " is meant";
}

/// Walks over a payload's fields.
struct Walker {
  const Schema& schema;
  std::endian order;
  std::span<const std::uint8_t> payload;
  Fault fault;

  [[nodiscard]] bool fail(const MessageInfo& message, const FieldInfo* field, std::size_t at,
                          std::string what) {
    fault = {&message, field, at, std::move(what)};
    return false;
  }

  /// A u16 at `at`, which moves on; fails when the payload ends first.
  [[nodiscard]] bool take_u16(std::size_t& at, std::uint16_t& value, const MessageInfo& message,
                              const FieldInfo& field) {
    if (payload.size() - at < 2) return fail(message, &field, at, "the message ends in it");
    value = load<std::uint16_t>(payload.data() + at, order);
    at += 2;
    return true;
  }

  /// An inline message at `at`; nullptr for none.
  [[nodiscard]] bool take_id(std::size_t& at, const MessageInfo*& inline_message,
                             const MessageInfo& message, const FieldInfo& field) {
    const std::size_t began = at;
    std::uint16_t id = 0;
    if (!take_u16(at, id, message, field)) return false;
    inline_message = nullptr;
    if (id == kNoMessage) return true;
    inline_message = schema.find(id);
    if (!inline_message)
      return fail(message, &field, began,
                  "holds a message of the unknown type " + std::to_string(id) +
                      ", whose end nobody knows; give the schema (IMC.xml) of who wrote it");
    if (!accepts(field, id)) return fail(message, &field, began, not_meant(field, *inline_message));
    return true;
  }

  /// Over the fields of `message`, which begin at `at`; `offsets` takes where each lies.
  [[nodiscard]] bool skip(const MessageInfo& message, std::size_t& at, int depth,
                          std::uint16_t* offsets) {
    if (depth > kMaxDepth)
      return fail(message, nullptr, at,
                  "inline messages are more than " + std::to_string(kMaxDepth) + " deep");
    if (!message.varies) {
      // One comparison for all, unless one of them is missing.
      if (payload.size() - at >= message.fixed_bytes) {
        at += message.fixed_bytes;
        return true;
      }
    }
    for (std::size_t i = 0; i < message.fields.size(); ++i) {
      const FieldInfo& field = message.fields[i];
      if (offsets) offsets[i] = static_cast<std::uint16_t>(at);
      std::uint16_t n = 0;
      const MessageInfo* inner = nullptr;
      switch (field.type) {
        case FieldType::Raw:
        case FieldType::Text:
          if (!take_u16(at, n, message, field)) return false;
          if (payload.size() - at < n)
            return fail(message, &field, at,
                        "is to have " + std::to_string(n) + " bytes, of which " +
                            std::to_string(payload.size() - at) + " are there");
          at += n;
          break;
        case FieldType::Message:
          if (!take_id(at, inner, message, field)) return false;
          if (inner && !skip(*inner, at, depth + 1, nullptr)) return false;
          break;
        case FieldType::List:
          if (!take_u16(at, n, message, field)) return false;
          for (; n > 0; --n) {
            if (!take_id(at, inner, message, field)) return false;
            if (inner && !skip(*inner, at, depth + 1, nullptr)) return false;
          }
          break;
        default: {
          const std::size_t size = size_bytes(field.type);
          if (payload.size() - at < size)
            return fail(message, &field, at, "the message ends in it");
          at += size;
        }
      }
    }
    return true;
  }
};

}  // namespace

std::uint16_t crc(std::span<const std::uint8_t> bytes, std::uint16_t crc) {
  return watersky::detail::crc16<kReflectedPolynomial>(bytes, crc);
}

ParseStep parse_packet(std::span<const std::uint8_t> bytes, const Schema& schema) {
  ParseStep step;
  if (bytes.size() < 2) {
    const bool may_begin = bytes.empty() || bytes[0] == (kSync & 0xFF) || bytes[0] == kSync >> 8;
    if (may_begin) step.outcome = ParseOutcome::NeedMore;
    return step;
  }
  Packet& packet = step.packet;
  const auto sync = load<std::uint16_t>(bytes.data(), std::endian::little);
  if (sync == detail::swapped(kSync))
    packet.order = std::endian::big;
  else if (sync != kSync)
    return step;
  step.outcome = ParseOutcome::NeedMore;
  if (bytes.size() < kHeaderBytes) return step;

  const std::uint8_t* p = bytes.data();
  const std::endian order = packet.order;
  const std::size_t payload = load<std::uint16_t>(p + 4, order);
  const std::size_t size = kHeaderBytes + payload + kFooterBytes;
  if (size > kMaxPacketBytes) return {};
  if (bytes.size() < size) return step;
  const std::size_t covered = size - kFooterBytes;
  if (crc(bytes.first(covered)) != load<std::uint16_t>(p + covered, order)) return {};

  packet.message_id = load<std::uint16_t>(p + 2, order);
  packet.info = schema.find(packet.message_id);
  packet.header.timestamp_s = std::bit_cast<double>(load<std::uint64_t>(p + 6, order));
  packet.header.source = load<std::uint16_t>(p + 14, order);
  packet.header.source_entity = p[16];
  packet.header.destination = load<std::uint16_t>(p + 17, order);
  packet.header.destination_entity = p[19];
  packet.payload = bytes.subspan(kHeaderBytes, payload);
  packet.bytes = bytes.first(size);
  step.outcome = ParseOutcome::Packet;
  return step;
}

Result<View> View::make(const Packet& packet, const Schema& schema) {
  if (!packet.info)
    return Error{ErrorCode::Unsupported, "a message of the unknown type " +
                                             std::to_string(packet.message_id) +
                                             "; give the schema (IMC.xml) of who wrote it"};
  Walker walker{schema, packet.order, packet.payload, {}};
  View view;
  view.info_ = packet.info;
  view.order_ = packet.order;
  view.payload_ = packet.payload;
  std::size_t end = 0;
  if (!walker.skip(*packet.info, end, 0, view.offsets_.data())) return walker.fault.error();
  if (end != packet.payload.size()) {
    (void)walker.fail(*packet.info, nullptr, end,
                      std::to_string(packet.payload.size() - end) +
                          " bytes follow its last field; is it of another schema?");
    return walker.fault.error();
  }
  return view;
}

double View::number(std::size_t field) const {
  WATERSKY_REQUIRE(field < info_->fields.size());
  const FieldType type = info_->fields[field].type;
  WATERSKY_REQUIRE(detail::is_number(type));
  const std::uint64_t bits = load_bits(payload_.data() + offset(field), size_bytes(type), order_);
  return detail::number_from<double>(bits, type);
}

std::int64_t View::integer(std::size_t field) const {
  WATERSKY_REQUIRE(field < info_->fields.size());
  const FieldType type = info_->fields[field].type;
  WATERSKY_REQUIRE(detail::is_whole(type));
  const std::uint64_t bits = load_bits(payload_.data() + offset(field), size_bytes(type), order_);
  return detail::number_from<std::int64_t>(bits, type);
}

std::string_view View::text(std::string_view field) const {
  const std::size_t i = info_->index(field);
  WATERSKY_REQUIRE(i < info_->fields.size());
  WATERSKY_REQUIRE(info_->fields[i].type == FieldType::Text ||
                   info_->fields[i].type == FieldType::Raw);
  const std::uint8_t* p = payload_.data() + offset(i);
  return {reinterpret_cast<const char*>(p + 2), load<std::uint16_t>(p, order_)};
}

// --- Messages as values --------------------------------------------------------------------

/// Over a payload that View::make has walked over: nothing is checked again.
struct Message::Decoder {
  const Schema& schema;
  std::endian order;
  const std::uint8_t* p;

  std::uint16_t u16() {
    const auto value = load<std::uint16_t>(p, order);
    p += 2;
    return value;
  }
  Message inline_message() {
    const std::uint16_t id = u16();
    return id == kNoMessage ? Message() : fields(*schema.find(id));
  }
  Message fields(const MessageInfo& info) {
    Message message(info);
    for (std::size_t i = 0; i < info.fields.size(); ++i) {
      const FieldType type = info.fields[i].type;
      Value& value = message.values_[i];
      if (detail::is_number(type)) {
        value.bits = load_bits(p, size_bytes(type), order);
        p += size_bytes(type);
      } else if (type == FieldType::Message) {
        value.messages.front() = inline_message();
      } else if (type == FieldType::List) {
        for (std::size_t n = u16(); n > 0; --n) value.messages.push_back(inline_message());
      } else {
        const std::size_t n = u16();
        value.bytes.assign(reinterpret_cast<const char*>(p), n);
        p += n;
      }
    }
    return message;
  }
};

Message::Message(const MessageInfo& info) : info_(&info), values_(info.fields.size()) {
  for (std::size_t i = 0; i < info.fields.size(); ++i)
    if (info.fields[i].type == FieldType::Message) values_[i].messages.resize(1);
}

Result<Message> Message::decode(const Packet& packet, const Schema& schema) {
  WATERSKY_TRY(const View view, View::make(packet, schema));
  return Decoder{schema, packet.order, packet.payload.data()}.fields(view.info());
}

const MessageInfo& Message::info() const {
  WATERSKY_REQUIRE(info_ != nullptr);
  return *info_;
}

const Message::Value& Message::at(std::string_view field, FieldType kind) const {
  const std::size_t i = info().index(field);
  WATERSKY_REQUIRE(i < values_.size());
  const FieldType type = info().fields[i].type;
  WATERSKY_REQUIRE(type == kind || (kind == FieldType::F64 && detail::is_number(type)) ||
                   (kind == FieldType::I64 && detail::is_whole(type)) ||
                   (kind == FieldType::Text && type == FieldType::Raw));
  (void)type;
  (void)kind;
  return values_[i];
}

Message::Value& Message::at(std::string_view field, FieldType kind) {
  return const_cast<Value&>(std::as_const(*this).at(field, kind));
}

double Message::number(std::string_view field) const {
  const std::uint64_t bits = at(field, FieldType::F64).bits;
  return detail::number_from<double>(bits, info_->fields[info_->index(field)].type);
}

std::int64_t Message::integer(std::string_view field) const {
  const std::uint64_t bits = at(field, FieldType::I64).bits;
  return detail::number_from<std::int64_t>(bits, info_->fields[info_->index(field)].type);
}

const std::string& Message::bytes(std::string_view field) const {
  return at(field, FieldType::Text).bytes;
}
const Message& Message::message(std::string_view field) const {
  return at(field, FieldType::Message).messages.front();
}
const std::vector<Message>& Message::list(std::string_view field) const {
  return at(field, FieldType::List).messages;
}

Message& Message::set(std::string_view field, double value) {
  at(field, FieldType::F64).bits = detail::with_type(
      info_->fields[info_->index(field)].type,
      [&](auto zero) { return detail::bits_of(watersky::detail::nearest<decltype(zero)>(value)); });
  return *this;
}

Message& Message::set_integer(std::string_view field, std::int64_t value) {
  at(field, FieldType::I64).bits = detail::with_type(
      info_->fields[info_->index(field)].type,
      [&](auto zero) { return detail::bits_of(static_cast<decltype(zero)>(value)); });
  return *this;
}

Message& Message::set_bytes(std::string_view field, std::string_view value) {
  at(field, FieldType::Text).bytes = value;
  return *this;
}
Message& Message::set_message(std::string_view field, Message value) {
  at(field, FieldType::Message).messages.front() = std::move(value);
  return *this;
}
Message& Message::add(std::string_view field, Message value) {
  at(field, FieldType::List).messages.push_back(std::move(value));
  return *this;
}

bool Message::operator==(const Message& other) const {
  return info_ == other.info_ && values_ == other.values_;
}

// --- Encoding ------------------------------------------------------------------------------

class Encoder {
 public:
  explicit Encoder(std::endian order) : order_(order) {}

  template <class Whole>
  void put(Whole value) {
    if (order_ == std::endian::big) value = detail::swapped(value);
    const auto* p = reinterpret_cast<const std::uint8_t*>(&value);
    out_.insert(out_.end(), p, p + sizeof value);
  }

  [[nodiscard]] Status fields(const Message& message, int depth) {
    const MessageInfo& info = message.info();
    if (depth > kMaxDepth)
      return Error{ErrorCode::InvalidInput, info.name + ": inline messages are more than " +
                                                std::to_string(kMaxDepth) + " deep"};
    for (std::size_t i = 0; i < info.fields.size(); ++i) {
      const FieldInfo& field = info.fields[i];
      const Message::Value& value = message.values_[i];
      const std::size_t n =
          field.type == FieldType::List ? value.messages.size() : value.bytes.size();
      if (n > 0xFFFF)
        return Error{ErrorCode::OutOfRange, info.name + "." + field.name + ": " +
                                                std::to_string(n) +
                                                " are more than the 65535 that IMC can say"};
      switch (field.type) {
        case FieldType::Raw:
        case FieldType::Text:
          put(static_cast<std::uint16_t>(n));
          out_.insert(out_.end(), value.bytes.begin(), value.bytes.end());
          break;
        case FieldType::List: put(static_cast<std::uint16_t>(n)); [[fallthrough]];
        case FieldType::Message:
          for (const Message& inner : value.messages)
            WATERSKY_CHECK(inline_message(inner, info, field, depth));
          break;
        default: number(value.bits, size_bytes(field.type));
      }
      if (out_.size() > kMaxPacketBytes)
        return Error{ErrorCode::OutOfRange,
                     info.name + "." + field.name + ": with it the packet is longer than the " +
                         std::to_string(kMaxPacketBytes) + " bytes of IMC; send it in parts"};
    }
    return {};
  }

  std::vector<std::uint8_t>& out() { return out_; }

 private:
  void number(std::uint64_t bits, std::size_t size) {
    switch (size) {
      case 1: put(static_cast<std::uint8_t>(bits)); break;
      case 2: put(static_cast<std::uint16_t>(bits)); break;
      case 4: put(static_cast<std::uint32_t>(bits)); break;
      default: put(bits);
    }
  }

  [[nodiscard]] Status inline_message(const Message& inner, const MessageInfo& outer,
                                      const FieldInfo& field, int depth) {
    if (inner.is_none()) {
      put(kNoMessage);
      return {};
    }
    if (!accepts(field, inner.info().id))
      return Error{ErrorCode::InvalidInput,
                   outer.name + "." + field.name + ": " + not_meant(field, inner.info())};
    put(inner.info().id);
    return fields(inner, depth + 1);
  }

  std::endian order_;
  std::vector<std::uint8_t> out_;
};

Result<std::vector<std::uint8_t>> encode(const Message& message, const Header& header,
                                         std::endian order) {
  if (message.is_none())
    return Error{ErrorCode::InvalidInput, "a packet needs a message; this one is none"};
  Encoder encoder(order);
  encoder.out().reserve(kHeaderBytes + message.info().fixed_bytes + kFooterBytes);
  encoder.put(kSync);
  encoder.put(message.info().id);
  encoder.put(std::uint16_t{0});  // the payload's size, below
  encoder.put(std::bit_cast<std::uint64_t>(header.timestamp_s));
  encoder.put(header.source);
  encoder.put(header.source_entity);
  encoder.put(header.destination);
  encoder.put(header.destination_entity);
  WATERSKY_CHECK(encoder.fields(message, 0));
  std::vector<std::uint8_t>& out = encoder.out();
  if (out.size() + kFooterBytes > kMaxPacketBytes)
    return Error{ErrorCode::OutOfRange, message.info().name + ": a packet of " +
                                            std::to_string(out.size() + kFooterBytes) +
                                            " bytes is longer than IMC's 65535; send it in parts"};
  auto size = static_cast<std::uint16_t>(out.size() - kHeaderBytes);
  if (order == std::endian::big) size = detail::swapped(size);
  std::copy_n(reinterpret_cast<const std::uint8_t*>(&size), 2, out.begin() + 4);
  encoder.put(crc(out));
  return std::move(out);
}

}  // namespace watersky::imc
