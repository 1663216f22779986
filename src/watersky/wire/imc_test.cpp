// SPDX-License-Identifier: MIT
#include "watersky/wire/imc.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "support/hex.hpp"

namespace watersky::imc {
namespace {

using test::from_hex;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;
constexpr auto kOrders = {std::endian::little, std::endian::big};

const Schema& schema() { return Schema::builtin(); }
Message message(std::string_view name) {
  const MessageInfo* info = schema().find(name);
  EXPECT_NE(info, nullptr) << name;
  return Message(*info);
}

// Packets that a running DUNE accepted; the second also as pyimclsts packs it.
const Bytes kHeartbeat = from_hex("54fe9600000000000040fc54d9414444ffffffffd593");
const Bytes kReference = from_hex(
    "54fedf01270000000040fc54d9414444ff0c0cff079201000000000000324000910100001643038c5060d8bcd8f53f"
    "f9a067b3ea73d13f00000000c473");

Packet parsed(const Bytes& bytes) {
  const ParseStep step = parse_packet(bytes, schema());
  EXPECT_EQ(step.outcome, ParseOutcome::Packet);
  return step.packet;
}
Message decoded(const Bytes& bytes) { return Message::decode(parsed(bytes), schema()).value(); }

/// Corrects size and CRC of a little-endian packet whose payload was changed.
Bytes mended(Bytes packet) {
  packet.resize(packet.size() - kFooterBytes);
  const auto size = static_cast<std::uint16_t>(packet.size() - kHeaderBytes);
  std::memcpy(packet.data() + 4, &size, 2);
  const std::uint16_t c = crc(packet);
  packet.push_back(static_cast<std::uint8_t>(c));
  packet.push_back(static_cast<std::uint8_t>(c >> 8));
  return packet;
}

/// Any message: numbers of any bits, texts, inline messages of the types meant.
class Maker {
 public:
  explicit Maker(unsigned seed) : random_(seed) {}

  Message any(const MessageInfo& info, int depth = 0) {
    Message m(info);
    for (const FieldInfo& f : info.fields) {
      switch (f.type) {
        case FieldType::Raw:
        case FieldType::Text: {
          std::string text(random_() % 20, ' ');
          for (char& c : text) c = static_cast<char>(random_());
          m.set_bytes(f.name, text);
          break;
        }
        case FieldType::Message: m.set_message(f.name, inline_message(f, depth)); break;
        case FieldType::List:
          for (auto n = random_() % 3; n > 0; --n) m.add(f.name, inline_message(f, depth));
          break;
        case FieldType::F32:
        case FieldType::F64:
          m.set(f.name, std::bit_cast<float>(static_cast<std::uint32_t>(random_())));
          break;
        default:
          m.set_integer(f.name, static_cast<std::int64_t>(std::uint64_t{random_()} << 32 |
                                                          std::uint64_t{random_()}));
      }
    }
    return m;
  }

 private:
  Message inline_message(const FieldInfo& field, int depth) {
    if (depth > 5 || random_() % 4 == 0) return {};
    const auto all = schema().messages();
    const MessageInfo* info = field.accepts.empty()
                                  ? &all[random_() % all.size()]
                                  : schema().find(field.accepts[random_() % field.accepts.size()]);
    return any(*info, depth + 1);
  }
  std::mt19937 random_;
};

TEST(ImcCrc, IsCrc16ArcHoweverTheBytesAreCut) {
  const std::string_view digits = "123456789";
  const Bytes bytes(digits.begin(), digits.end());
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut)
    EXPECT_EQ(crc(std::span(bytes).subspan(cut), crc(std::span(bytes).first(cut))), 0xBB3D);
}

TEST(ImcSchema, HoldsWhatAVehicleAConsoleAndTheirPlansSpeak) {
  EXPECT_GT(schema().messages().size(), 150u);
  EXPECT_EQ(schema().find("EstimatedState")->id, 350);
  EXPECT_EQ(schema().find("EstimatedState")->fixed_bytes, 88u);
  EXPECT_EQ(schema().find(350)->fields[6].name, "phi");
  EXPECT_EQ(schema().find(350)->fields[6].unit, "rad");
  EXPECT_EQ(schema().find(350)->fields[6].offset, 32u);
  EXPECT_EQ(schema().find("PlanManeuver")->fields[1].accepts.size(), 33u);
  EXPECT_EQ(schema().find(kNoMessage), nullptr);
  EXPECT_EQ(schema().find("Nonsense"), nullptr);
}

TEST(ImcSchema, ThatContradictsItselfIsRefused) {
  const auto error = [](std::vector<MessageInfo> messages,
                        const std::vector<MessageGroup>& groups) {
    return Schema::make(std::move(messages), groups).error().message;
  };
  const auto one = [](std::uint16_t id, std::string name, std::vector<FieldInfo> fields = {}) {
    return MessageInfo{id, std::move(name), std::move(fields), 0, false};
  };
  FieldInfo x;
  x.name = "x";
  FieldInfo inner = x;
  inner.type = FieldType::Message;
  inner.message_type = "Gone";
  EXPECT_THAT(error({}, {}), HasSubstr("no message"));
  EXPECT_THAT(error({one(1, "A"), one(1, "B")}, {}), HasSubstr("the id 1 of another"));
  EXPECT_THAT(error({one(1, "A"), one(2, "A")}, {}), HasSubstr("A comes twice"));
  EXPECT_THAT(error({one(kNoMessage, "A")}, {}), HasSubstr("65535"));
  EXPECT_THAT(error({one(1, "A", {x, x})}, {}), HasSubstr("A.x comes twice"));
  EXPECT_THAT(error({one(1, "A", {inner})}, {}), HasSubstr("of Gone"));
  EXPECT_THAT(error({one(1, "A")}, {{"G", {"B"}}}), HasSubstr("names B"));
  EXPECT_THAT(error({one(1, "A", std::vector<FieldInfo>(65, x))}, {}), HasSubstr("more than 64"));
}

TEST(ImcXml, SaysOnWhichLineItIsWrong) {
  const auto error = [](std::string_view text) { return Schema::from_xml(text).error().message; };
  EXPECT_THAT(error("<messages>\n<message id='1' abbrev='A'>\n</wrong>"), HasSubstr("line 3"));
  EXPECT_THAT(error("<messages>\n<message id='x' abbrev='A'/></messages>"),
              HasSubstr("line 2: A has the id \"x\""));
  EXPECT_THAT(error("<messages>\n\n<message id='1' abbrev='A'><field abbrev='f' type='u9'/>"),
              HasSubstr("line 3: A.f is of the unknown type \"u9\""));
  EXPECT_THAT(error("<other><message id='1' abbrev='A'/></other>"), HasSubstr("IMC.xml"));
  EXPECT_THAT(error(""), HasSubstr("line 1"));
}

TEST(ImcXml, GivesFieldsTypesUnitsAndGroups) {
  const Schema own = Schema::from_xml(R"(<messages version="5.4.31">
    <message-groups><message-group abbrev="G"><message-type abbrev="A"/></message-group>
    </message-groups>
    <message id="1000" abbrev="A">
      <field abbrev="speed" type="fp32_t" unit="m/s"><value id="0" abbrev="NONE"/></field>
      <field abbrev="mode" type="uint8_t" unit="Enumerated"/>
      <field abbrev="what" type="message" message-type="G"/></message></messages>)")
                         .value();
  const MessageInfo& a = *own.find(1000);
  ASSERT_EQ(a.fields.size(), 3u);
  EXPECT_EQ(a.fields[0].unit, "m/s");
  EXPECT_EQ(a.fields[1].unit, "");
  EXPECT_THAT(a.fields[2].accepts, testing::ElementsAre(1000));
}

TEST(ImcPacket, OfARunningDuneIsReadAndWrittenByteForByte) {
  const Packet heartbeat = parsed(kHeartbeat);
  EXPECT_EQ(heartbeat.info->name, "Heartbeat");
  EXPECT_EQ(heartbeat.header.timestamp_s, 1.7e9);
  EXPECT_EQ(heartbeat.header.source, 0x4444);
  EXPECT_EQ(encode(message("Heartbeat"), heartbeat.header).value(), kHeartbeat);

  const Message reference = decoded(kReference);
  EXPECT_EQ(reference.integer("flags"), 7);
  EXPECT_EQ(reference.message("speed").info().name, "DesiredSpeed");
  EXPECT_EQ(reference.message("speed").number("value"), 18.0);
  EXPECT_EQ(reference.message("z").number("value"), 150.0);
  EXPECT_EQ(reference.message("z").integer("z_units"), 3);
  EXPECT_EQ(reference.number("lat"), 1.3654144718357513);
  EXPECT_EQ(reference.number("lon"), 0.2727);

  Message speed = message("DesiredSpeed"), z = message("DesiredZ"), made = message("Reference");
  speed.set("value", 18);
  z.set("value", 150).set("z_units", 3);
  made.set("flags", 7).set("lat", 1.3654144718357513).set("lon", 0.2727);
  made.set_message("speed", speed).set_message("z", z);
  EXPECT_EQ(encode(made, {1.7e9, 0x4444, 255, 0x0C0C, 255}).value(), kReference);
}

TEST(ImcPacket, EveryMessageSurvivesTheWireInBothByteOrders) {
  Maker maker(1);
  const Header header{1.7e9, 0x0C0C, 3, 0x4000, 7};
  for (int round = 0; round < 20; ++round)
    for (const MessageInfo& info : schema().messages()) {
      const Message m = maker.any(info);
      std::optional<Bytes> other;
      for (const std::endian order : kOrders) {
        const Bytes bytes = encode(m, header, order).value();
        const Packet packet = parsed(bytes);
        EXPECT_EQ(packet.order, order);
        EXPECT_EQ(packet.header.source, header.source);
        EXPECT_EQ(packet.header.destination, header.destination);
        EXPECT_EQ(packet.header.timestamp_s, header.timestamp_s);
        const Message back = Message::decode(packet, schema()).value();
        EXPECT_EQ(back, m) << info.name;
        EXPECT_EQ(encode(back, packet.header, order).value(), bytes) << info.name;
        EXPECT_EQ(bytes.size(), other.value_or(bytes).size());
        other = bytes;
      }
    }
}

TEST(ImcView, ReadsWhatTheMessageHolds) {
  Maker maker(2);
  for (const MessageInfo& info : schema().messages())
    for (const std::endian order : kOrders) {
      const Message m = maker.any(info);
      const Bytes bytes = encode(m, {}, order).value();
      const View view = View::make(parsed(bytes), schema()).value();
      for (const FieldInfo& f : info.fields) {
        if (f.type == FieldType::Text || f.type == FieldType::Raw) {
          EXPECT_EQ(view.text(f.name), m.bytes(f.name)) << info.name << "." << f.name;
        }
        if (f.type <= FieldType::I64) {
          EXPECT_EQ(view.integer(f.name), m.integer(f.name)) << info.name << "." << f.name;
        }
        if (f.type <= FieldType::F64) {
          const double a = view.number(f.name), b = m.number(f.name);
          EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << info.name << "." << f.name;
        }
      }
    }
}

TEST(ImcPacket, OfAnUnknownTypeIsPassedOn) {
  Bytes bytes = kHeartbeat;
  bytes[2] = 0x78;
  bytes[3] = 0x12;
  bytes = mended(bytes);
  const Packet packet = parsed(bytes);
  EXPECT_EQ(packet.message_id, 0x1278);
  EXPECT_EQ(packet.info, nullptr);
  EXPECT_TRUE(std::ranges::equal(packet.bytes, bytes));
  EXPECT_EQ(View::make(packet, schema()).error().code, ErrorCode::Unsupported);
}

TEST(ImcPacket, WithAnyBitTurnedIsNone) {
  for (std::size_t bit = 0; bit < kReference.size() * 8; ++bit) {
    Bytes bytes = kReference;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    EXPECT_NE(parse_packet(bytes, schema()).outcome, ParseOutcome::Packet) << bit;
  }
}

TEST(ImcPacket, CutAnywhereAsksForMore) {
  for (std::size_t n = 0; n < kReference.size(); ++n)
    EXPECT_EQ(parse_packet(std::span(kReference).first(n), schema()).outcome,
              ParseOutcome::NeedMore);
}

TEST(ImcPacket, LongerThanImcAllowsIsNone) {
  Bytes bytes = kHeartbeat;
  bytes[4] = bytes[5] = 0xFF;
  EXPECT_EQ(parse_packet(bytes, schema()).outcome, ParseOutcome::NotAPacket);
}

TEST(ImcMessage, ErrorsNameTheFieldAndTheByte) {
  const auto error = [](Bytes bytes) {
    return Message::decode(parsed(mended(std::move(bytes))), schema()).error().message;
  };
  Bytes unknown = kReference;  // speed is an inline message at byte 21
  unknown[21] = 0xE7;
  unknown[22] = 0x03;
  EXPECT_THAT(error(unknown), HasSubstr("Reference.speed, byte 21"));
  EXPECT_THAT(error(unknown), HasSubstr("unknown type 999"));
  Bytes other = kReference;
  other[21] = 150;
  other[22] = 0;
  EXPECT_THAT(error(other), HasSubstr("holds a Heartbeat where DesiredSpeed is meant"));
  Bytes longer = kReference;
  longer.insert(longer.end(), 3, 0);
  EXPECT_THAT(error(longer), HasSubstr("Reference, byte 59 of the packet: 3 bytes follow"));
  Bytes shorter = kReference;
  shorter.pop_back();
  EXPECT_THAT(error(shorter), HasSubstr("Reference.radius, byte 55"));
  Bytes text = encode(message("TextMessage").set_bytes("text", "hello"), {}).value();
  text[22] = text[23] = 0xFF;
  EXPECT_THAT(error(text), HasSubstr("TextMessage.text, byte 24"));
  EXPECT_THAT(error(text), HasSubstr("65535 bytes, of which 5 are there"));
  Bytes list = encode(message("MsgList"), {}).value();
  list[20] = list[21] = 0xFF;
  EXPECT_THAT(error(list), HasSubstr("MsgList.msgs, byte 22"));
}

TEST(ImcMessage, InlineMessagesAreNotDeeperThanTheStackBears) {
  Message m = message("RemoteCommand");
  for (int i = 0; i < kMaxDepth; ++i) m = Message(message("RemoteCommand")).set_message("cmd", m);
  Bytes deepest = encode(m, {}).value();
  EXPECT_EQ(decoded(deepest), m);
  m = Message(message("RemoteCommand")).set_message("cmd", m);
  EXPECT_THAT(encode(m, {}).error().message, HasSubstr("16 deep"));
  // The innermost cmd, none until now, becomes one more.
  deepest.resize(deepest.size() - 4);
  Bytes one_more = from_hex("bc00000000000000000000000000ffff0000");
  for (int i = 0; i < 2; ++i) deepest.insert(deepest.end(), one_more.begin(), one_more.end() - 4);
  deepest.insert(deepest.end(), {0xFF, 0xFF, 0, 0});
  EXPECT_THAT(Message::decode(parsed(mended(deepest)), schema()).error().message,
              HasSubstr("more than 16 deep"));
}

TEST(ImcMessage, TooLongForAPacketIsRefused) {
  const auto blob = [](std::size_t n) {
    return encode(message("DevDataBinary").set_bytes("value", std::string(n, 'x')), {});
  };
  EXPECT_TRUE(blob(65535 - 22 - 2).ok());
  EXPECT_EQ(blob(65535 - 22 - 1).error().code, ErrorCode::OutOfRange);
  EXPECT_EQ(blob(65536).error().code, ErrorCode::OutOfRange);
  EXPECT_EQ(encode(Message(), {}).error().code, ErrorCode::InvalidInput);
  const Message wrong = Message(message("Reference")).set_message("speed", message("Heartbeat"));
  EXPECT_THAT(encode(wrong, {}).error().message, HasSubstr("where DesiredSpeed is meant"));
}

TEST(ImcMessage, NumbersAreClampedAndNansKeepTheirBits) {
  Message m = message("Distance");
  m.set("validity", 300);
  EXPECT_EQ(m.integer("validity"), 255);
  m.set("validity", std::nan(""));
  EXPECT_EQ(m.integer("validity"), 0);
  // A signalling NaN, which a conversion to double and back would quieten.
  Bytes bytes = encode(message("Voltage"), {}).value();
  const Bytes nan = from_hex("010080ff");
  std::copy(nan.begin(), nan.end(), bytes.begin() + 20);
  bytes = mended(bytes);
  EXPECT_EQ(encode(decoded(bytes), parsed(bytes).header).value(), bytes);
}

}  // namespace
}  // namespace watersky::imc
