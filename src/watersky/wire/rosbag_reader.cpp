// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "watersky/wire/detail/damage.hpp"
#include "watersky/wire/detail/record_cache.hpp"
#include "watersky/wire/detail/rosbag_records.hpp"
#include "watersky/wire/detail/window.hpp"
#include "watersky/wire/rosbag.hpp"

namespace watersky::rosbag {

using detail::Fields;
using detail::Op;
using watersky::detail::bad_at;
using watersky::detail::Cursor;
using watersky::detail::damage_at;
using watersky::detail::Window;

struct Reader::Cache : watersky::detail::ChunkCache {};

struct Reader::Record {
  std::uint64_t offset = 0;  ///< in the file or the chunk
  std::uint8_t op = 0;
  Fields fields;
  std::span<const std::uint8_t> data;
  std::uint64_t bytes = 0;  ///< all of it

  [[nodiscard]] bool is(Op kind) const { return op == static_cast<std::uint8_t>(kind); }

  /// The record at the beginning of `bytes`; `offset` of it for errors.
  static Result<Record> parse(std::span<const std::uint8_t> bytes, std::uint64_t offset) {
    Cursor c(bytes, offset);
    const auto header = c.sized();
    Record out;
    out.data = c.sized();
    WATERSKY_CHECK(c.check("a record"));
    WATERSKY_TRY(out.fields, Fields::parse(header, offset + 4));
    const auto op = out.fields.number<std::uint8_t>("op");
    if (!op) return bad_at(offset, "is no record of a bag (it says not of what kind)");
    out.offset = offset;
    out.op = *op;
    out.bytes = c.at();
    return out;
  }

  /// nullopt when a field is missing.
  [[nodiscard]] std::optional<Message> message() const {
    const auto connection = fields.number<std::uint32_t>("conn");
    const auto time = fields.time("time");
    if (!is(Op::Message) || !connection || !time) return std::nullopt;
    return Message{*connection, *time, data};
  }
};

Reader::Reader(std::shared_ptr<const ByteSource> source, const ReaderOptions& options)
    : source_(std::move(source)), options_(options), cache_(std::make_shared<Cache>()) {}

Result<Reader> Reader::open(std::shared_ptr<const ByteSource> source,
                            const ReaderOptions& options) {
  Reader reader(std::move(source), options);
  const ByteSource& s = *reader.source_;
  Bytes magic(detail::kMagic.size());
  if (s.size() < magic.size()) return bad_at(0, "is no bag (it is too short)");
  WATERSKY_CHECK(s.read(0, magic));
  if (!std::equal(magic.begin(), magic.end(), detail::kMagic.begin()))
    return bad_at(0, "is no bag of version 2.0 (it does not begin as one)");
  const std::uint64_t at = magic.size();
  std::uint64_t index_offset = 0;
  if (const auto record = reader.record_at(at)) {
    const auto header = Record::parse(*record, at);
    if (!header) return header.error();
    if (!header->is(Op::FileHeader)) return bad_at(at, "the bag's file header should be here");
    if (!header->fields.text("encryptor").empty())
      return Error{ErrorCode::Unsupported,
                   "byte " + std::to_string(at) + ": the bag is encrypted by " +
                       header->fields.text("encryptor") + "; decrypt it with rosbag decrypt"};
    index_offset = header->fields.number<std::uint64_t>("index_pos").value_or(0);
  } else {
    return record.error();
  }
  if (index_offset != 0) {
    WATERSKY_TRY(reader.indexed_, reader.read_index(index_offset));
  } else {
    reader.damage_.push_back({at, "the bag has no index: its recorder did not close it"});
  }
  if (!reader.indexed_) WATERSKY_CHECK(reader.scan());
  return reader;
}

void Reader::add_connection(const Record& record) {
  const auto id = record.fields.number<std::uint32_t>("conn");
  const auto told = Fields::parse(record.data, record.offset);
  if (!id || !told) {
    damage_.push_back({record.offset, "a connection's record is damaged"});
    return;
  }
  Connection c;
  c.id = *id;
  // The record's own topic is the one recorded; the other may be from before a remapping.
  c.topic = record.fields.text("topic");
  c.type = told->text("type");
  c.md5sum = told->text("md5sum");
  c.definition = told->text("message_definition");
  c.caller = told->text("callerid");
  c.latching = told->text("latching") == "1";
  connections_.emplace(*id, std::move(c));
}

Result<bool> Reader::read_index(std::uint64_t index_offset) {
  const auto no = [&](std::uint64_t offset, const std::string& why) {
    damage_.push_back({offset, why});
    connections_.clear();
    chunks_.clear();
    counts_.clear();
    return false;
  };
  if (index_offset >= source_->size())
    return no(source_->size(),
              "the file ends before its index at byte " + std::to_string(index_offset));
  std::vector<Damage> damage;
  bool whole = true;
  WATERSKY_CHECK(walk(
      index_offset,
      [&](const Record& r) {
        if (r.is(Op::Connection)) {
          add_connection(r);
        } else if (r.is(Op::ChunkInfo)) {
          Chunk chunk;
          const auto offset = r.fields.number<std::uint64_t>("chunk_pos");
          const auto first = r.fields.time("start_time"), last = r.fields.time("end_time");
          whole = whole && offset && first && last && r.data.size() % 8 == 0;
          if (!whole) return false;
          chunk.offset = *offset;
          chunk.first = *first;
          chunk.last = *last;
          for (std::size_t i = 0; i < r.data.size(); i += 8) {
            const auto id = number_at<std::uint32_t>(r.data, i);
            chunk.messages[id] = number_at<std::uint32_t>(r.data, i + 4);
            counts_[id] += chunk.messages[id];
          }
          chunks_.push_back(std::move(chunk));
        } else {
          whole = false;
        }
        return whole;
      },
      damage));
  if (!whole || !damage.empty())
    return no(damage.empty() ? index_offset : damage.front().offset,
              damage.empty() ? "the index is damaged" : "in the index, " + damage.front().reason);
  std::sort(chunks_.begin(), chunks_.end(),
            [](const Chunk& a, const Chunk& b) { return a.offset < b.offset; });
  return true;
}

Status Reader::walk(std::uint64_t from, const std::function<bool(const Record&)>& use,
                    std::vector<Damage>& damage) const {
  const std::uint64_t size = source_->size();
  Window window(*source_);
  for (std::uint64_t at = from; at < size;) {
    const auto cut = [&](std::uint64_t length) {
      damage.push_back(
          {at, "the file ends in the middle of a record of " + std::to_string(length) + " bytes"});
      return Status{};
    };
    if (size - at < 8) return cut(8);
    WATERSKY_TRY(const auto head, window.get(at, 4));
    const std::uint64_t header_bytes = number_at<std::uint32_t>(head, 0);
    if (header_bytes + 8 > size - at) return cut(header_bytes + 8);
    WATERSKY_TRY(const auto middle, window.get(at + 4 + header_bytes, 4));
    const std::uint64_t bytes = 8 + header_bytes + number_at<std::uint32_t>(middle, 0);
    if (bytes > size - at) return cut(bytes);
    if (bytes > options_.max_record_bytes) {
      damage.push_back({at, "a record of " + std::to_string(bytes) + " bytes is larger than the " +
                                std::to_string(options_.max_record_bytes) + " allowed"});
    } else {
      WATERSKY_TRY(const auto record_bytes, window.get(at, bytes));
      const auto record = Record::parse(record_bytes, at);
      if (!record) {
        // Lengths that lead nowhere: nothing behind them can be trusted.
        damage.push_back(damage_at(at, record.error()));
        return {};
      }
      if (!use(*record)) return {};
    }
    at += bytes;
  }
  return {};
}

Result<Bytes> Reader::record_at(std::uint64_t offset) const {
  const std::uint64_t size = source_->size();
  std::array<std::uint8_t, 4> length{};
  const auto cut = [&] { return bad_at(offset, "the file ends in the middle of a record"); };
  if (offset > size || size - offset < 8) return cut();
  WATERSKY_CHECK(source_->read(offset, length));
  const std::uint64_t header_bytes = number_at<std::uint32_t>(length, 0);
  if (header_bytes + 8 > size - offset) return cut();
  WATERSKY_CHECK(source_->read(offset + 4 + header_bytes, length));
  const std::uint64_t bytes = 8 + header_bytes + number_at<std::uint32_t>(length, 0);
  if (bytes > size - offset) return cut();
  if (bytes > options_.max_record_bytes)
    return bad_at(offset, "a record of " + std::to_string(bytes) + " bytes is larger than the " +
                              std::to_string(options_.max_record_bytes) + " allowed");
  Bytes out(static_cast<std::size_t>(bytes));
  WATERSKY_CHECK(source_->read(offset, out));
  return out;
}

Result<Bytes> Reader::unpacked(const Record& chunk) const {
  const std::string name = chunk.fields.text("compression");
  const auto size = chunk.fields.number<std::uint32_t>("size");
  if (!size) return bad_at(chunk.offset, "the chunk does not say its size");
  if (*size > options_.max_record_bytes)
    return bad_at(chunk.offset, "the chunk claims " + std::to_string(*size) +
                                    " bytes, more than the " +
                                    std::to_string(options_.max_record_bytes) + " allowed");
  for (const Compression c : {Compression::None, Compression::Lz4, Compression::Bz2})
    if (name == to_string(c)) {
      auto records = decompress(c, chunk.data, *size);
      if (!records) return bad_at(chunk.offset, "the chunk " + records.error().message);
      return records;
    }
  return Error{ErrorCode::Unsupported, "byte " + std::to_string(chunk.offset) +
                                           ": the chunk is compressed by \"" + name +
                                           "\"; none, lz4 and bz2 are read"};
}

namespace {

/// Calls `each(record, offset in the chunk)`; what does not fit is told and ends it.
template <class Record, class Each>
std::optional<std::string> for_records(std::span<const std::uint8_t> records, Each&& each) {
  for (std::size_t at = 0; at < records.size();) {
    const auto record = Record::parse(records.subspan(at), at);
    if (!record) return "in the chunk, " + record.error().message;
    each(*record, at);
    at += static_cast<std::size_t>(record->bytes);
  }
  return std::nullopt;
}

}  // namespace

Status Reader::scan() {
  const auto count = [&](const Record& r, Chunk* chunk) {
    if (r.is(Op::Connection)) return add_connection(r);
    const auto m = r.message();
    if (!m) return;
    ++counts_[m->connection];
    if (!chunk) return;
    const bool first = chunk->messages.empty();
    chunk->first = first ? m->time : std::min(chunk->first, m->time);
    chunk->last = first ? m->time : std::max(chunk->last, m->time);
    ++chunk->messages[m->connection];
  };
  return walk(
      detail::kMagic.size(),
      [&](const Record& r) {
        // A recorder that crashed leaves its last chunk as an empty one with the records behind it.
        if (!r.is(Op::Chunk)) {
          count(r, nullptr);
          return true;
        }
        const auto records = unpacked(r);
        if (!records) {
          damage_.push_back(damage_at(r.offset, records.error()));
          return true;
        }
        Chunk chunk;
        chunk.offset = r.offset;
        const auto cut = for_records<Record>(
            *records, [&](const Record& inner, std::size_t) { count(inner, &chunk); });
        if (cut) damage_.push_back({r.offset, *cut});
        chunks_.push_back(std::move(chunk));
        return true;
      },
      damage_);
}

Result<std::vector<Damage>> Reader::for_each(
    const Use& use, const std::optional<std::set<std::uint32_t>>& connections) const {
  std::vector<Damage> damage;
  std::set<std::uint32_t> unknown;
  const auto message = [&](const Record& r, const Location& where) {
    if (!r.is(Op::Message)) return;
    const auto m = r.message();
    if (!m) {
      damage.push_back({where.record, "a message's record lacks its connection or time"});
    } else if (!connections_.contains(m->connection)) {
      if (unknown.insert(m->connection).second)
        damage.push_back({where.record, "messages of connection " + std::to_string(m->connection) +
                                            ", which is nowhere described"});
    } else if (!connections || connections->contains(m->connection)) {
      use(*m, where);
    }
  };
  const auto chunk = [&](const Record& r) {
    const auto records = unpacked(r);
    if (!records) {
      damage.push_back(damage_at(r.offset, records.error()));
      return;
    }
    const auto cut = for_records<Record>(*records, [&](const Record& inner, std::size_t at) {
      message(inner, {r.offset, at});
    });
    if (cut) damage.push_back({r.offset, *cut});
  };
  if (!indexed_) {
    WATERSKY_CHECK(walk(
        detail::kMagic.size(),
        [&](const Record& r) {
          if (r.is(Op::Chunk))
            chunk(r);
          else
            message(r, {r.offset, Location::kNoChunk});
          return true;
        },
        damage));
    return damage;
  }
  for (const Chunk& info : chunks_) {
    if (connections && std::none_of(connections->begin(), connections->end(),
                                    [&](std::uint32_t id) { return info.messages.contains(id); }))
      continue;
    const auto bytes = record_at(info.offset);
    if (!bytes && bytes.error().code == ErrorCode::Io) return bytes.error();
    const auto record = bytes ? Record::parse(*bytes, info.offset) : Result<Record>(bytes.error());
    if (!record)
      damage.push_back(damage_at(info.offset, record.error()));
    else if (!record->is(Op::Chunk))
      damage.push_back({info.offset, "a chunk should be here and is not"});
    else
      chunk(*record);
  }
  return damage;
}

Result<Bytes> Reader::read(const Location& location) const {
  const auto data_of = [&](std::span<const std::uint8_t> bytes) -> Result<Bytes> {
    WATERSKY_TRY(const Record r, Record::parse(bytes, location.record));
    if (!r.is(Op::Message)) return bad_at(location.record, "is no message");
    return Bytes(r.data.begin(), r.data.end());
  };
  if (location.in_chunk == Location::kNoChunk) {
    WATERSKY_TRY(const Bytes bytes, record_at(location.record));
    return data_of(bytes);
  }
  WATERSKY_TRY(const auto chunk, cache_->get(location.record, [&]() -> Result<Bytes> {
    WATERSKY_TRY(const Bytes bytes, record_at(location.record));
    WATERSKY_TRY(const Record r, Record::parse(bytes, location.record));
    if (!r.is(Op::Chunk)) return bad_at(location.record, "a chunk should be here and is not");
    return unpacked(r);
  }));
  if (location.in_chunk >= chunk->size())
    return bad_at(location.record,
                  "at byte " + std::to_string(location.in_chunk) + " of the chunk is no message");
  const std::span<const std::uint8_t> records(*chunk);
  return data_of(records.subspan(static_cast<std::size_t>(location.in_chunk)));
}

}  // namespace watersky::rosbag
