// SPDX-License-Identifier: MIT
#include "watersky/wire/mavlink.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <type_traits>

#include "watersky/wire/detail/crc16.hpp"
#include "watersky/wire/detail/mavlink_frame.hpp"
#include "watersky/wire/detail/mavlink_table.hpp"
#include "watersky/wire/detail/nearest.hpp"

namespace watersky::mavlink {

namespace {

static_assert(std::endian::native == std::endian::little,
              "payloads are copied as they are: MAVLink is little-endian");

using namespace detail;

struct TypeName {
  std::string_view ours;
  std::string_view xml;  ///< as CRC_EXTRA hashes it
  FieldType type;
  std::size_t size;
};
constexpr TypeName kTypes[] = {
    {"u8", "uint8_t", FieldType::U8, 1},    {"i8", "int8_t", FieldType::I8, 1},
    {"u16", "uint16_t", FieldType::U16, 2}, {"i16", "int16_t", FieldType::I16, 2},
    {"u32", "uint32_t", FieldType::U32, 4}, {"i32", "int32_t", FieldType::I32, 4},
    {"u64", "uint64_t", FieldType::U64, 8}, {"i64", "int64_t", FieldType::I64, 8},
    {"f32", "float", FieldType::F32, 4},    {"f64", "double", FieldType::F64, 8},
    {"char", "char", FieldType::Char, 1},
};

const TypeName& type_name(FieldType type) {
  return *std::find_if(std::begin(kTypes), std::end(kTypes),
                       [&](const TypeName& t) { return t.type == type; });
}

/// "+name f32[4] [m]" → a field at `offset`.
FieldInfo parse_field(std::string_view text, std::uint8_t offset) {
  FieldInfo field;
  field.offset = offset;
  if (text.front() == '+') {
    field.extension = true;
    text.remove_prefix(1);
  }
  const std::size_t space = text.find(' ');
  field.name = text.substr(0, space);
  std::string_view rest = text.substr(space + 1);
  const std::size_t unit = rest.find(" [");
  if (unit != std::string_view::npos) {
    field.unit = rest.substr(unit + 2, rest.size() - unit - 3);
    rest = rest.substr(0, unit);
  }
  const std::size_t bracket = rest.find('[');
  if (bracket != std::string_view::npos) {
    int count = 0;
    std::from_chars(rest.data() + bracket + 1, rest.data() + rest.size(), count);
    field.count = static_cast<std::uint8_t>(count);
    rest = rest.substr(0, bracket);
  }
  const auto* type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                  [&](const TypeName& t) { return t.ours == rest; });
  WATERSKY_REQUIRE(type != std::end(kTypes));
  field.type = type->type;
  return field;
}

MessageInfo parse_row(const detail::TableRow& row) {
  MessageInfo info{row.id, row.name, row.crc_extra, row.min_length, row.max_length, {}};
  std::size_t offset = 0;
  std::string_view rest = row.fields;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find("; "), rest.size());
    info.fields.push_back(parse_field(rest.substr(0, end), static_cast<std::uint8_t>(offset)));
    const FieldInfo& field = info.fields.back();
    offset += size_bytes(field.type) * std::max<std::size_t>(1, field.count);
    rest.remove_prefix(std::min(end + 2, rest.size()));
  }
  WATERSKY_REQUIRE(offset == row.max_length);
  return info;
}

struct Table {
  std::vector<MessageInfo> all;
  /// 1 + place in `all` of the ids that nearly all frames have; 0: not known.
  std::array<std::uint16_t, 512> low{};

  Table() {
    for (const TableRow& row : table_rows()) all.push_back(parse_row(row));
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].id < low.size()) low[all[i].id] = static_cast<std::uint16_t>(i + 1);
  }
};

const Table& table() {
  static const Table parsed;
  return parsed;
}

/// Calls `use` with a value of the field's C++ type.
template <class Use>
auto with_type(FieldType type, Use&& use) {
  switch (type) {
    case FieldType::U8: return use(std::uint8_t{});
    case FieldType::I8: return use(std::int8_t{});
    case FieldType::U16: return use(std::uint16_t{});
    case FieldType::I16: return use(std::int16_t{});
    case FieldType::U32: return use(std::uint32_t{});
    case FieldType::I32: return use(std::int32_t{});
    case FieldType::U64: return use(std::uint64_t{});
    case FieldType::I64: return use(std::int64_t{});
    case FieldType::F32: return use(float{});
    case FieldType::F64: return use(double{});
    case FieldType::Char: break;
  }
  return use(std::uint8_t{});
}

}  // namespace

std::size_t size_bytes(FieldType type) { return type_name(type).size; }

const FieldInfo* MessageInfo::field(std::string_view field_name) const {
  const auto it = std::find_if(fields.begin(), fields.end(),
                               [&](const FieldInfo& f) { return f.name == field_name; });
  return it == fields.end() ? nullptr : &*it;
}

std::span<const MessageInfo> messages() { return table().all; }

const MessageInfo* find_message(std::uint32_t id) {
  const auto& [all, low] = table();
  if (id < low.size()) return low[id] == 0 ? nullptr : &all[low[id] - 1];
  const auto it = std::lower_bound(all.begin(), all.end(), id,
                                   [](const MessageInfo& m, std::uint32_t x) { return m.id < x; });
  return it != all.end() && it->id == id ? &*it : nullptr;
}

const MessageInfo* find_message(std::string_view name) {
  const auto& all = table().all;
  const auto it =
      std::find_if(all.begin(), all.end(), [&](const MessageInfo& m) { return m.name == name; });
  return it == all.end() ? nullptr : &*it;
}

std::uint16_t crc(std::span<const std::uint8_t> bytes, std::uint16_t crc) {
  return watersky::detail::crc16<0x8408>(bytes, crc);
}

std::uint8_t compute_crc_extra(const MessageInfo& info) {
  std::uint16_t c = 0xFFFF;
  const auto add = [&](std::string_view text) {
    for (const char letter : text) {
      const auto byte = static_cast<std::uint8_t>(letter);
      c = crc({&byte, 1}, c);
    }
  };
  add(info.name);
  add(" ");
  for (const FieldInfo& field : info.fields) {
    if (field.extension) continue;
    add(type_name(field.type).xml);
    add(" ");
    add(field.name);
    add(" ");
    if (field.count > 0) c = crc({&field.count, 1}, c);
  }
  return static_cast<std::uint8_t>((c & 0xFF) ^ (c >> 8));
}

ParseStep parse_frame(std::span<const std::uint8_t> bytes) {
  const ParseStep need_more{ParseOutcome::NeedMore, {}};
  const ParseStep not_a_frame{};
  if (bytes.empty()) return need_more;
  const bool v2 = bytes[0] == kMagic2;
  if (!v2 && bytes[0] != kMagic1) return not_a_frame;
  const std::size_t header = v2 ? kHeader2 : kHeader1;
  if (bytes.size() < header) return need_more;

  Frame frame;
  frame.version = v2 ? 2 : 1;
  const std::size_t length = bytes[1];
  std::size_t i = 2;
  if (v2) {
    if ((bytes[2] & ~kIncompatSigned) != 0) return not_a_frame;
    frame.is_signed = (bytes[2] & kIncompatSigned) != 0;
    i = 4;
  }
  frame.sequence = bytes[i];
  frame.system = bytes[i + 1];
  frame.component = bytes[i + 2];
  frame.message_id = bytes[i + 3];
  if (v2)
    frame.message_id |=
        static_cast<std::uint32_t>(bytes[8]) << 8 | static_cast<std::uint32_t>(bytes[9]) << 16;
  frame.info = find_message(frame.message_id);
  if (frame.info && !v2 && length != frame.info->min_length) return not_a_frame;

  const std::size_t size = header + length + 2 + (frame.is_signed ? kSignature : 0);
  if (bytes.size() < size) return need_more;
  frame.payload = bytes.subspan(header, length);
  frame.bytes = bytes.first(size);
  if (frame.info) {
    std::uint16_t expected = crc(bytes.subspan(1, header - 1 + length));
    expected = crc({&frame.info->crc_extra, 1}, expected);
    const int sent = bytes[header + length] | bytes[header + length + 1] << 8;
    if (sent != expected) return not_a_frame;
  }
  return {ParseOutcome::Frame, frame};
}

Message::Message(const Frame& frame)
    : info_(frame.info), system_(frame.system), component_(frame.component) {
  WATERSKY_REQUIRE(info_ != nullptr);
  const std::size_t n = std::min<std::size_t>(frame.payload.size(), info_->max_length);
  std::copy_n(frame.payload.begin(), n, payload_.begin());
}

const FieldInfo& Message::checked(std::string_view field, std::size_t index) const {
  const FieldInfo* found = info_->field(field);
  WATERSKY_REQUIRE(found != nullptr && index < std::max<std::size_t>(1, found->count));
  (void)index;
  return *found;
}

double Message::number(const FieldInfo& f, std::size_t index) const {
  return with_type(f.type, [&](auto value) {
    std::memcpy(&value, payload_.data() + f.offset + index * sizeof value, sizeof value);
    return static_cast<double>(value);
  });
}

std::int64_t Message::integer(std::string_view field, std::size_t index) const {
  const FieldInfo& f = checked(field, index);
  WATERSKY_REQUIRE(f.type != FieldType::F32 && f.type != FieldType::F64);
  return with_type(f.type, [&](auto value) -> std::int64_t {
    std::memcpy(&value, payload_.data() + f.offset + index * sizeof value, sizeof value);
    if constexpr (std::is_floating_point_v<decltype(value)>)
      return 0;
    else
      return static_cast<std::int64_t>(value);
  });
}

std::string Message::text(std::string_view field) const {
  const FieldInfo& f = checked(field, 0);
  const auto begin = payload_.begin() + f.offset;
  return {begin, std::find(begin, begin + std::max<int>(1, f.count), 0)};
}

Message& Message::set(std::string_view field, double value, std::size_t index) {
  const FieldInfo& f = checked(field, index);
  with_type(f.type, [&](auto stored) {
    stored = watersky::detail::nearest<decltype(stored)>(value);
    std::memcpy(payload_.data() + f.offset + index * sizeof stored, &stored, sizeof stored);
  });
  return *this;
}

Message& Message::set_integer(std::string_view field, std::int64_t value, std::size_t index) {
  const FieldInfo& f = checked(field, index);
  WATERSKY_REQUIRE(f.type != FieldType::F32 && f.type != FieldType::F64);
  with_type(f.type, [&](auto stored) {
    stored = static_cast<decltype(stored)>(value);
    std::memcpy(payload_.data() + f.offset + index * sizeof stored, &stored, sizeof stored);
  });
  return *this;
}

Message& Message::set_text(std::string_view field, std::string_view value) {
  const FieldInfo& f = checked(field, 0);
  const auto begin = payload_.begin() + f.offset;
  std::fill_n(begin, f.count, std::uint8_t{0});
  std::copy_n(value.begin(), std::min<std::size_t>(value.size(), f.count), begin);
  return *this;
}

Result<std::vector<std::uint8_t>> encode(const Message& message, const Sender& sender,
                                         int version) {
  const MessageInfo& info = message.info();
  if (version == 1 && info.id > 255)
    return Error{ErrorCode::Unsupported,
                 std::string(info.name) + " cannot be sent as MAVLink 1; use version 2"};
  std::size_t length = version == 1 ? info.min_length : info.max_length;
  if (version != 1)
    while (length > 1 && message.payload()[length - 1] == 0) --length;

  std::vector<std::uint8_t> out;
  out.reserve(length + 12);
  const auto len = static_cast<std::uint8_t>(length);
  const auto id = [&](int shift) { return static_cast<std::uint8_t>(info.id >> shift); };
  if (version == 1)
    out = {kMagic1, len, sender.sequence, sender.system, sender.component, id(0)};
  else
    out = {kMagic2,          len,   0,     0,     sender.sequence, sender.system,
           sender.component, id(0), id(8), id(16)};
  const auto payload = message.payload().first(length);
  out.insert(out.end(), payload.begin(), payload.end());
  std::uint16_t c = crc(std::span(out).subspan(1));
  c = crc({&info.crc_extra, 1}, c);
  out.push_back(static_cast<std::uint8_t>(c & 0xFF));
  out.push_back(static_cast<std::uint8_t>(c >> 8));
  return out;
}

}  // namespace watersky::mavlink
