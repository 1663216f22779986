// SPDX-License-Identifier: MIT
#include "watersky/wire/lsf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include "support/real_data.hpp"
#include "watersky/wire/gzip.hpp"

namespace watersky::imc {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Bytes gzipped(const Bytes& bytes) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
  Bytes out(bytes.size() + 1000);
  stream.next_in = const_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// n Voltage packets, the k-th of k volts.
Bytes log_of(int n) {
  Bytes log;
  for (int k = 0; k < n; ++k) {
    Message m(*Schema::builtin().find("Voltage"));
    m.set("value", k);
    const Bytes packet =
        encode(m, {1.7e9 + k, 1, 2, 3, 4}, k % 2 == 0 ? std::endian::little : std::endian::big)
            .value();
    log.insert(log.end(), packet.begin(), packet.end());
  }
  return log;
}

std::vector<int> volts(LsfReader& reader) {
  std::vector<int> out;
  while (const auto record = reader.next())
    out.push_back(
        static_cast<int>(View::make(record->packet, Schema::builtin()).value().number("value")));
  return out;
}

TEST(LsfReader, ReadsPacketsOfBothByteOrders) {
  const Bytes log = log_of(4);
  LsfReader reader(log, Schema::builtin());
  EXPECT_THAT(volts(reader), testing::ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(reader.skipped_bytes() + reader.truncated_bytes(), 0u);
}

TEST(LsfReader, FindsTheNextPacketBehindGarbageAndSaysWhere) {
  std::mt19937 random(3);
  Bytes log = log_of(3);
  const std::size_t packet = log.size() / 3;
  Bytes noise(1000);
  for (auto& b : noise) b = static_cast<std::uint8_t>(random());
  log.insert(log.begin() + static_cast<std::ptrdiff_t>(packet), noise.begin(), noise.end());
  log[packet + 1000 + 20] ^= 1;  // the second packet's CRC is wrong now
  LsfReader reader(log, Schema::builtin());
  EXPECT_THAT(volts(reader), testing::ElementsAre(0, 2));
  EXPECT_EQ(reader.skipped_bytes(), 1000 + packet);
  EXPECT_EQ(reader.gaps(), 1u);
  EXPECT_EQ(reader.first_gap_at(), packet);
}

TEST(LsfReader, TellsACutEndFromGarbage) {
  const Bytes whole = log_of(3);
  for (std::size_t n = 0; n <= whole.size(); ++n) {
    const std::span cut = std::span(whole).first(n);
    LsfReader reader(cut, Schema::builtin());
    const std::size_t packet = whole.size() / 3;
    EXPECT_EQ(volts(reader).size(), n / packet);
    EXPECT_EQ(reader.truncated_bytes(), n % packet);
    EXPECT_EQ(reader.skipped_bytes(), 0u);
  }
  Bytes garbage = whole;
  garbage.insert(garbage.end(), 50, 0x41);
  LsfReader reader(garbage, Schema::builtin());
  EXPECT_EQ(volts(reader).size(), 3u);
  EXPECT_EQ(reader.skipped_bytes(), 50u);
  EXPECT_EQ(reader.truncated_bytes(), 0u);
}

TEST(Gzip, IsReadMemberByMemberAndAsFarAsItGoes) {
  const Bytes a = log_of(100), b = log_of(7);
  Bytes both = gzipped(a), expected = a;
  const Bytes second = gzipped(b);
  both.insert(both.end(), second.begin(), second.end());
  expected.insert(expected.end(), b.begin(), b.end());
  const Gunzipped all = gunzip(both, 1 << 20).value();
  EXPECT_TRUE(all.whole);
  EXPECT_EQ(all.bytes, expected);
  for (std::size_t n = 2; n < both.size(); ++n) {
    const Gunzipped some = gunzip(std::span(both).first(n), 1 << 20).value();
    EXPECT_EQ(some.whole, n == gzipped(a).size()) << n;
    ASSERT_LE(some.bytes.size(), expected.size());
    EXPECT_TRUE(std::equal(some.bytes.begin(), some.bytes.end(), expected.begin()));
  }
  EXPECT_EQ(gunzip(both, expected.size() - 1).error().code, ErrorCode::OutOfRange);
  EXPECT_TRUE(gunzip(both, expected.size()).ok());
  EXPECT_EQ(gunzip(a, 100).error().code, ErrorCode::InvalidInput);
  Bytes trailing = gzipped(a);
  trailing.push_back(0);
  EXPECT_FALSE(gunzip(trailing, 1 << 20)->whole);
}

// --- A log of a running DUNE ---------------------------------------------------------------

/// A second decoder: plain, slow, nothing of imc.cpp in it. One line a field, its bytes as they
/// stand for numbers; stops where it does not understand.
class PlainDecoder {
 public:
  PlainDecoder(const Schema& schema, const std::uint8_t* p, std::size_t n)
      : schema_(schema), p_(p), n_(n) {}

  std::string fields(const MessageInfo& info, const std::string& path) {
    std::string out;
    for (const FieldInfo& f : info.fields) {
      const std::string at = path + "." + f.name;
      switch (f.type) {
        case FieldType::Raw:
        case FieldType::Text: out += at + "=" + take(u16()) + "\n"; break;
        case FieldType::Message: out += inline_message(at); break;
        case FieldType::List: {
          const std::size_t n = u16();
          out += at + "=" + std::to_string(n) + "\n";
          for (std::size_t i = 0; i < n; ++i) out += inline_message(at);
          break;
        }
        default: out += at + "=" + take(width(f.type)) + "\n";
      }
    }
    return out;
  }
  [[nodiscard]] std::size_t left() const { return n_ - at_; }

 private:
  static std::size_t width(FieldType type) {
    switch (type) {
      case FieldType::U8:
      case FieldType::I8: return 1;
      case FieldType::U16:
      case FieldType::I16: return 2;
      case FieldType::I64:
      case FieldType::F64: return 8;
      default: return 4;
    }
  }
  std::string inline_message(const std::string& path) {
    const unsigned id = u16();
    if (id == 65535) return path + "=none\n";
    const MessageInfo* info = schema_.find(static_cast<std::uint16_t>(id));
    if (!info) throw std::runtime_error(path + ": unknown id");
    return path + ":" + info->name + "\n" + fields(*info, path);
  }
  unsigned u16() {
    const std::string two = take(2);
    return static_cast<std::uint8_t>(two[0]) + 256u * static_cast<std::uint8_t>(two[1]);
  }
  std::string take(std::size_t n) {
    if (left() < n) throw std::runtime_error("ends early");
    at_ += n;
    return {reinterpret_cast<const char*>(p_) + at_ - n, n};
  }
  const Schema& schema_;
  const std::uint8_t* p_;
  std::size_t n_;
  std::size_t at_ = 0;
};

/// What our decoder made of a message, in the lines of the plain one.
std::string lines_of(const Message& m, const std::string& path) {
  std::string out;
  const auto inner = [&](const Message& x, const std::string& at) {
    out += x.is_none() ? at + "=none\n" : at + ":" + x.info().name + "\n" + lines_of(x, at);
  };
  for (const FieldInfo& f : m.info().fields) {
    const std::string at = path + "." + f.name;
    if (f.type == FieldType::Message) {
      inner(m.message(f.name), at);
    } else if (f.type == FieldType::List) {
      out += at + "=" + std::to_string(m.list(f.name).size()) + "\n";
      for (const Message& x : m.list(f.name)) inner(x, at);
    } else if (f.type == FieldType::Text || f.type == FieldType::Raw) {
      out += at + "=" + m.bytes(f.name) + "\n";
    } else if (f.type == FieldType::F32) {
      const auto v = static_cast<float>(m.number(f.name));
      out += at + "=" + std::string(reinterpret_cast<const char*>(&v), sizeof v) + "\n";
    } else if (f.type == FieldType::F64) {
      const double v = m.number(f.name);
      out += at + "=" + std::string(reinterpret_cast<const char*>(&v), sizeof v) + "\n";
    } else {
      const std::int64_t v = m.integer(f.name);
      out += at + "=" + std::string(reinterpret_cast<const char*>(&v), size_bytes(f.type)) + "\n";
    }
  }
  return out;
}

class DuneLog : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = test::real_data("autopilot_logs/dune_x8");
    if (!folder) GTEST_SKIP() << "the real data is not here";
    const Gunzipped log = gunzip(read_file(*folder / "Data.lsf.gz"), 1 << 24).value();
    EXPECT_TRUE(log.whole);
    log_ = log.bytes;
    const Bytes xml = gunzip(read_file(*folder / "IMC.xml.gz"), 1 << 24).value().bytes;
    own_.emplace(Schema::from_xml({reinterpret_cast<const char*>(xml.data()), xml.size()}).value());
  }
  Bytes log_;
  std::optional<Schema> own_;
};

// The file has grown since its notes were written, which speak of 5270 packets: gzip -dc gives
// 652296 bytes, which a 20-line script in another language cuts into as many packets as we do.
constexpr std::size_t kPackets = 11279;

TEST_F(DuneLog, EncodesAgainByteForByteInBothByteOrders) {
  LsfReader reader(log_, Schema::builtin());
  std::size_t packets = 0;
  while (const auto record = reader.next()) {
    ++packets;
    const Packet& packet = record->packet;
    const auto message = Message::decode(packet, Schema::builtin());
    ASSERT_TRUE(message.ok()) << "byte " << record->offset << ": " << message.error().message;
    const Bytes same = encode(*message, packet.header, packet.order).value();
    ASSERT_TRUE(std::ranges::equal(same, packet.bytes)) << record->offset;

    const Bytes turned = encode(*message, packet.header, std::endian::big).value();
    const ParseStep again = parse_packet(turned, Schema::builtin());
    ASSERT_EQ(again.outcome, ParseOutcome::Packet);
    ASSERT_EQ(again.packet.order, std::endian::big);
    const Message back = Message::decode(again.packet, Schema::builtin()).value();
    ASSERT_EQ(back, *message);
    ASSERT_EQ(encode(back, again.packet.header, std::endian::big).value(), turned);
    ASSERT_TRUE(std::ranges::equal(encode(back, again.packet.header).value(), packet.bytes));
  }
  EXPECT_EQ(packets, kPackets);
  EXPECT_EQ(reader.skipped_bytes() + reader.truncated_bytes(), 0u);
}

TEST_F(DuneLog, ASecondDecoderDrivenByItsOwnSchemaAgreesOnEveryField) {
  LsfReader reader(log_, Schema::builtin());
  std::size_t packets = 0, fields = 0;
  while (const auto record = reader.next()) {
    const Packet& packet = record->packet;
    const MessageInfo* info = own_->find(packet.message_id);
    ASSERT_NE(info, nullptr) << packet.message_id;
    PlainDecoder plain(*own_, packet.payload.data(), packet.payload.size());
    const std::string expected = plain.fields(*info, info->name);
    EXPECT_EQ(plain.left(), 0u);
    ASSERT_EQ(lines_of(Message::decode(packet, Schema::builtin()).value(), packet.info->name),
              expected);
    ++packets;
    fields += info->fields.size();
  }
  EXPECT_EQ(packets, kPackets);
  EXPECT_GT(fields, 80'000u);
}

TEST_F(DuneLog, OurTableIsThatOfItsSchema) {
  for (const MessageInfo& ours : Schema::builtin().messages()) {
    const MessageInfo* theirs = own_->find(ours.id);
    ASSERT_NE(theirs, nullptr) << ours.name;
    EXPECT_EQ(theirs->name, ours.name);
    ASSERT_EQ(theirs->fields.size(), ours.fields.size()) << ours.name;
    for (std::size_t i = 0; i < ours.fields.size(); ++i) {
      const FieldInfo &a = ours.fields[i], &b = theirs->fields[i];
      EXPECT_EQ(a.name, b.name) << ours.name;
      EXPECT_EQ(a.type, b.type) << ours.name << "." << a.name;
      EXPECT_EQ(a.message_type, b.message_type) << ours.name << "." << a.name;
      EXPECT_EQ(a.unit, ours.name == "AisInfo" && a.name == "course" ? "" : b.unit) << ours.name;
    }
  }
}

}  // namespace
}  // namespace watersky::imc
