// SPDX-License-Identifier: MIT
#include <algorithm>

#include "watersky/wire/detail/rosbag_records.hpp"
#include "watersky/wire/rosbag.hpp"

namespace watersky::rosbag {

using detail::Op;
using detail::put_field_number;
using detail::put_record;

namespace {

void put_op(Bytes& header, Op op) { put_field_number(header, "op", static_cast<std::uint8_t>(op)); }

/// Magic and file header.
Bytes beginning(std::uint64_t index_offset, std::size_t connections, std::size_t chunks) {
  Bytes header;
  put_field_number(header, "chunk_count", static_cast<std::uint32_t>(chunks));
  put_field_number(header, "conn_count", static_cast<std::uint32_t>(connections));
  put_field_number(header, "index_pos", index_offset);
  put_op(header, Op::FileHeader);
  const Bytes padding(detail::kFileHeaderBytes - 8 - header.size(), ' ');
  Bytes out(detail::kMagic.begin(), detail::kMagic.end());
  put_record(out, header, padding);
  return out;
}

}  // namespace

Result<Writer> Writer::open(ByteSink sink, WriterOptions options) {
  if (options.compression == Compression::Zstd)
    return Error{ErrorCode::Usage, "bags have no zstd chunks; take none, lz4 or bz2"};
  Writer writer(std::move(sink), options);
  WATERSKY_CHECK(writer.send(beginning(0, 0, 0)));
  return writer;
}

Status Writer::send(std::span<const std::uint8_t> bytes) {
  if (auto sent = sink_(bytes); !sent) {
    failed_ = sent.error();
    return sent;
  }
  sent_ += bytes.size();
  return {};
}

Result<std::uint32_t> Writer::add_connection(Connection connection) {
  connection.id = static_cast<std::uint32_t>(connections_.size());
  detail::put_connection(chunk_, connection);
  connections_.push_back(std::move(connection));
  return connections_.back().id;
}

Status Writer::write(const Message& message) {
  if (failed_) return *failed_;
  if (message.connection >= connections_.size())
    return Error{ErrorCode::NotFound, "the message's connection " +
                                          std::to_string(message.connection) + " was not added"};
  constexpr std::size_t kMost = std::size_t{1} << 31;
  if (message.data.size() > kMost)
    return Error{ErrorCode::OutOfRange, "a message of a bag is 2 GiB at most"};
  if (!entries_.empty() && chunk_.size() + message.data.size() > options_.chunk_bytes)
    WATERSKY_CHECK(flush());
  entries_[message.connection].push_back({message.time, static_cast<std::uint32_t>(chunk_.size())});
  Bytes header, time;
  detail::put_time(time, message.time);
  put_field_number(header, "conn", message.connection);
  put_op(header, Op::Message);
  detail::put_field(header, "time", time);
  put_record(chunk_, header, message.data);
  return chunk_.size() >= options_.chunk_bytes ? flush() : Status{};
}

Status Writer::flush() {
  if (failed_) return *failed_;
  if (chunk_.empty()) return {};
  Chunk info;
  info.offset = sent_;
  bool any = false;
  for (const auto& [connection, entries] : entries_) {
    info.messages[connection] = static_cast<std::uint32_t>(entries.size());
    for (const Entry& e : entries) {
      info.first = any ? std::min(info.first, e.time) : e.time;
      info.last = any ? std::max(info.last, e.time) : e.time;
      any = true;
    }
  }
  WATERSKY_TRY(const Bytes packed, compress(options_.compression, chunk_));
  Bytes out, header;
  detail::put_field(header, "compression",
                    watersky::detail::bytes_of(to_string(options_.compression)));
  put_op(header, Op::Chunk);
  put_field_number(header, "size", static_cast<std::uint32_t>(chunk_.size()));
  put_record(out, header, packed);
  for (auto& [connection, entries] : entries_) {
    Bytes index_header, index;
    put_field_number(index_header, "conn", connection);
    put_field_number(index_header, "count", static_cast<std::uint32_t>(entries.size()));
    put_op(index_header, Op::Index);
    put_field_number(index_header, "ver", std::uint32_t{1});
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.time < b.time; });
    for (const Entry& e : entries) {
      detail::put_time(index, e.time);
      put(index, e.offset);
    }
    put_record(out, index_header, index);
  }
  WATERSKY_CHECK(send(out));
  chunks_.push_back(std::move(info));
  chunk_.clear();
  entries_.clear();
  return {};
}

Result<Bytes> Writer::close() {
  WATERSKY_CHECK(flush());
  const std::uint64_t index_offset = sent_;
  Bytes out;
  for (const Connection& c : connections_) detail::put_connection(out, c);
  for (const Chunk& c : chunks_) {
    Bytes header, first, last, counts;
    detail::put_time(first, c.first);
    detail::put_time(last, c.last);
    put_field_number(header, "chunk_pos", c.offset);
    put_field_number(header, "count", static_cast<std::uint32_t>(c.messages.size()));
    detail::put_field(header, "end_time", last);
    put_op(header, Op::ChunkInfo);
    detail::put_field(header, "start_time", first);
    put_field_number(header, "ver", std::uint32_t{1});
    for (const auto& [connection, n] : c.messages) {
      put(counts, connection);
      put(counts, n);
    }
    put_record(out, header, counts);
  }
  WATERSKY_CHECK(send(out));
  return beginning(index_offset, connections_.size(), chunks_.size());
}

}  // namespace watersky::rosbag
