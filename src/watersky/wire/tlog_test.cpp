// SPDX-License-Identifier: MIT
#include "watersky/wire/tlog.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include "support/real_data.hpp"

namespace watersky::mavlink {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr Time kStart{std::chrono::seconds(1'533'430'800)};

Bytes attitude_frame(int i) {
  Message m(*find_message("ATTITUDE"));
  m.set("time_boot_ms", 1000 + 100 * i).set("roll", 0.01 * i);
  return encode(m, {1, 1, static_cast<std::uint8_t>(i)}).value();
}

Time stamp(int i) { return kStart + std::chrono::milliseconds(100 * i); }

Bytes log_of(int count) {
  Bytes log;
  for (int i = 0; i < count; ++i) append_tlog_record(log, stamp(i), attitude_frame(i));
  return log;
}

struct Read {
  std::vector<Time> times;
  std::size_t skipped = 0, gaps = 0, truncated = 0;
};

Read read_all(const Bytes& log) {
  TlogReader reader(log);
  Read out;
  while (const auto record = reader.next()) out.times.push_back(record->received_at);
  out.skipped = reader.skipped_bytes();
  out.gaps = reader.gaps();
  out.truncated = reader.truncated_bytes();
  return out;
}

TEST(Tlog, StampsAreBigEndianMicroseconds) {
  Bytes log;
  // The first stamp of cuav_flight's log.
  append_tlog_record(log, Time(std::chrono::microseconds(0x000572a5add36ecb)), {});
  EXPECT_EQ(log, (Bytes{0x00, 0x05, 0x72, 0xa5, 0xad, 0xd3, 0x6e, 0xcb}));
}

TEST(Tlog, ReadsWhatWasAppended) {
  const Read read = read_all(log_of(50));
  ASSERT_EQ(read.times.size(), 50u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(read.times[static_cast<std::size_t>(i)], stamp(i));
  EXPECT_EQ(read.skipped + read.gaps + read.truncated, 0u);
}

TEST(Tlog, ATailCutAnywhereLosesOnlyTheLastRecord) {
  const Bytes log = log_of(5);
  const std::size_t whole = log_of(4).size();
  for (std::size_t n = whole; n < log.size(); ++n) {
    const Read read = read_all(Bytes(log.begin(), log.begin() + static_cast<std::ptrdiff_t>(n)));
    EXPECT_EQ(read.times.size(), 4u) << n;
    EXPECT_EQ(read.truncated, n - whole);
    EXPECT_EQ(read.skipped, 0u);
  }
}

TEST(Tlog, GarbageBetweenRecordsLosesNoRecord) {
  std::mt19937 rng(2);
  for (int trial = 0; trial < 200; ++trial) {
    Bytes log;
    std::size_t garbage = 0;
    for (int i = 0; i < 20; ++i) {
      if (i % 3 == 1) {
        const int n = std::uniform_int_distribution(1, 400)(rng);
        garbage += static_cast<std::size_t>(n);
        // Rich in magic bytes, so that the reader is led astray as often as can be.
        for (int k = 0; k < n; ++k)
          log.push_back(rng() % 4 == 0 ? 0xFD : static_cast<std::uint8_t>(rng() & 0xFF));
      }
      append_tlog_record(log, stamp(i), attitude_frame(i));
    }
    const Read read = read_all(log);
    EXPECT_EQ(read.times.size(), 20u) << trial;
    EXPECT_EQ(read.skipped, garbage);
    EXPECT_EQ(read.gaps, 7u);
  }
}

TEST(Tlog, ACorruptedFrameLosesOnlyItself) {
  Bytes log = log_of(10);
  const std::size_t before = log_of(3).size();
  const std::size_t size = log_of(4).size() - before;
  log[before + 20] ^= 0x40;
  const Read read = read_all(log);
  EXPECT_EQ(read.times.size(), 9u);
  EXPECT_EQ(read.skipped, size);
}

TEST(Tlog, GoesOnWhenTheClockWasSetInMidFlight) {
  Bytes log = log_of(5);
  for (int i = 0; i < 5; ++i)
    append_tlog_record(log, stamp(i) + std::chrono::hours(24 * 400), attitude_frame(i));
  EXPECT_EQ(read_all(log).times.size(), 10u);
}

TEST(Tlog, AnUnknownMessageBetweenKnownOnesIsARecord) {
  Bytes unknown = attitude_frame(1);
  unknown[7] = 0xEE;
  unknown[8] = 0xEE;
  Bytes log = log_of(2);
  append_tlog_record(log, stamp(2), unknown);
  append_tlog_record(log, stamp(3), attitude_frame(3));
  const Read read = read_all(log);
  EXPECT_EQ(read.times.size(), 4u);
  EXPECT_EQ(read.skipped, 0u);
}

TEST(Tlog, EmptyAndSenselessBytesHoldNoRecord) {
  EXPECT_TRUE(read_all({}).times.empty());
  const Read read = read_all(Bytes(5000, 0xFD));
  EXPECT_TRUE(read.times.empty());
  EXPECT_EQ(read.skipped, 5000u);
}

// Counts by the data's own README; every record of the flight has a known stamp.
TEST(Tlog, CuavFlightHoldsTheMessagesItsDescriptionCounts) {
  const auto data = test::real_data("cuav_flight");
  if (!data) GTEST_SKIP() << "no cuav_flight; set WATERSKY_DATA";
  std::ifstream file(*data / "flight.tlog", std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  TlogReader reader(bytes);
  std::map<std::uint32_t, int> counts;
  Time first{}, last{};
  while (const auto record = reader.next()) {
    ++counts[record->frame.message_id];
    if (first == Time{}) first = record->received_at;
    last = record->received_at;
  }
  EXPECT_EQ(counts[30], 604);
  EXPECT_EQ(counts[33], 676);
  EXPECT_EQ(reader.skipped_bytes(), 0u);
  EXPECT_NEAR(to_seconds(last - first), 185.0, 1.0);
}

}  // namespace
}  // namespace watersky::mavlink
