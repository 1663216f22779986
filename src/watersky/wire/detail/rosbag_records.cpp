// SPDX-License-Identifier: MIT
#include "watersky/wire/detail/rosbag_records.hpp"

#include <algorithm>

namespace watersky::rosbag::detail {

using watersky::detail::bytes_of;
using watersky::detail::Cursor;
using watersky::detail::put_sized;

Result<Fields> Fields::parse(std::span<const std::uint8_t> header, std::uint64_t offset) {
  Fields out;
  Cursor c(header, offset);
  while (!c.done()) {
    const auto field = c.sized();
    if (c.failed()) break;
    const auto equals = std::find(field.begin(), field.end(), '=');
    if (equals == field.end())
      return Error{ErrorCode::InvalidInput, "byte " + std::to_string(offset + c.at()) +
                                                ": a field of the header has no = in it"};
    const auto name_bytes = static_cast<std::size_t>(equals - field.begin());
    out.fields_.insert_or_assign(std::string(field.begin(), equals), field.subspan(name_bytes + 1));
  }
  WATERSKY_CHECK(c.check("a field of the header"));
  return out;
}

std::string Fields::text(std::string_view name) const {
  const auto at = fields_.find(name);
  if (at == fields_.end()) return {};
  return {at->second.begin(), at->second.end()};
}

std::optional<Time> Fields::time(std::string_view name) const {
  const auto at = fields_.find(name);
  if (at == fields_.end() || at->second.size() != 8) return std::nullopt;
  return time_of(number_at<std::uint32_t>(at->second, 0), number_at<std::uint32_t>(at->second, 4));
}

Time time_of(std::uint32_t s, std::uint32_t ns) {
  return Time(std::chrono::seconds(s) + Duration(ns));
}

void put_time(Bytes& out, Time time) {
  const auto ns = std::max<std::int64_t>(0, time.time_since_epoch().count());
  put(out, static_cast<std::uint32_t>(std::min<std::int64_t>(ns / 1'000'000'000, 0xFFFF'FFFF)));
  put(out, static_cast<std::uint32_t>(ns % 1'000'000'000));
}

void put_field(Bytes& out, std::string_view name, std::span<const std::uint8_t> value) {
  put(out, static_cast<std::uint32_t>(name.size() + 1 + value.size()));
  watersky::detail::put_bytes(out, bytes_of(name));
  out.push_back('=');
  watersky::detail::put_bytes(out, value);
}

void put_record(Bytes& out, const Bytes& header, std::span<const std::uint8_t> data) {
  put_sized(out, header);
  put_sized(out, data);
}

void put_connection(Bytes& out, const Connection& c) {
  Bytes header, data;
  put_field_number(header, "conn", c.id);
  put_field_number(header, "op", static_cast<std::uint8_t>(Op::Connection));
  put_field(header, "topic", bytes_of(c.topic));
  if (!c.caller.empty()) put_field(data, "callerid", bytes_of(c.caller));
  if (c.latching) put_field(data, "latching", bytes_of("1"));
  put_field(data, "md5sum", bytes_of(c.md5sum));
  put_field(data, "message_definition", bytes_of(c.definition));
  put_field(data, "topic", bytes_of(c.topic));
  put_field(data, "type", bytes_of(c.type));
  put_record(out, header, data);
}

}  // namespace watersky::rosbag::detail
