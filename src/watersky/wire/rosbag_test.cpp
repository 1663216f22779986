// SPDX-License-Identifier: MIT
#include "watersky/wire/rosbag.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <random>

namespace watersky::rosbag {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

std::shared_ptr<const ByteSource> source_of(Bytes bytes) {
  return std::make_shared<MemorySource>(std::move(bytes));
}

Time at_ms(std::int64_t ms) { return Time(std::chrono::milliseconds(ms)); }

struct Seen {
  std::uint32_t connection;
  Time time;
  Bytes data;
  friend bool operator==(const Seen&, const Seen&) = default;
};

struct Contents {
  std::vector<Seen> messages;
  std::vector<Location> places;
  std::vector<Damage> damage;
};

Contents contents(const Reader& reader,
                  const std::optional<std::set<std::uint32_t>>& connections = std::nullopt) {
  Contents out;
  const auto damage = reader.for_each(
      [&](const Message& m, const Location& where) {
        out.messages.push_back({m.connection, m.time, Bytes(m.data.begin(), m.data.end())});
        out.places.push_back(where);
      },
      connections);
  EXPECT_TRUE(damage) << damage.error().message;
  if (damage) out.damage = *damage;
  return out;
}

struct Recorded {
  Bytes file;              ///< closed
  std::size_t open_bytes;  ///< before its index
  std::vector<Seen> messages;
};

Recorded record(Compression compression) {
  Recorded out;
  auto writer = *Writer::open(
      [&](std::span<const std::uint8_t> bytes) {
        out.file.insert(out.file.end(), bytes.begin(), bytes.end());
        return Status();
      },
      {.compression = compression, .chunk_bytes = 4000});
  const auto a =
      *writer.add_connection({0, "/a", "std_msgs/String", "abc", "string data\n", "/node", true});
  const auto b =
      *writer.add_connection({0, "/b", "std_msgs/Int8", "def", "int8 data\n", "", false});
  std::mt19937 random(2);
  for (int i = 0; i < 150; ++i) {
    Seen m{i % 4 == 0 ? b : a, at_ms(5000 + 3 * i), {}};
    m.data.resize(random() % 200);
    for (auto& x : m.data) x = static_cast<std::uint8_t>(random() % 5);
    EXPECT_TRUE(writer.write({m.connection, m.time, m.data}));
    out.messages.push_back(std::move(m));
  }
  EXPECT_TRUE(writer.flush());
  out.open_bytes = out.file.size();
  const auto beginning = writer.close();
  EXPECT_TRUE(beginning);
  std::copy(beginning->begin(), beginning->end(), out.file.begin());
  return out;
}

constexpr Compression kCompressions[] = {Compression::None, Compression::Lz4, Compression::Bz2};

TEST(Rosbag, WhatIsWrittenIsReadByTheIndexAndWithoutIt) {
  for (const Compression c : kCompressions) {
    const Recorded recorded = record(c);
    Bytes unindexed = recorded.file;
    const auto at = std::search(unindexed.begin(), unindexed.end(), std::begin("index_pos="),
                                std::end("index_pos=") - 1);
    std::memset(&*at + 10, 0, 8);
    for (const Bytes& file : {recorded.file, unindexed}) {
      const auto reader = Reader::open(source_of(file));
      ASSERT_TRUE(reader) << reader.error().message;
      EXPECT_EQ(reader->indexed(), &file != &unindexed && file == recorded.file);
      const Contents found = contents(*reader);
      EXPECT_EQ(found.messages, recorded.messages);
      EXPECT_TRUE(found.damage.empty());
      const Connection& a = reader->connections().at(0);
      EXPECT_EQ(a.topic, "/a");
      EXPECT_EQ(a.type, "std_msgs/String");
      EXPECT_EQ(a.md5sum, "abc");
      EXPECT_EQ(a.definition, "string data\n");
      EXPECT_EQ(a.caller, "/node");
      EXPECT_TRUE(a.latching);
      EXPECT_FALSE(reader->connections().at(1).latching);
      EXPECT_EQ(reader->counts().at(1), 38u);
      EXPECT_GT(reader->chunks().size(), 2u);
      EXPECT_EQ(reader->chunks().front().first, at_ms(5000));
      EXPECT_EQ(reader->chunks().back().last, at_ms(5000 + 3 * 149));
      for (std::size_t i = found.places.size(); i-- > 0;)
        EXPECT_EQ(*reader->read(found.places[i]), found.messages[i].data);
      EXPECT_EQ(contents(*reader, std::set<std::uint32_t>{1}).messages.size(), 38u);
    }
  }
}

TEST(Rosbag, CutAnywhereItIsReadUpToTheLastWholeChunk) {
  for (const Compression c : kCompressions) {
    const Recorded recorded = record(c);
    const auto whole = *Reader::open(source_of(recorded.file));
    const Contents all = contents(whole);
    for (std::size_t cut = 4109; cut < recorded.file.size(); cut += cut % 89 + 1) {
      const auto reader =
          Reader::open(source_of(Bytes(recorded.file.begin(), recorded.file.begin() + cut)));
      ASSERT_TRUE(reader) << cut << ": " << reader.error().message;
      EXPECT_FALSE(reader->damage().empty() && reader->indexed() && cut < recorded.open_bytes);
      const Contents found = contents(*reader);
      ASSERT_LE(found.messages.size(), recorded.messages.size());
      EXPECT_TRUE(
          std::equal(found.messages.begin(), found.messages.end(), recorded.messages.begin()));
      std::size_t least = 0;  // those of chunks with another chunk whole before the cut
      for (std::size_t i = 0; i < all.places.size(); ++i)
        for (const Chunk& later : whole.chunks())
          if (later.offset > all.places[i].record && later.offset <= cut) {
            ++least;
            break;
          }
      EXPECT_GE(found.messages.size(), least) << cut;
    }
  }
}

/// What roscpp's recorder leaves: the last chunk's head still says that it is empty, and its
/// records follow bare.
TEST(Rosbag, TheChunkThatARecorderWasWritingIsReadRecordByRecord) {
  Recorded recorded = record(Compression::None);
  const auto whole = *Reader::open(source_of(recorded.file));
  const std::uint64_t last = whole.chunks().back().offset;
  Bytes file(recorded.file.begin(),
             recorded.file.begin() + static_cast<std::ptrdiff_t>(recorded.open_bytes));
  const auto at =
      std::search(file.begin(), file.end(), std::begin("index_pos="), std::end("index_pos=") - 1);
  std::memset(&*at + 10, 0, 8);
  std::uint32_t header = 0;
  std::memcpy(&header, file.data() + last, 4);
  std::memset(file.data() + last + 4 + header, 0, 4);  // the chunk's length
  const auto size = std::search(file.begin() + static_cast<std::ptrdiff_t>(last), file.end(),
                                std::begin("size="), std::end("size=") - 1);
  std::memset(&*size + 5, 0, 4);
  const auto reader = Reader::open(source_of(file));
  ASSERT_TRUE(reader);
  EXPECT_EQ(contents(*reader).messages, recorded.messages);
}

TEST(Rosbag, ADamagedChunkIsLeftOutAndToldWithItsByte) {
  Recorded recorded = record(Compression::Lz4);
  const std::uint64_t second = (*Reader::open(source_of(recorded.file))).chunks()[1].offset;
  std::memset(recorded.file.data() + second + 100, 0xFF, 200);
  const auto reader = *Reader::open(source_of(recorded.file));
  const Contents found = contents(reader);
  EXPECT_GT(found.messages.size(), 80u);
  EXPECT_LT(found.messages.size(), 150u);
  ASSERT_EQ(found.damage.size(), 1u);
  EXPECT_EQ(found.damage[0].offset, second);
}

TEST(Rosbag, LengthsOfFourGigabytesAreErrorsThatNameTheByte) {
  const Recorded recorded = record(Compression::None);
  const std::uint64_t first = (*Reader::open(source_of(recorded.file))).chunks()[0].offset;
  Bytes file = recorded.file;
  std::memset(file.data() + first, 0xFF, 4);
  const Contents found = contents(*Reader::open(source_of(file)));
  ASSERT_FALSE(found.damage.empty());
  EXPECT_EQ(found.damage[0].offset, first);
}

TEST(Rosbag, WhatIsNoBagSaysSo) {
  for (const std::string text :
       {"", "#ROSBAG V1.2\nxxxxxxxx", "#ROSBAG V2.0\n", "#ROSBAG V2.0\n12345678"}) {
    const auto reader = Reader::open(source_of(Bytes(text.begin(), text.end())));
    ASSERT_FALSE(reader) << text;
    EXPECT_THAT(reader.error().message, HasSubstr("byte "));
  }
}

}  // namespace
}  // namespace watersky::rosbag
