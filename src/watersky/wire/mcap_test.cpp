// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <random>

#include "support/temporary_folder.hpp"
#include "watersky/wire/mcap_reader.hpp"
#include "watersky/wire/mcap_writer.hpp"

namespace watersky::mcap {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

std::shared_ptr<const ByteSource> source_of(Bytes bytes) {
  return std::make_shared<MemorySource>(std::move(bytes));
}

ByteSink into(Bytes& file) {
  return [&file](std::span<const std::uint8_t> bytes) {
    file.insert(file.end(), bytes.begin(), bytes.end());
    return Status();
  };
}

Time at_ms(std::int64_t ms) { return Time(std::chrono::milliseconds(ms)); }

struct Seen {
  std::uint16_t channel;
  std::uint32_t sequence;
  Time log_time, publish_time;
  Bytes data;
  friend bool operator==(const Seen&, const Seen&) = default;
};

struct Contents {
  std::vector<Seen> messages;
  std::vector<Location> places;
  std::vector<Damage> damage;
};

Contents contents(const Reader& reader, const Selection& selection = {}) {
  Contents out;
  const auto damage = reader.for_each(
      [&](const Message& m, const Location& where) {
        out.messages.push_back({m.channel, m.sequence, m.log_time, m.publish_time,
                                Bytes(m.data.begin(), m.data.end())});
        out.places.push_back(where);
      },
      selection);
  EXPECT_TRUE(damage) << damage.error().message;
  if (damage) out.damage = *damage;
  return out;
}

struct Recorded {
  Bytes file;
  std::size_t open_bytes = 0;  ///< of the file before close()
  std::vector<Seen> messages;
};

/// Two channels, 200 messages, an attachment and metadata.
Recorded record(Compression compression, std::size_t chunk_bytes = 4000) {
  Recorded out;
  auto writer = *Writer::open(
      into(out.file),
      {.profile = "", .library = "test", .compression = compression, .chunk_bytes = chunk_bytes});
  const auto schema =
      writer.add_schema({.id = 0, .name = "S", .encoding = "jsonschema", .data = {1}});
  const auto a = writer.add_channel({.id = 0,
                                     .schema = *schema,
                                     .topic = "/a",
                                     .message_encoding = "json",
                                     .metadata = {{"k", "v"}}});
  const auto b = writer.add_channel(
      {.id = 0, .schema = 0, .topic = "/b", .message_encoding = "x", .metadata = {}});
  EXPECT_TRUE(writer.attach({"note.txt", "text/plain", at_ms(5), at_ms(4), {'h', 'i'}}));
  std::mt19937 random(1);
  for (std::uint32_t i = 0; i < 200; ++i) {
    Seen m{i % 3 == 0 ? *b : *a, i, at_ms(1000 + i * 10), at_ms(990 + i * 10), {}};
    m.data.resize(random() % 150);
    for (auto& x : m.data) x = static_cast<std::uint8_t>(random() % 7);
    EXPECT_TRUE(writer.write({m.channel, m.sequence, m.log_time, m.publish_time, m.data}));
    out.messages.push_back(std::move(m));
  }
  EXPECT_TRUE(writer.add_metadata({"m", {{"one", "1"}, {"two", "2"}}}));
  EXPECT_TRUE(writer.flush());
  out.open_bytes = out.file.size();
  EXPECT_TRUE(writer.close());
  return out;
}

constexpr Compression kCompressions[] = {Compression::None, Compression::Lz4, Compression::Zstd};

TEST(Mcap, WhatIsWrittenIsReadByTheSummaryAndWithoutIt) {
  for (const Compression c : kCompressions) {
    const Recorded recorded = record(c);
    for (const bool use_summary : {true, false}) {
      const auto reader = Reader::open(source_of(recorded.file), {.use_summary = use_summary});
      ASSERT_TRUE(reader) << reader.error().message;
      EXPECT_EQ(reader->indexed(), use_summary);
      EXPECT_TRUE(reader->damage().empty());
      EXPECT_EQ(reader->header().library, "test");
      const Contents found = contents(*reader);
      EXPECT_EQ(found.messages, recorded.messages);
      EXPECT_TRUE(found.damage.empty());
      EXPECT_EQ(reader->channels().at(1).topic, "/a");
      EXPECT_EQ(reader->channels().at(1).metadata.at("k"), "v");
      EXPECT_EQ(reader->schemas().at(1).data, Bytes{1});
      const Statistics& s = *reader->statistics();
      EXPECT_EQ(s.messages, 200u);
      EXPECT_EQ(s.channel_messages.at(2), 67u);
      EXPECT_EQ(s.first, at_ms(1000));
      EXPECT_EQ(s.last, at_ms(2990));
      EXPECT_GT(s.chunks, 2u);
      ASSERT_EQ(reader->attachments().size(), 1u);
      const auto attachment = reader->read(reader->attachments()[0]);
      ASSERT_TRUE(attachment) << attachment.error().message;
      EXPECT_EQ(attachment->data, (Bytes{'h', 'i'}));
      EXPECT_EQ(attachment->create_time, at_ms(4));
      ASSERT_EQ(reader->metadata().size(), 1u);
      EXPECT_EQ(*reader->read(reader->metadata()[0]),
                (Metadata{"m", {{"one", "1"}, {"two", "2"}}}));
    }
  }
}

TEST(Mcap, AMessageIsReadAgainFromItsPlaceInAnyOrder) {
  const Recorded recorded = record(Compression::Zstd);
  const auto reader = *Reader::open(source_of(recorded.file));
  const Contents found = contents(reader);
  for (std::size_t i = found.places.size(); i-- > 0;)
    EXPECT_EQ(*reader.read(found.places[i]), found.messages[i].data);
  EXPECT_FALSE(reader.read(Location{3, 0}));
  EXPECT_FALSE(reader.read(Location{found.places[0].record, 1}));
  EXPECT_FALSE(reader.read(Location{recorded.file.size() + 1, 0}));
}

TEST(Mcap, ASelectionReadsOnlyWhatItNames) {
  const Recorded recorded = record(Compression::Lz4);
  const auto reader = *Reader::open(source_of(recorded.file));
  const Contents some = contents(
      reader, {.channels = std::set<std::uint16_t>{2}, .first = at_ms(1500), .last = at_ms(1800)});
  std::vector<Seen> expected;
  for (const Seen& m : recorded.messages)
    if (m.channel == 2 && m.log_time >= at_ms(1500) && m.log_time <= at_ms(1800))
      expected.push_back(m);
  EXPECT_EQ(some.messages, expected);
}

TEST(Mcap, WhateverACrashLeavesIsReadUpToTheLastWholeChunk) {
  const Recorded recorded = record(Compression::Zstd);
  std::vector<std::uint64_t> ends;  // of the chunks
  {
    const auto whole = *Reader::open(source_of(recorded.file));
    for (const ChunkIndex& c : whole.chunks()) ends.push_back(c.offset + c.record_bytes);
  }
  const auto all = contents(*Reader::open(source_of(recorded.file)));
  for (std::size_t cut = 8; cut <= recorded.open_bytes; cut += cut % 97 + 1) {
    const auto reader =
        Reader::open(source_of(Bytes(recorded.file.begin(), recorded.file.begin() + cut)));
    ASSERT_TRUE(reader) << cut << ": " << reader.error().message;
    EXPECT_FALSE(reader->indexed());
    EXPECT_FALSE(reader->damage().empty());
    const Contents found = contents(*reader);
    std::size_t expected = 0;
    for (std::size_t i = 0; i < all.places.size(); ++i)
      for (std::size_t k = 0; k < ends.size(); ++k)
        if (ends[k] <= cut && all.places[i].record < ends[k] &&
            (k == 0 || all.places[i].record >= ends[k - 1]))
          ++expected;
    ASSERT_EQ(found.messages.size(), expected) << cut;
    EXPECT_TRUE(
        std::equal(found.messages.begin(), found.messages.end(), recorded.messages.begin()));
  }
}

TEST(Mcap, ADamagedChunkIsLeftOutAndToldWithItsByte) {
  Recorded recorded = record(Compression::None);
  const auto before = *Reader::open(source_of(recorded.file));
  const ChunkIndex second = before.chunks()[1];
  recorded.file[second.offset + 60] ^= 1;
  for (const bool use_summary : {true, false}) {
    const auto reader = *Reader::open(source_of(recorded.file), {.use_summary = use_summary});
    const Contents found = contents(reader);
    EXPECT_LT(found.messages.size(), 200u);
    EXPECT_GT(found.messages.size(), 100u);
    ASSERT_FALSE(found.damage.empty());
    EXPECT_EQ(found.damage[0].offset, second.offset);
    EXPECT_THAT(found.damage[0].reason, HasSubstr("CRC"));
    EXPECT_THAT(to_string(found.damage[0]), HasSubstr("byte " + std::to_string(second.offset)));
  }
}

TEST(Mcap, ADamagedSummaryIsToldAndTheFileReadWithoutIt) {
  Recorded recorded = record(Compression::Zstd);
  recorded.file[recorded.open_bytes + 40] ^= 4;
  const auto reader = Reader::open(source_of(recorded.file));
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->indexed());
  ASSERT_FALSE(reader->damage().empty());
  EXPECT_THAT(reader->damage()[0].reason, HasSubstr("summary"));
  EXPECT_EQ(contents(*reader).messages, recorded.messages);
}

TEST(Mcap, TheSumOverAllDataAndThatOfAnAttachmentAreChecked) {
  Recorded recorded = record(Compression::Zstd);
  const auto at = std::search(recorded.file.begin(), recorded.file.end(), std::begin("text/plain"),
                              std::end("text/plain") - 1);
  ASSERT_NE(at, recorded.file.end());
  *at = 'T';
  const auto reader = *Reader::open(source_of(recorded.file), {.use_summary = false});
  ASSERT_FALSE(reader.damage().empty());
  EXPECT_THAT(reader.damage().back().reason, HasSubstr("CRC over all data"));
  const auto attachment = reader.read(reader.attachments()[0]);
  ASSERT_FALSE(attachment);
  EXPECT_THAT(attachment.error().message, HasSubstr("CRC"));
}

TEST(Mcap, LengthsWithoutBoundAreErrorsThatNameTheByte) {
  const Recorded recorded = record(Compression::Zstd);
  const auto chunk = (*Reader::open(source_of(recorded.file))).chunks()[0];
  for (const std::uint64_t length :
       {std::uint64_t{1} << 32, ~std::uint64_t{0}, std::uint64_t{1} << 62}) {
    Bytes file = recorded.file;
    std::memcpy(file.data() + chunk.offset + 1, &length, 8);  // the record's
    const auto reader = Reader::open(source_of(file));
    ASSERT_TRUE(reader);
    const Contents found = contents(*reader);
    ASSERT_FALSE(found.damage.empty());
    EXPECT_EQ(found.damage[0].offset, chunk.offset);

    file = recorded.file;
    std::memcpy(file.data() + chunk.offset + 9 + 16, &length, 8);  // of what it unfolds to
    const auto reader2 = Reader::open(source_of(file));
    ASSERT_TRUE(reader2);
    EXPECT_FALSE(contents(*reader2).damage.empty());
  }
}

TEST(Mcap, WhatIsNoMcapSaysSo) {
  for (const Bytes& file : {Bytes{}, Bytes{1, 2, 3}, Bytes(100, 'x')}) {
    const auto reader = Reader::open(source_of(file));
    ASSERT_FALSE(reader);
    EXPECT_THAT(reader.error().message, HasSubstr("byte 0: is no MCAP file"));
  }
}

void put_u(Bytes& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}
void put_s(Bytes& out, const std::string& text) {
  put_u(out, text.size(), 4);
  out.insert(out.end(), text.begin(), text.end());
}
void put_record(Bytes& out, int op, const Bytes& content) {
  put_u(out, static_cast<std::uint64_t>(op), 1);
  put_u(out, content.size(), 8);
  out.insert(out.end(), content.begin(), content.end());
}

/// By hand from the specification: no chunk, no summary, a private record, trailing fields.
TEST(Mcap, MessagesOutsideOfChunksAndRecordsUnknownAreRead) {
  Bytes file = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
  Bytes c;
  put_s(c, "ros1");
  put_s(c, "hand");
  put_u(c, 0xABCD, 2);  // a field of a later version
  put_record(file, 1, c);
  c.clear();
  put_u(c, 7, 2);
  put_u(c, 0, 2);
  put_s(c, "/t");
  put_s(c, "ros1");
  put_u(c, 0, 4);
  put_record(file, 4, c);
  put_record(file, 0x90, Bytes(5, 1));
  c.clear();
  put_u(c, 7, 2);
  put_u(c, 1, 4);
  put_u(c, 1'000'000'000, 8);
  put_u(c, 2'000'000'000, 8);
  c.push_back(42);
  const std::size_t message_at = file.size();
  put_record(file, 5, c);
  put_record(file, 15, Bytes(4, 0));
  put_record(file, 2, Bytes(20, 0));
  file.insert(file.end(), {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'});

  const auto reader = Reader::open(source_of(file));
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_TRUE(reader->damage().empty());
  EXPECT_EQ(reader->header().profile, "ros1");
  const Contents found = contents(*reader);
  ASSERT_EQ(found.messages.size(), 1u);
  EXPECT_EQ(found.messages[0], (Seen{7, 1, at_ms(1000), at_ms(2000), {42}}));
  EXPECT_EQ(found.places[0].record, message_at);
  EXPECT_EQ(*reader->read(found.places[0]), Bytes{42});
}

TEST(McapWriter, EveryChunkIsInTheSinkWhenItIsFull) {
  Bytes file;
  auto writer = *Writer::open(
      into(file),
      {.profile = "", .library = "", .compression = Compression::None, .chunk_bytes = 1000});
  const auto channel = *writer.add_channel(
      {.id = 0, .schema = 0, .topic = "t", .message_encoding = "x", .metadata = {}});
  const Bytes data(300, 1);
  std::size_t written = 0;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(writer.write({channel, 0, at_ms(i), at_ms(i), data}));
    ++written;
    EXPECT_EQ(writer.bytes_sent(), file.size());
    const auto reader = Reader::open(source_of(file));
    const std::size_t there = contents(*reader).messages.size();
    EXPECT_LE(written - there, 3u);
  }
  EXPECT_EQ(writer.write({9, 0, at_ms(0), at_ms(0), data}).error().code, ErrorCode::NotFound);
  ASSERT_TRUE(writer.close());
  EXPECT_EQ(writer.write({channel, 0, at_ms(0), at_ms(0), data}).error().code, ErrorCode::Usage);
}

/// Writes to `file` until it is killed, and tells through `pipe` how many messages are in chunks
/// that were sent.
[[noreturn]] void record_forever(int file, int pipe) {
  auto writer = *Writer::open(
      [&](std::span<const std::uint8_t> bytes) -> Status {
        if (::write(file, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
          ::_exit(1);
        return {};
      },
      {.profile = "", .library = "", .compression = Compression::Zstd, .chunk_bytes = 2000});
  const auto channel = *writer.add_channel({0, 0, "t", "x", {}});
  const Bytes data(100, 7);
  for (std::uint32_t i = 0;; ++i) {
    const std::uint64_t before = writer.bytes_sent();
    if (!writer.write({channel, i, at_ms(i), at_ms(i), data})) ::_exit(1);
    if (writer.bytes_sent() != before && ::write(pipe, &i, sizeof i) != sizeof i) ::_exit(1);
  }
}

TEST(McapWriter, AProcessThatIsKilledLeavesEveryChunkThatItSent) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "killed.mcap";
  const int file = ::open(path.c_str(), O_CREAT | O_WRONLY, 0600);
  int pipe[2];
  ASSERT_EQ(::pipe(pipe), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(pipe[0]);
    record_forever(file, pipe[1]);
  }
  ::close(pipe[1]);
  std::uint32_t told = 0, sent = 0;
  while (::read(pipe[0], &told, sizeof told) == sizeof told) {
    if (told > 3000 && sent <= 3000) ::kill(child, SIGKILL);
    sent = told;
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status));
  ::close(pipe[0]);
  ::close(file);
  ASSERT_GT(sent, 3000u);

  std::ifstream in(path, std::ios::binary);
  const auto reader = Reader::open(
      source_of(Bytes(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>())));
  ASSERT_TRUE(reader) << reader.error().message;
  const Contents found = contents(*reader);
  ASSERT_GE(found.messages.size(), sent);
  for (std::size_t i = 0; i < found.messages.size(); ++i) ASSERT_EQ(found.messages[i].sequence, i);
}

TEST(McapWriter, AfterTheSinkFailedNothingMoreIsSent) {
  int calls = 0;
  auto writer = *Writer::open(
      [&](std::span<const std::uint8_t>) -> Status {
        if (++calls > 1) return Error{ErrorCode::Io, "disk full"};
        return {};
      },
      {});
  const auto channel = *writer.add_channel(
      {.id = 0, .schema = 0, .topic = "t", .message_encoding = "x", .metadata = {}});
  ASSERT_TRUE(writer.write({channel, 0, at_ms(0), at_ms(0), {}}));
  EXPECT_FALSE(writer.flush());
  EXPECT_EQ(writer.write({channel, 0, at_ms(0), at_ms(0), {}}).error().message, "disk full");
  EXPECT_FALSE(writer.close());
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace watersky::mcap
