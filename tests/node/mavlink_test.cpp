// SPDX-License-Identifier: MIT
// Our MAVLink before node-mavlink, and its before ours.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <set>

#include "node_support.hpp"
#include "watersky/wire/mavlink.hpp"
#include "watersky/wire/mavlink_signing.hpp"

namespace watersky::mavlink {
namespace {

using Bytes = std::vector<std::uint8_t>;
using nlohmann::json;
using test::node_is_missing;
constexpr const char* kPassphrase = "watersky";
const Time kNow{std::chrono::sys_days{std::chrono::year{2026} / 6 / 1}};

/// Any values in all fields; texts of letters alone, which both sides read alike.
Message any(const MessageInfo& info, std::mt19937& random) {
  Message m(info);
  for (const FieldInfo& f : info.fields) {
    if (f.type == FieldType::Char) {
      std::string text(random() % (std::size_t{f.count} + 1), ' ');
      for (char& c : text) c = static_cast<char>('a' + random() % 26);
      m.set_text(f.name, text);
      continue;
    }
    for (std::size_t i = 0; i < std::max<std::size_t>(1, f.count); ++i) {
      if (f.type == FieldType::F32 || f.type == FieldType::F64)
        m.set(f.name, static_cast<float>(static_cast<double>(random()) / 1000.0 - 2e6), i);
      else
        m.set_integer(f.name, static_cast<std::int64_t>(std::uint64_t{random()} << 32 | random()),
                      i);
    }
  }
  return m;
}

/// One element of a field as the other side printed it.
void expect_number(const Message& m, const FieldInfo& f, std::size_t index, const json& theirs) {
  const std::string where = std::string(m.info().name) + "." + std::string(f.name);
  if (f.type == FieldType::U64) {
    EXPECT_EQ(std::to_string(static_cast<std::uint64_t>(m.integer(f.name, index))),
              theirs.get<std::string>())
        << where;
  } else if (f.type == FieldType::I64) {
    EXPECT_EQ(std::to_string(m.integer(f.name, index)), theirs.get<std::string>()) << where;
  } else {
    EXPECT_EQ(m.number(f.name, index), theirs.get<double>()) << where;
  }
}

void expect_fields(const Message& m, const json& theirs, bool extensions) {
  for (const FieldInfo& f : m.info().fields) {
    if (f.extension && !extensions) continue;
    const std::string name(f.name);
    // Either side may know extensions that the other does not yet.
    if (!theirs.contains(name)) {
      EXPECT_TRUE(f.extension) << m.info().name << "." << name;
      continue;
    }
    const json& value = theirs[name];
    if (f.type == FieldType::Char) {
      EXPECT_EQ(m.text(f.name), value.get<std::string>()) << m.info().name << "." << name;
    } else if (f.count == 0) {
      expect_number(m, f, 0, value);
    } else {
      ASSERT_EQ(value.size(), f.count) << m.info().name << "." << name;
      for (std::size_t i = 0; i < f.count; ++i) expect_number(m, f, i, value[i]);
    }
  }
}

TEST(NodeMavlink, ReadsEveryMessageThatBothKnow) {
  WATERSKY_NEEDS_NODE();
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "frames").string();
  std::mt19937 random(5);
  Signer signer(signing_key(kPassphrase), 4);
  struct Sent {
    Message message;
    int version;
    bool is_signed;
  };
  std::vector<Sent> sent;
  Bytes all;
  std::uint8_t sequence = 0;
  for (const MessageInfo& info : messages())
    for (const int kind : {1, 2, 3, 4}) {  // MAVLink 1, 2, 2 truncated to a byte, 2 signed
      const Message m = kind == 3 ? Message(info) : any(info, random);
      const auto frame = encode(m, {11, 12, ++sequence}, kind == 1 ? 1 : 2);
      if (!frame) continue;  // too large an id for MAVLink 1
      const Bytes bytes = kind == 4 ? signer.sign(*frame, kNow).value() : *frame;
      all.insert(all.end(), bytes.begin(), bytes.end());
      sent.push_back({m, kind == 1 ? 1 : 2, kind == 4});
    }
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(all.data()), static_cast<std::streamsize>(all.size()));

  const json found = test::node("check_mavlink.mjs", "'" + file + "' " + kPassphrase);
  EXPECT_EQ(found["invalid"], 0);
  const auto known = found["known"].get<std::set<std::uint32_t>>();
  std::size_t next = 0;
  for (const Sent& s : sent) {
    if (!known.contains(s.message.info().id)) continue;
    ASSERT_LT(next, found["frames"].size());
    const json& frame = found["frames"][next++];
    ASSERT_EQ(frame["id"], s.message.info().id);
    EXPECT_EQ(frame["name"], s.message.info().name);
    EXPECT_EQ(frame["system"], 11);
    EXPECT_EQ(frame["component"], 12);
    EXPECT_EQ(frame["version"], s.version);
    EXPECT_EQ(frame["signature"], s.is_signed ? json(true) : json());
    expect_fields(s.message, frame["fields"], s.version == 2);
  }
  EXPECT_EQ(next, found["frames"].size());
  EXPECT_GT(next, 600u);
}

TEST(NodeMavlink, WritesWhatWeRead) {
  WATERSKY_NEEDS_NODE();
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "frames").string();
  const json written = test::node("write_mavlink.mjs", "'" + file + "' " + kPassphrase);
  std::ifstream in(file, std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(in), {}};
  SignatureChecker checker(signing_key(kPassphrase), kNow);

  std::size_t at = 0, decoded = 0, is_signed = 0;
  for (const json& theirs : written["frames"]) {
    const auto size = theirs["size"].get<std::size_t>();
    const auto frame_bytes = std::span(bytes).subspan(at, size);
    at += size;
    const ParseStep step = parse_frame(frame_bytes);
    const MessageInfo* info = find_message(theirs["id"].get<std::uint32_t>());
    const bool v1 = theirs["kind"] == "v1";
    if (v1 && info && size != info->min_length + 8u) {
      // It sends extensions in MAVLink 1, which knows none: that is no frame.
      EXPECT_NE(step.outcome, ParseOutcome::Frame) << info->name;
      continue;
    }
    ASSERT_EQ(step.outcome, ParseOutcome::Frame) << theirs["name"];
    EXPECT_EQ(step.frame.bytes.size(), size);
    EXPECT_EQ(step.frame.system, 7);
    EXPECT_EQ(step.frame.component, 9);
    EXPECT_EQ(step.frame.sequence, theirs["sequence"].get<int>());
    EXPECT_EQ(checker.check(step.frame),
              theirs["kind"] == "signed" ? SignatureVerdict::Good : SignatureVerdict::Unsigned);
    is_signed += theirs["kind"] == "signed" ? 1 : 0;
    if (!info) continue;  // passed on as it is
    EXPECT_EQ(info->name, theirs["name"].get<std::string>());
    expect_fields(Message(step.frame), theirs["fields"], !v1);
    ++decoded;
  }
  EXPECT_EQ(at, bytes.size());
  EXPECT_GT(decoded, 550u);
  EXPECT_GT(is_signed, 250u);
}

}  // namespace
}  // namespace watersky::mavlink
