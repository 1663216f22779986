// SPDX-License-Identifier: MIT
#include "watersky/wire/mavlink.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/hex.hpp"

namespace watersky::mavlink {
namespace {

using Bytes = std::vector<std::uint8_t>;
using test::from_hex;

Message message(std::string_view name) {
  const MessageInfo* info = find_message(name);
  EXPECT_NE(info, nullptr) << name;
  return Message(*info);
}

// Frames made by node-mavlink 2.3.0 and parsed back by it.
const Bytes kHeartbeat2 = from_hex("fd0900000001010000000a0000000103510403fd23");
const Bytes kHeartbeat1 = from_hex("fe09050101000a0000000103510403346d");
const Bytes kPosition2 =
    from_hex("fd1c000001010121000040e201004026ca2e80d1f008a086010018730100640038ff03002823f797");
const Bytes kText2 = from_hex("fd060000020101fd00000668656c6c6f1d9e");
const Bytes kItem2 = from_hex(
    "fd250000030101490000000000000000000000000000000000004026ca2e80d1f0080000c842020010000101030001"
    "8fcc");

Message heartbeat() {
  Message m = message("HEARTBEAT");
  m.set("type", 1).set("autopilot", 3).set("base_mode", 81).set("custom_mode", 10);
  return m.set("system_status", 4).set("mavlink_version", 3);
}

Message position() {
  Message m = message("GLOBAL_POSITION_INT");
  m.set("time_boot_ms", 123456).set("lat", 785000000).set("lon", 150000000).set("alt", 100000);
  return m.set("relative_alt", 95000).set("vx", 100).set("vy", -200).set("vz", 3).set("hdg", 9000);
}

TEST(MavlinkTable, EveryCrcExtraFollowsFromItsNamesAndTypes) {
  ASSERT_GT(messages().size(), 100u);
  for (const MessageInfo& info : messages())
    EXPECT_EQ(compute_crc_extra(info), info.crc_extra) << info.name;
}

TEST(MavlinkTable, FieldsFillTheLengthsOfTheMessageWithoutAGap) {
  std::uint32_t last = 0;
  for (const MessageInfo& info : messages()) {
    EXPECT_TRUE(info.id > last || info.id == 0) << info.name;
    last = info.id;
    std::size_t base = 0, all = 0;
    for (const FieldInfo& f : info.fields) {
      EXPECT_EQ(f.offset, all) << info.name << "." << f.name;
      all += size_bytes(f.type) * std::max<std::size_t>(1, f.count);
      if (!f.extension) base = all;
    }
    EXPECT_EQ(base, info.min_length) << info.name;
    EXPECT_EQ(all, info.max_length) << info.name;
  }
}

TEST(MavlinkTable, KnowsOffsetsThatOthersPublished) {
  EXPECT_EQ(find_message("CAMERA_FEEDBACK")->field("completed_captures")->offset, 45);
  EXPECT_EQ(find_message("GIMBAL_DEVICE_ATTITUDE_STATUS")->field("flags")->offset, 36);
  EXPECT_EQ(find_message("CAMERA_IMAGE_CAPTURED")->field("file_url")->offset, 50);
  EXPECT_EQ(find_message(33)->field("relative_alt")->unit, "mm");
  EXPECT_EQ(find_message(33)->field("altitude"), nullptr);
  EXPECT_EQ(find_message(16777215), nullptr);
}

TEST(Mavlink, WritesTheFramesOfNodeMavlink) {
  EXPECT_EQ(encode(heartbeat(), {1, 1, 0}, 2).value(), kHeartbeat2);
  EXPECT_EQ(encode(heartbeat(), {1, 1, 5}, 1).value(), kHeartbeat1);
  EXPECT_EQ(encode(position(), {1, 1, 1}).value(), kPosition2);
  Message text = message("STATUSTEXT");
  text.set("severity", 6).set_text("text", "hello");
  EXPECT_EQ(encode(text, {1, 1, 2}).value(), kText2);
  Message item = message("MISSION_ITEM_INT");
  item.set("target_system", 1).set("target_component", 1).set("seq", 2).set("frame", 3);
  item.set("command", 16)
      .set("autocontinue", 1)
      .set("x", 785000000)
      .set("y", 150000000)
      .set("z", 100);
  EXPECT_EQ(encode(item, {1, 1, 3}).value(), kItem2);
}

TEST(Mavlink, ReadsTheFramesOfNodeMavlink) {
  for (const Bytes& bytes : {kHeartbeat1, kHeartbeat2}) {
    const ParseStep step = parse_frame(bytes);
    ASSERT_EQ(step.outcome, ParseOutcome::Frame);
    EXPECT_EQ(step.frame.bytes.size(), bytes.size());
    const Message m(step.frame);
    EXPECT_EQ(m.info().name, "HEARTBEAT");
    EXPECT_EQ(m.integer("custom_mode"), 10);
    EXPECT_EQ(m.integer("base_mode"), 81);
    EXPECT_EQ(m.integer("system_status"), 4);
  }
  const ParseStep step = parse_frame(kPosition2);
  ASSERT_EQ(step.outcome, ParseOutcome::Frame);
  const Message m(step.frame);
  EXPECT_EQ(m.integer("lat"), 785000000);
  EXPECT_EQ(m.integer("vy"), -200);
  EXPECT_EQ(m.number("hdg"), 9000.0);
  EXPECT_EQ(Message(parse_frame(kText2).frame).text("text"), "hello");
}

TEST(Mavlink, FillsWhatVersion2CutOffWithZeros) {
  const ParseStep step = parse_frame(kItem2);
  ASSERT_EQ(step.outcome, ParseOutcome::Frame);
  EXPECT_EQ(step.frame.payload.size(), 37u);
  EXPECT_EQ(Message(step.frame).integer("mission_type"), 0);
  EXPECT_EQ(Message(step.frame).integer("x"), 785000000);
}

TEST(Mavlink, KeepsOneByteOfAnAllZeroPayload) {
  const Bytes bytes = encode(message("ATTITUDE"), {}).value();
  EXPECT_EQ(bytes.size(), 13u);
  EXPECT_EQ(parse_frame(bytes).outcome, ParseOutcome::Frame);
}

TEST(Mavlink, EveryMessageWithRandomFieldsComesBackAsItWas) {
  std::mt19937 rng(1);
  for (const MessageInfo& info : messages()) {
    for (int version : {1, 2}) {
      Message m(info);
      for (const FieldInfo& f : info.fields) {
        if (version == 1 && f.extension) continue;
        for (std::size_t i = 0; i < std::max<std::size_t>(1, f.count); ++i)
          m.set(f.name, std::uniform_real_distribution(-300.0, 300.0)(rng), i);
      }
      const auto bytes = encode(m, {7, 100, 3}, version);
      if (version == 1 && info.id > 255) {
        EXPECT_FALSE(bytes) << info.name;
        continue;
      }
      ASSERT_TRUE(bytes) << info.name;
      const ParseStep step = parse_frame(*bytes);
      ASSERT_EQ(step.outcome, ParseOutcome::Frame) << info.name;
      EXPECT_EQ(step.frame.system, 7);
      EXPECT_EQ(step.frame.component, 100);
      EXPECT_EQ(step.frame.sequence, 3);
      const Message back(step.frame);
      for (const FieldInfo& f : info.fields)
        for (std::size_t i = 0; i < std::max<std::size_t>(1, f.count); ++i)
          EXPECT_EQ(back.number(f.name, i), m.number(f.name, i)) << info.name << "." << f.name;
    }
  }
}

TEST(Mavlink, NumbersThatDoNotFitGoToTheNearestEnd) {
  Message m = message("GLOBAL_POSITION_INT");
  EXPECT_EQ(m.set("vx", 1e9).integer("vx"), 32767);
  EXPECT_EQ(m.set("vx", -1e9).integer("vx"), -32768);
  EXPECT_EQ(m.set("hdg", -1).integer("hdg"), 0);
  EXPECT_EQ(m.set("hdg", NAN).integer("hdg"), 0);
  EXPECT_EQ(message("SYSTEM_TIME").set("time_unix_usec", 1e30).integer("time_unix_usec"), -1);
  EXPECT_EQ(message("SYSTEM_TIME")
                .set_integer("time_unix_usec", 1533430844800001)
                .integer("time_unix_usec"),
            1533430844800001);
}

TEST(Mavlink, OneWrongBitIsNoFrame) {
  for (std::size_t i = 1; i < kPosition2.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      Bytes bytes = kPosition2;
      bytes[i] = static_cast<std::uint8_t>(bytes[i] ^ (1 << bit));
      const ParseStep step = parse_frame(bytes);
      // An unknown id cannot be checked, a longer length wants more: neither gives a message.
      EXPECT_TRUE(step.outcome != ParseOutcome::Frame || !step.frame.info) << i << " " << bit;
    }
}

TEST(Mavlink, EveryBeginningOfAFrameWantsMore) {
  for (const Bytes& frame : {kHeartbeat1, kPosition2})
    for (std::size_t n = 0; n < frame.size(); ++n)
      EXPECT_EQ(parse_frame(std::span(frame).first(n)).outcome, ParseOutcome::NeedMore) << n;
}

TEST(Mavlink, TakesASignedFrameWithItsSignatureAndDropsUnknownFlags) {
  Bytes bytes = kHeartbeat2;
  bytes.resize(bytes.size() - 2);
  bytes[2] = 0x01;
  std::uint16_t c = crc(std::span(bytes).subspan(1));
  const std::uint8_t extra = 50;
  c = crc({&extra, 1}, c);
  bytes.push_back(static_cast<std::uint8_t>(c & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(c >> 8));
  EXPECT_EQ(parse_frame(bytes).outcome, ParseOutcome::NeedMore);
  bytes.resize(bytes.size() + 13, 0xAB);
  const ParseStep step = parse_frame(bytes);
  ASSERT_EQ(step.outcome, ParseOutcome::Frame);
  EXPECT_TRUE(step.frame.is_signed);
  EXPECT_EQ(step.frame.bytes.size(), bytes.size());
  bytes[2] = 0x02;
  EXPECT_EQ(parse_frame(bytes).outcome, ParseOutcome::NotAFrame);
}

}  // namespace
}  // namespace watersky::mavlink
