// SPDX-License-Identifier: MIT
#include "watersky/wire/mcap_writer.hpp"

#include <algorithm>
#include <limits>

#include "watersky/wire/detail/mcap_records.hpp"

namespace watersky::mcap {

using detail::Op;
using detail::put_record;

namespace {

std::string compression_name(Compression c) {
  return c == Compression::None ? "" : std::string(to_string(c));
}

constexpr std::size_t kMostIds = std::numeric_limits<std::uint16_t>::max();

}  // namespace

Result<Writer> Writer::open(ByteSink sink, WriterOptions options) {
  if (options.compression == Compression::Bz2)
    return Error{ErrorCode::Usage, "MCAP has no bz2 chunks; take zstd, lz4 or none"};
  Writer writer(std::move(sink), std::move(options));
  Bytes begin(detail::kMagic.begin(), detail::kMagic.end());
  detail::put_header(begin, {writer.options_.profile, writer.options_.library});
  WATERSKY_CHECK(writer.send(begin));
  return writer;
}

Status Writer::send(std::span<const std::uint8_t> bytes) {
  if (auto sent = sink_(bytes); !sent) {
    failed_ = sent.error();
    return sent;
  }
  sent_ += bytes.size();
  crc_ = crc32_of(bytes, crc_);
  return {};
}

Status Writer::check_open() const {
  if (failed_) return *failed_;
  if (closed_)
    return Error{ErrorCode::Usage, "the MCAP file is closed; nothing more can be written"};
  return {};
}

Result<std::uint16_t> Writer::add_schema(Schema schema) {
  WATERSKY_CHECK(check_open());
  if (schemas_.size() == kMostIds)
    return Error{ErrorCode::OutOfRange, "an MCAP file has 65535 schemas at most"};
  schema.id = static_cast<std::uint16_t>(schemas_.size() + 1);
  detail::put_schema(chunk_, schema);
  schemas_.push_back(std::move(schema));
  return schemas_.back().id;
}

Result<std::uint16_t> Writer::add_channel(Channel channel) {
  WATERSKY_CHECK(check_open());
  if (channels_.size() == kMostIds)
    return Error{ErrorCode::OutOfRange, "an MCAP file has 65535 channels at most"};
  if (channel.schema > schemas_.size())
    return Error{ErrorCode::NotFound, channel.topic + ": its schema " +
                                          std::to_string(channel.schema) +
                                          " was not added before it"};
  channel.id = static_cast<std::uint16_t>(channels_.size() + 1);
  detail::put_channel(chunk_, channel);
  channels_.push_back(std::move(channel));
  return channels_.back().id;
}

Status Writer::write(const Message& message) {
  WATERSKY_CHECK(check_open());
  if (message.channel == 0 || message.channel > channels_.size())
    return Error{ErrorCode::NotFound,
                 "the message's channel " + std::to_string(message.channel) + " was not added"};
  if (!entries_.empty() && chunk_.size() + message.data.size() > options_.chunk_bytes)
    WATERSKY_CHECK(flush());
  entries_[message.channel].push_back({message.log_time, chunk_.size()});
  detail::put_message(chunk_, message);
  Statistics& s = statistics_;
  s.first = s.messages == 0 ? message.log_time : std::min(s.first, message.log_time);
  s.last = s.messages == 0 ? message.log_time : std::max(s.last, message.log_time);
  ++s.messages;
  ++s.channel_messages[message.channel];
  if (chunk_.size() >= options_.chunk_bytes) return flush();
  return {};
}

Status Writer::flush() {
  WATERSKY_CHECK(check_open());
  if (chunk_.empty()) return {};
  ChunkIndex index;
  bool any = false;
  for (const auto& [channel, entries] : entries_)
    for (const Entry& e : entries) {
      index.first = any ? std::min(index.first, e.time) : e.time;
      index.last = any ? std::max(index.last, e.time) : e.time;
      any = true;
    }
  WATERSKY_TRY(Bytes packed, compress(options_.compression, chunk_));
  Compression used = options_.compression;
  // Images do not shrink; then as they are, which also reads faster.
  if (used != Compression::None && packed.size() >= chunk_.size()) {
    used = Compression::None;
    packed = chunk_;
  }
  index.offset = sent_;
  index.compression = compression_name(used);
  index.compressed_bytes = packed.size();
  index.uncompressed_bytes = chunk_.size();
  Bytes out;
  put_record(out, Op::Chunk, [&](Bytes& o) {
    put(o, detail::ns_of(index.first));
    put(o, detail::ns_of(index.last));
    put(o, index.uncompressed_bytes);
    put(o, crc32_of(chunk_));
    watersky::detail::put_text(o, index.compression);
    put(o, index.compressed_bytes);
    watersky::detail::put_bytes(o, packed);
  });
  index.record_bytes = out.size();
  for (auto& [channel, entries] : entries_) {
    index.message_index_offsets[channel] = sent_ + out.size();
    // Readers in the order of time rely on it; ours are mostly in order already.
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.time < b.time; });
    put_record(out, Op::MessageIndex, [&](Bytes& o) {
      put(o, channel);
      put(o, static_cast<std::uint32_t>(entries.size() * 16));
      for (const Entry& e : entries) {
        put(o, detail::ns_of(e.time));
        put(o, e.offset);
      }
    });
  }
  index.message_index_bytes = out.size() - index.record_bytes;
  WATERSKY_CHECK(send(out));
  chunks_.push_back(std::move(index));
  chunk_.clear();
  entries_.clear();
  return {};
}

Status Writer::attach(const Attachment& attachment) {
  WATERSKY_CHECK(check_open());
  Bytes out;
  detail::put_attachment(out, attachment);
  attachments_.push_back({sent_, out.size(), attachment.log_time, attachment.create_time,
                          attachment.data.size(), attachment.name, attachment.media_type});
  return send(out);
}

Status Writer::add_metadata(const Metadata& metadata) {
  WATERSKY_CHECK(check_open());
  Bytes out;
  detail::put_metadata(out, metadata);
  metadata_.push_back({sent_, out.size(), metadata.name});
  return send(out);
}

Status Writer::close() {
  WATERSKY_CHECK(flush());
  Bytes end;
  put_record(end, Op::DataEnd, [&](Bytes& o) { put(o, crc_); });
  WATERSKY_CHECK(send(end));

  const std::uint64_t summary_start = sent_;
  Statistics& s = statistics_;
  s.schemas = static_cast<std::uint16_t>(schemas_.size());
  s.channels = static_cast<std::uint32_t>(channels_.size());
  s.attachments = static_cast<std::uint32_t>(attachments_.size());
  s.metadata = static_cast<std::uint32_t>(metadata_.size());
  s.chunks = static_cast<std::uint32_t>(chunks_.size());
  Bytes summary, offsets;
  const auto group = [&](Op op, const auto& items, auto put_item) {
    const std::size_t at = summary.size();
    for (const auto& item : items) put_item(summary, item);
    if (summary.size() == at) return;
    put_record(offsets, Op::SummaryOffset, [&](Bytes& o) {
      put(o, static_cast<std::uint8_t>(op));
      put(o, summary_start + at);
      put(o, std::uint64_t{summary.size() - at});
    });
  };
  group(Op::Schema, schemas_, detail::put_schema);
  group(Op::Channel, channels_, detail::put_channel);
  group(Op::Statistics, std::span(&s, 1), detail::put_statistics);
  group(Op::ChunkIndex, chunks_, detail::put_chunk_index);
  group(Op::AttachmentIndex, attachments_, detail::put_attachment_index);
  group(Op::MetadataIndex, metadata_, detail::put_metadata_index);
  const std::uint64_t offset_start = summary_start + summary.size();
  watersky::detail::put_bytes(summary, offsets);
  put_record(summary, Op::Footer, [&](Bytes& o) {
    put(o, summary_start);
    put(o, offset_start);
    std::uint32_t crc = 0;
    // The sum covers the footer's own head, whose length is not yet filled in.
    Bytes summed = o;
    const std::uint64_t length = detail::kFooterBytes;
    std::memcpy(summed.data() + summed.size() - 24, &length, sizeof length);
    crc = crc32_of(summed);
    put(o, crc);
  });
  summary.insert(summary.end(), detail::kMagic.begin(), detail::kMagic.end());
  WATERSKY_CHECK(send(summary));
  closed_ = true;
  return {};
}

}  // namespace watersky::mcap
