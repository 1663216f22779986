// SPDX-License-Identifier: MIT
#include "watersky/wire/mcap_reader.hpp"

#include <algorithm>
#include <cstring>

#include "watersky/wire/compression.hpp"
#include "watersky/wire/detail/damage.hpp"
#include "watersky/wire/detail/mcap_records.hpp"
#include "watersky/wire/detail/record_cache.hpp"
#include "watersky/wire/detail/window.hpp"

namespace watersky::mcap {

using detail::kHeadBytes;
using detail::kMagic;
using detail::Op;
using watersky::detail::bad_at;
using watersky::detail::damage_at;
using watersky::detail::Window;

namespace {

bool is_magic(std::span<const std::uint8_t> bytes) {
  return std::equal(bytes.begin(), bytes.end(), kMagic.begin(), kMagic.end());
}

Result<Compression> compression_of(const std::string& name, std::uint64_t offset) {
  if (name.empty()) return Compression::None;
  if (name == "lz4") return Compression::Lz4;
  if (name == "zstd") return Compression::Zstd;
  return Error{ErrorCode::Unsupported, "byte " + std::to_string(offset) +
                                           ": the chunk is compressed by \"" + name +
                                           "\"; lz4 and zstd are read"};
}

/// Unpacks a chunk's content and checks its CRC; `offset` of its record.
Result<Bytes> unpack(std::span<const std::uint8_t> content, std::uint64_t offset,
                     std::uint64_t max_bytes, detail::Chunk& chunk) {
  WATERSKY_TRY(chunk, detail::parse_chunk(content, offset + kHeadBytes));
  WATERSKY_TRY(const Compression compression, compression_of(chunk.compression, offset));
  if (chunk.uncompressed_bytes > max_bytes)
    return bad_at(offset, "the chunk claims " + std::to_string(chunk.uncompressed_bytes) +
                              " bytes, more than the " + std::to_string(max_bytes) + " allowed");
  auto records = decompress(compression, chunk.records, chunk.uncompressed_bytes);
  if (!records) return bad_at(offset, "the chunk " + records.error().message);
  if (chunk.crc != 0 && chunk.crc != crc32_of(*records))
    return bad_at(offset, "the chunk is damaged (its CRC is wrong)");
  return records;
}

/// Calls `each(op, content, offset in the chunk)`; what does not fit is told and ends it.
template <class Each>
std::optional<std::string> for_records(std::span<const std::uint8_t> records, Each&& each) {
  std::size_t at = 0;
  while (at < records.size()) {
    watersky::detail::Cursor c(records.subspan(at));
    const auto op = c.number<std::uint8_t>();
    const auto body = c.bytes(c.number<std::uint64_t>());
    if (c.failed())
      return "in the chunk, at its byte " + std::to_string(at) +
             ", a record is longer than what is left";
    each(op, body, at);
    at += c.at();
  }
  return std::nullopt;
}

bool wanted(const Message& m, const Selection& s) {
  return (!s.channels || s.channels->contains(m.channel)) && (!s.first || m.log_time >= *s.first) &&
         (!s.last || m.log_time <= *s.last);
}

bool may_hold(const ChunkIndex& chunk, const Selection& s) {
  if ((s.first && chunk.last < *s.first) || (s.last && chunk.first > *s.last)) return false;
  if (!s.channels || chunk.message_index_offsets.empty()) return true;
  return std::any_of(s.channels->begin(), s.channels->end(),
                     [&](std::uint16_t id) { return chunk.message_index_offsets.contains(id); });
}

}  // namespace

struct Reader::Cache : watersky::detail::ChunkCache {};

/// What a walk over the data section calls, and what it could not read.
struct Reader::Scan {
  std::function<void(std::uint8_t op, std::span<const std::uint8_t> content, std::uint64_t offset,
                     std::uint64_t record_bytes)>
      use;
  std::vector<Damage> damage;
  bool check_crc = false;  ///< of the whole data section
};

Reader::Reader(std::shared_ptr<const ByteSource> source, const ReaderOptions& options)
    : source_(std::move(source)), options_(options), cache_(std::make_shared<Cache>()) {}

Result<Reader> Reader::open(std::shared_ptr<const ByteSource> source,
                            const ReaderOptions& options) {
  Reader reader(std::move(source), options);
  const ByteSource& s = *reader.source_;
  std::array<std::uint8_t, 8> magic{};
  if (s.size() < magic.size()) return bad_at(0, "is no MCAP file (it is too short)");
  WATERSKY_CHECK(s.read(0, magic));
  if (!is_magic(magic)) return bad_at(0, "is no MCAP file (it does not begin as one)");
  if (options.use_summary) {
    WATERSKY_TRY(reader.indexed_, reader.read_summary());
  }
  if (!reader.indexed_) WATERSKY_CHECK(reader.scan());
  std::sort(reader.chunks_.begin(), reader.chunks_.end(),
            [](const ChunkIndex& a, const ChunkIndex& b) { return a.offset < b.offset; });
  return reader;
}

void Reader::add_schema(Schema schema, std::uint64_t offset) {
  const auto [at, is_new] = schemas_.emplace(schema.id, schema);
  if (!is_new && !(at->second == schema))
    damage_.push_back({offset, "the schema " + std::to_string(schema.id) +
                                   " is told again and differently; the first counts"});
}

void Reader::add_channel(Channel channel, std::uint64_t offset) {
  const auto [at, is_new] = channels_.emplace(channel.id, channel);
  if (!is_new && !(at->second == channel))
    damage_.push_back({offset, "the channel " + std::to_string(channel.id) +
                                   " is told again and differently; the first counts"});
}

Result<bool> Reader::read_summary() {
  const ByteSource& s = *source_;
  const auto not_closed = [&] {
    damage_.push_back({s.size(), "the file does not end with its summary: it was not closed"});
    return false;
  };
  if (s.size() < kMagic.size() + detail::kTailBytes) return not_closed();
  const std::uint64_t footer_at = s.size() - detail::kTailBytes;
  Bytes tail(detail::kTailBytes);
  WATERSKY_CHECK(s.read(footer_at, tail));
  if (!is_magic(std::span(tail).last(kMagic.size())) ||
      tail[0] != static_cast<std::uint8_t>(Op::Footer) ||
      number_at<std::uint64_t>(tail, 1) != detail::kFooterBytes)
    return not_closed();
  WATERSKY_TRY(const detail::Footer footer,
               detail::parse_footer(std::span(tail).subspan(kHeadBytes, detail::kFooterBytes),
                                    footer_at + kHeadBytes));
  if (footer.summary_start == 0) return false;
  const auto no = [&](std::uint64_t offset, const std::string& why) {
    damage_.push_back({offset, why});
    schemas_.clear();
    channels_.clear();
    chunks_.clear();
    attachments_.clear();
    metadata_.clear();
    statistics_.reset();
    return false;
  };
  if (footer.summary_start < kMagic.size() || footer.summary_start > footer_at ||
      footer_at - footer.summary_start > options_.max_record_bytes)
    return no(footer_at, "the summary cannot be where the footer says");
  Bytes summary(static_cast<std::size_t>(footer_at - footer.summary_start));
  WATERSKY_CHECK(s.read(footer.summary_start, summary));
  if (footer.summary_crc != 0) {
    const std::uint32_t crc =
        crc32_of(std::span(tail).first(detail::kTailBytes - kMagic.size() - 4), crc32_of(summary));
    if (crc != footer.summary_crc)
      return no(footer.summary_start, "the summary is damaged (its CRC is wrong)");
  }
  std::optional<Damage> wrong;
  const auto took = [&](auto&& parsed, std::uint64_t offset, auto&& take) {
    if (parsed)
      take(std::move(*parsed));
    else if (!wrong)
      wrong = damage_at(offset, parsed.error());
  };
  const auto cut =
      for_records(summary, [&](std::uint8_t op, std::span<const std::uint8_t> c, std::size_t at) {
        const std::uint64_t offset = footer.summary_start + at;
        switch (static_cast<Op>(op)) {
          case Op::Schema:
            return took(detail::parse_schema(c, offset), offset,
                        [&](Schema&& x) { add_schema(std::move(x), offset); });
          case Op::Channel:
            return took(detail::parse_channel(c, offset), offset,
                        [&](Channel&& x) { add_channel(std::move(x), offset); });
          case Op::Statistics:
            return took(detail::parse_statistics(c, offset), offset,
                        [&](Statistics&& x) { statistics_ = std::move(x); });
          case Op::ChunkIndex:
            return took(detail::parse_chunk_index(c, offset), offset,
                        [&](ChunkIndex&& x) { chunks_.push_back(std::move(x)); });
          case Op::AttachmentIndex:
            return took(detail::parse_attachment_index(c, offset), offset,
                        [&](AttachmentIndex&& x) { attachments_.push_back(std::move(x)); });
          case Op::MetadataIndex:
            return took(detail::parse_metadata_index(c, offset), offset,
                        [&](MetadataIndex&& x) { metadata_.push_back(std::move(x)); });
          default: return;
        }
      });
  if (cut) return no(footer.summary_start, "the summary ends in the middle of a record");
  if (wrong) return no(wrong->offset, wrong->reason);
  // A summary of statistics alone does not lead to the messages.
  if (channels_.empty() && (!statistics_ || statistics_->messages > 0))
    return no(footer.summary_start, "the summary names no channels");
  const auto head = content(kMagic.size(), static_cast<std::uint8_t>(Op::Header), 0);
  if (!head) return no(kMagic.size(), damage_at(kMagic.size(), head.error()).reason);
  auto header = detail::parse_header(*head, kMagic.size() + kHeadBytes);
  if (!header) return no(kMagic.size(), header.error().message);
  header_ = std::move(*header);
  return true;
}

Status Reader::scan() {
  Statistics count;
  const auto message = [&](const Message& m) {
    count.first = count.messages == 0 ? m.log_time : std::min(count.first, m.log_time);
    count.last = count.messages == 0 ? m.log_time : std::max(count.last, m.log_time);
    ++count.messages;
    ++count.channel_messages[m.channel];
  };
  Scan scan;
  scan.check_crc = true;
  bool header_seen = false;
  const auto definition = [&](std::uint8_t op, std::span<const std::uint8_t> c,
                              std::uint64_t offset) -> Status {
    if (static_cast<Op>(op) == Op::Schema) {
      WATERSKY_TRY(Schema x, detail::parse_schema(c, offset));
      add_schema(std::move(x), offset);
    } else if (static_cast<Op>(op) == Op::Channel) {
      WATERSKY_TRY(Channel x, detail::parse_channel(c, offset));
      add_channel(std::move(x), offset);
    } else if (static_cast<Op>(op) == Op::Message) {
      WATERSKY_TRY(const Message m, detail::parse_message(c, offset));
      message(m);
    }
    return {};
  };
  scan.use = [&](std::uint8_t op, std::span<const std::uint8_t> c, std::uint64_t offset,
                 std::uint64_t record_bytes) {
    const auto told = [&](const Status& s) {
      if (!s) scan.damage.push_back(damage_at(offset, s.error()));
    };
    switch (static_cast<Op>(op)) {
      case Op::Header: {
        auto header = detail::parse_header(c, offset + kHeadBytes);
        if (!header) return told(header.error());
        header_ = std::move(*header);
        header_seen = true;
        return;
      }
      case Op::Chunk: {
        detail::Chunk chunk;
        const auto records = unpack(c, offset, options_.max_record_bytes, chunk);
        if (!records) return told(records.error());
        ChunkIndex index{chunk.first,
                         chunk.last,
                         offset,
                         record_bytes,
                         {},
                         0,
                         chunk.compression,
                         chunk.records.size(),
                         chunk.uncompressed_bytes};
        const auto cut =
            for_records(*records, [&](std::uint8_t o, std::span<const std::uint8_t> r,
                                      std::size_t) { told(definition(o, r, offset)); });
        if (cut) scan.damage.push_back({offset, *cut});
        chunks_.push_back(std::move(index));
        return;
      }
      case Op::Attachment: {
        // Only its fields are here: `c` is cut before the data when they are long.
        watersky::detail::Cursor a(c);
        AttachmentIndex x;
        x.offset = offset;
        x.record_bytes = record_bytes;
        x.log_time = detail::time_of(a.number<std::uint64_t>());
        x.create_time = detail::time_of(a.number<std::uint64_t>());
        x.name = a.text();
        x.media_type = a.text();
        x.data_bytes = a.number<std::uint64_t>();
        if (a.failed()) return told(bad_at(offset, "the attachment is cut short"));
        attachments_.push_back(std::move(x));
        return;
      }
      case Op::Metadata: {
        auto metadata = detail::parse_metadata(c, offset + kHeadBytes);
        if (!metadata) return told(metadata.error());
        metadata_.push_back({offset, record_bytes, metadata->name});
        return;
      }
      default: told(definition(op, c, offset));
    }
  };
  WATERSKY_CHECK(walk(scan));
  if (!header_seen && scan.damage.empty())
    scan.damage.push_back({kMagic.size(), "the file has no Header"});
  damage_.insert(damage_.end(), scan.damage.begin(), scan.damage.end());
  count.schemas = static_cast<std::uint16_t>(schemas_.size());
  count.channels = static_cast<std::uint32_t>(channels_.size());
  count.attachments = static_cast<std::uint32_t>(attachments_.size());
  count.metadata = static_cast<std::uint32_t>(metadata_.size());
  count.chunks = static_cast<std::uint32_t>(chunks_.size());
  statistics_ = std::move(count);
  return {};
}

Status Reader::walk(Scan& scan) const {
  constexpr std::uint64_t kAttachmentFieldsBytes = std::uint64_t{1} << 16;
  const std::uint64_t size = source_->size();
  Window window(*source_);
  std::uint32_t crc = 0;
  std::uint64_t summed_to = 0;
  // Long attachments are summed piece by piece and never held.
  const auto sum_to = [&](std::uint64_t to) -> Status {
    while (scan.check_crc && summed_to < to) {
      const auto n = std::min<std::uint64_t>(to - summed_to, Window::kBytes);
      WATERSKY_TRY(const auto bytes, window.get(summed_to, n));
      crc = crc32_of(bytes, crc);
      summed_to += n;
    }
    return {};
  };
  for (std::uint64_t at = kMagic.size(); at < size;) {
    if (size - at < kHeadBytes) {
      // A whole file ends with its magic, which stands behind the footer: that is reached there.
      scan.damage.push_back({at, "the file ends in the middle of a record"});
      return {};
    }
    WATERSKY_TRY(const auto head, window.get(at, kHeadBytes));
    const std::uint8_t op = head[0];
    const auto length = number_at<std::uint64_t>(head, 1);
    if (length > size - at - kHeadBytes) {
      scan.damage.push_back({at, "the file ends in the middle of a " + detail::name_of(op) +
                                     " of " + std::to_string(length) + " bytes"});
      return {};
    }
    const std::uint64_t record_bytes = kHeadBytes + length;
    if (static_cast<Op>(op) == Op::DataEnd) {
      WATERSKY_CHECK(sum_to(at));
      WATERSKY_TRY(const auto content,
                   window.get(at + kHeadBytes, std::min<std::uint64_t>(4, length)));
      const std::uint32_t told = content.size() == 4 ? number_at<std::uint32_t>(content, 0) : 0;
      if (scan.check_crc && told != 0 && told != crc)
        scan.damage.push_back({at, "the CRC over all data is wrong"});
      return {};
    }
    if (static_cast<Op>(op) == Op::Footer || op == 0) {
      if (op == 0) scan.damage.push_back({at, "is no record"});
      return {};
    }
    if (static_cast<Op>(op) == Op::Attachment) {
      WATERSKY_TRY(const auto content,
                   window.get(at + kHeadBytes, std::min(length, kAttachmentFieldsBytes)));
      scan.use(op, content, at, record_bytes);
    } else if (length > options_.max_record_bytes) {
      scan.damage.push_back({at, "a " + detail::name_of(op) + " of " + std::to_string(length) +
                                     " bytes is larger than the " +
                                     std::to_string(options_.max_record_bytes) + " allowed"});
    } else {
      WATERSKY_CHECK(sum_to(at));
      WATERSKY_TRY(const auto record, window.get(at, record_bytes));
      scan.use(op, record.subspan(kHeadBytes), at, record_bytes);
      if (scan.check_crc) crc = crc32_of(record, crc);
      summed_to = at + record_bytes;
    }
    at += record_bytes;
    WATERSKY_CHECK(sum_to(at));
  }
  return {};
}

Result<std::vector<Damage>> Reader::for_each(const Use& use, const Selection& selection) const {
  std::vector<Damage> damage;
  std::set<std::uint16_t> unknown;
  const auto message = [&](std::span<const std::uint8_t> c, const Location& where) {
    const auto m = detail::parse_message(c, where.record);
    if (!m) {
      damage.push_back(damage_at(where.record, m.error()));
    } else if (!channels_.contains(m->channel)) {
      if (unknown.insert(m->channel).second)
        damage.push_back({where.record, "messages of channel " + std::to_string(m->channel) +
                                            ", which is nowhere described"});
    } else if (wanted(*m, selection)) {
      use(*m, where);
    }
  };
  const auto is_message = [](std::uint8_t op) { return static_cast<Op>(op) == Op::Message; };
  const auto chunk = [&](std::span<const std::uint8_t> records, std::uint64_t offset) {
    const auto cut =
        for_records(records, [&](std::uint8_t op, std::span<const std::uint8_t> c, std::size_t at) {
          if (is_message(op)) message(c, {offset, at});
        });
    if (cut) damage.push_back({offset, *cut});
  };
  if (indexed_ && !chunks_.empty()) {
    for (const ChunkIndex& index : chunks_) {
      if (!may_hold(index, selection)) continue;
      const auto records = unpacked_chunk(index.offset, index.record_bytes);
      if (records)
        chunk(*records, index.offset);
      else if (records.error().code == ErrorCode::Io)
        return records.error();
      else
        damage.push_back(damage_at(index.offset, records.error()));
    }
    return damage;
  }
  Scan scan;
  scan.use = [&](std::uint8_t op, std::span<const std::uint8_t> c, std::uint64_t offset,
                 std::uint64_t) {
    if (is_message(op)) return message(c, {offset, Location::kNoChunk});
    if (static_cast<Op>(op) != Op::Chunk) return;
    detail::Chunk fields;
    const auto records = unpack(c, offset, options_.max_record_bytes, fields);
    if (records)
      chunk(*records, offset);
    else
      damage.push_back(damage_at(offset, records.error()));
  };
  WATERSKY_CHECK(walk(scan));
  damage.insert(damage.end(), scan.damage.begin(), scan.damage.end());
  return damage;
}

Result<Bytes> Reader::content(std::uint64_t offset, std::uint8_t op, std::uint64_t bytes) const {
  std::array<std::uint8_t, kHeadBytes> head{};
  if (offset > source_->size() || source_->size() - offset < kHeadBytes)
    return bad_at(offset,
                  "a " + detail::name_of(op) + " should be here, behind the end of the file");
  WATERSKY_CHECK(source_->read(offset, head));
  const auto length = number_at<std::uint64_t>(head, 1);
  if (head[0] != op || (bytes != 0 && bytes != kHeadBytes + length))
    return bad_at(offset, "a " + detail::name_of(op) + " should be here and is not");
  if (length > source_->size() - offset - kHeadBytes || length > options_.max_record_bytes)
    return bad_at(offset, "a " + detail::name_of(op) + " claims " + std::to_string(length) +
                              " bytes, more than there are or are allowed");
  Bytes out(static_cast<std::size_t>(length));
  WATERSKY_CHECK(source_->read(offset + kHeadBytes, out));
  return out;
}

Result<Bytes> Reader::unpacked_chunk(std::uint64_t offset, std::uint64_t bytes) const {
  WATERSKY_TRY(const Bytes packed, content(offset, static_cast<std::uint8_t>(Op::Chunk), bytes));
  detail::Chunk fields;
  return unpack(packed, offset, options_.max_record_bytes, fields);
}

Result<Bytes> Reader::read(const Location& location) const {
  if (location.in_chunk == Location::kNoChunk) {
    WATERSKY_TRY(const Bytes c,
                 content(location.record, static_cast<std::uint8_t>(Op::Message), 0));
    WATERSKY_TRY(const Message m, detail::parse_message(c, location.record));
    return Bytes(m.data.begin(), m.data.end());
  }
  WATERSKY_TRY(const auto chunk,
               cache_->get(location.record, [&] { return unpacked_chunk(location.record, 0); }));
  if (location.in_chunk < chunk->size()) {
    const std::span<const std::uint8_t> records(*chunk);
    watersky::detail::Cursor c(records.subspan(static_cast<std::size_t>(location.in_chunk)));
    const auto op = c.number<std::uint8_t>();
    const auto body = c.bytes(c.number<std::uint64_t>());
    if (!c.failed() && static_cast<Op>(op) == Op::Message) {
      WATERSKY_TRY(const Message m, detail::parse_message(body, location.record));
      return Bytes(m.data.begin(), m.data.end());
    }
  }
  return bad_at(location.record,
                "at byte " + std::to_string(location.in_chunk) + " of the chunk is no message");
}

Result<Attachment> Reader::read(const AttachmentIndex& index) const {
  WATERSKY_TRY(const Bytes c, content(index.offset, static_cast<std::uint8_t>(Op::Attachment),
                                      index.record_bytes));
  return detail::parse_attachment(c, index.offset + kHeadBytes);
}

Result<Metadata> Reader::read(const MetadataIndex& index) const {
  WATERSKY_TRY(const Bytes c,
               content(index.offset, static_cast<std::uint8_t>(Op::Metadata), index.record_bytes));
  return detail::parse_metadata(c, index.offset + kHeadBytes);
}

}  // namespace watersky::mcap
