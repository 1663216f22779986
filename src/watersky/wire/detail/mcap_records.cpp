// SPDX-License-Identifier: MIT
#include "watersky/wire/detail/mcap_records.hpp"

#include <algorithm>
#include <limits>

#include "watersky/wire/compression.hpp"

namespace watersky::mcap::detail {

using watersky::detail::put_bytes;
using watersky::detail::put_sized;
using watersky::detail::put_text;

namespace {

Time time(Cursor& c) { return time_of(c.number<std::uint64_t>()); }

std::map<std::string, std::string> text_map(Cursor& c) {
  std::map<std::string, std::string> out;
  Cursor items(c.sized());
  while (!items.done()) {
    std::string key = items.text(), value = items.text();
    if (!items.failed()) out.insert_or_assign(std::move(key), std::move(value));
  }
  return out;
}

std::map<std::uint16_t, std::uint64_t> number_map(Cursor& c) {
  std::map<std::uint16_t, std::uint64_t> out;
  Cursor items(c.sized());
  while (!items.done()) {
    const auto key = items.number<std::uint16_t>();
    const auto value = items.number<std::uint64_t>();
    if (!items.failed()) out.insert_or_assign(key, value);
  }
  return out;
}

/// Appends what `fill` appends, its size in bytes before it.
template <class Fill>
void put_list(Bytes& out, Fill&& fill) {
  const std::size_t at = out.size();
  put(out, std::uint32_t{0});
  fill();
  const auto size = static_cast<std::uint32_t>(out.size() - at - 4);
  std::memcpy(out.data() + at, &size, sizeof size);
}

void put_map(Bytes& out, const std::map<std::string, std::string>& map) {
  put_list(out, [&] {
    for (const auto& [key, value] : map) {
      put_text(out, key);
      put_text(out, value);
    }
  });
}

void put_map(Bytes& out, const std::map<std::uint16_t, std::uint64_t>& map) {
  put_list(out, [&] {
    for (const auto& [key, value] : map) {
      put(out, key);
      put(out, value);
    }
  });
}

template <class T>
Result<T> checked(const Cursor& c, T value, std::string_view what) {
  WATERSKY_CHECK(c.check(what));
  return value;
}

}  // namespace

Time time_of(std::uint64_t ns) {
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  return Time(Duration(static_cast<std::int64_t>(std::min(ns, kMost))));
}

std::uint64_t ns_of(Time t) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, t.time_since_epoch().count()));
}

std::string name_of(std::uint8_t op) {
  constexpr std::array kNames = {"Header",        "Footer",          "Schema",       "Channel",
                                 "Message",       "Chunk",           "MessageIndex", "ChunkIndex",
                                 "Attachment",    "AttachmentIndex", "Statistics",   "Metadata",
                                 "MetadataIndex", "SummaryOffset",   "DataEnd"};
  if (op >= 1 && op <= kNames.size()) return kNames[op - 1u];
  constexpr char kHex[] = "0123456789abcdef";
  return std::string("record 0x") + kHex[op >> 4] + kHex[op & 15];
}

Result<Header> parse_header(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Header out;
  out.profile = c.text();
  out.library = c.text();
  return checked(c, std::move(out), "a Header");
}

Result<Footer> parse_footer(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Footer out;
  out.summary_start = c.number<std::uint64_t>();
  out.summary_offset_start = c.number<std::uint64_t>();
  out.summary_crc = c.number<std::uint32_t>();
  return checked(c, out, "a Footer");
}

Result<Schema> parse_schema(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Schema out;
  out.id = c.number<std::uint16_t>();
  out.name = c.text();
  out.encoding = c.text();
  const auto data = c.sized();
  out.data.assign(data.begin(), data.end());
  WATERSKY_CHECK(c.check("a Schema"));
  if (out.id == 0)
    return Error{ErrorCode::InvalidInput,
                 "byte " + std::to_string(offset) + ": a Schema has the id 0, which means none"};
  return out;
}

Result<Channel> parse_channel(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Channel out;
  out.id = c.number<std::uint16_t>();
  out.schema = c.number<std::uint16_t>();
  out.topic = c.text();
  out.message_encoding = c.text();
  out.metadata = text_map(c);
  return checked(c, std::move(out), "a Channel");
}

Result<Message> parse_message(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Message out;
  out.channel = c.number<std::uint16_t>();
  out.sequence = c.number<std::uint32_t>();
  out.log_time = time(c);
  out.publish_time = time(c);
  out.data = c.rest();
  return checked(c, out, "a Message");
}

Result<Chunk> parse_chunk(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Chunk out;
  out.first = time(c);
  out.last = time(c);
  out.uncompressed_bytes = c.number<std::uint64_t>();
  out.crc = c.number<std::uint32_t>();
  out.compression = c.text();
  out.records = c.bytes(c.number<std::uint64_t>());
  return checked(c, std::move(out), "a Chunk");
}

Result<ChunkIndex> parse_chunk_index(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  ChunkIndex out;
  out.first = time(c);
  out.last = time(c);
  out.offset = c.number<std::uint64_t>();
  out.record_bytes = c.number<std::uint64_t>();
  out.message_index_offsets = number_map(c);
  out.message_index_bytes = c.number<std::uint64_t>();
  out.compression = c.text();
  out.compressed_bytes = c.number<std::uint64_t>();
  out.uncompressed_bytes = c.number<std::uint64_t>();
  return checked(c, std::move(out), "a ChunkIndex");
}

Result<Attachment> parse_attachment(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Attachment out;
  out.log_time = time(c);
  out.create_time = time(c);
  out.name = c.text();
  out.media_type = c.text();
  const auto data = c.bytes(c.number<std::uint64_t>());
  const std::size_t summed = c.at();
  const auto crc = c.number<std::uint32_t>();
  WATERSKY_CHECK(c.check("an Attachment"));
  if (crc != 0 && crc != crc32_of(b.first(summed)))
    return Error{ErrorCode::InvalidInput, "byte " + std::to_string(offset) + ": the attachment " +
                                              out.name + " is damaged (its CRC is wrong)"};
  out.data.assign(data.begin(), data.end());
  return out;
}

Result<AttachmentIndex> parse_attachment_index(std::span<const std::uint8_t> b,
                                               std::uint64_t offset) {
  Cursor c(b, offset);
  AttachmentIndex out;
  out.offset = c.number<std::uint64_t>();
  out.record_bytes = c.number<std::uint64_t>();
  out.log_time = time(c);
  out.create_time = time(c);
  out.data_bytes = c.number<std::uint64_t>();
  out.name = c.text();
  out.media_type = c.text();
  return checked(c, std::move(out), "an AttachmentIndex");
}

Result<Metadata> parse_metadata(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Metadata out;
  out.name = c.text();
  out.values = text_map(c);
  return checked(c, std::move(out), "a Metadata record");
}

Result<MetadataIndex> parse_metadata_index(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  MetadataIndex out;
  out.offset = c.number<std::uint64_t>();
  out.record_bytes = c.number<std::uint64_t>();
  out.name = c.text();
  return checked(c, std::move(out), "a MetadataIndex");
}

Result<Statistics> parse_statistics(std::span<const std::uint8_t> b, std::uint64_t offset) {
  Cursor c(b, offset);
  Statistics out;
  out.messages = c.number<std::uint64_t>();
  out.schemas = c.number<std::uint16_t>();
  out.channels = c.number<std::uint32_t>();
  out.attachments = c.number<std::uint32_t>();
  out.metadata = c.number<std::uint32_t>();
  out.chunks = c.number<std::uint32_t>();
  out.first = time(c);
  out.last = time(c);
  out.channel_messages = number_map(c);
  return checked(c, std::move(out), "a Statistics record");
}

void put_header(Bytes& out, const Header& header) {
  put_record(out, Op::Header, [&](Bytes& o) {
    put_text(o, header.profile);
    put_text(o, header.library);
  });
}

void put_schema(Bytes& out, const Schema& schema) {
  put_record(out, Op::Schema, [&](Bytes& o) {
    put(o, schema.id);
    put_text(o, schema.name);
    put_text(o, schema.encoding);
    put_sized(o, schema.data);
  });
}

void put_channel(Bytes& out, const Channel& channel) {
  put_record(out, Op::Channel, [&](Bytes& o) {
    put(o, channel.id);
    put(o, channel.schema);
    put_text(o, channel.topic);
    put_text(o, channel.message_encoding);
    put_map(o, channel.metadata);
  });
}

void put_message(Bytes& out, const Message& message) {
  put_record(out, Op::Message, [&](Bytes& o) {
    put(o, message.channel);
    put(o, message.sequence);
    put(o, ns_of(message.log_time));
    put(o, ns_of(message.publish_time));
    put_bytes(o, message.data);
  });
}

void put_chunk_index(Bytes& out, const ChunkIndex& index) {
  put_record(out, Op::ChunkIndex, [&](Bytes& o) {
    put(o, ns_of(index.first));
    put(o, ns_of(index.last));
    put(o, index.offset);
    put(o, index.record_bytes);
    put_map(o, index.message_index_offsets);
    put(o, index.message_index_bytes);
    put_text(o, index.compression);
    put(o, index.compressed_bytes);
    put(o, index.uncompressed_bytes);
  });
}

void put_attachment(Bytes& out, const Attachment& attachment) {
  put_record(out, Op::Attachment, [&](Bytes& o) {
    const std::size_t at = o.size();
    put(o, ns_of(attachment.log_time));
    put(o, ns_of(attachment.create_time));
    put_text(o, attachment.name);
    put_text(o, attachment.media_type);
    put(o, std::uint64_t{attachment.data.size()});
    put_bytes(o, attachment.data);
    put(o, crc32_of(std::span(o).subspan(at)));
  });
}

void put_attachment_index(Bytes& out, const AttachmentIndex& index) {
  put_record(out, Op::AttachmentIndex, [&](Bytes& o) {
    put(o, index.offset);
    put(o, index.record_bytes);
    put(o, ns_of(index.log_time));
    put(o, ns_of(index.create_time));
    put(o, index.data_bytes);
    put_text(o, index.name);
    put_text(o, index.media_type);
  });
}

void put_metadata(Bytes& out, const Metadata& metadata) {
  put_record(out, Op::Metadata, [&](Bytes& o) {
    put_text(o, metadata.name);
    put_map(o, metadata.values);
  });
}

void put_metadata_index(Bytes& out, const MetadataIndex& index) {
  put_record(out, Op::MetadataIndex, [&](Bytes& o) {
    put(o, index.offset);
    put(o, index.record_bytes);
    put_text(o, index.name);
  });
}

void put_statistics(Bytes& out, const Statistics& statistics) {
  put_record(out, Op::Statistics, [&](Bytes& o) {
    put(o, statistics.messages);
    put(o, statistics.schemas);
    put(o, statistics.channels);
    put(o, statistics.attachments);
    put(o, statistics.metadata);
    put(o, statistics.chunks);
    put(o, ns_of(statistics.first));
    put(o, ns_of(statistics.last));
    put_map(o, statistics.channel_messages);
  });
}

}  // namespace watersky::mcap::detail
