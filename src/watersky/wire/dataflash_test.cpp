// SPDX-License-Identifier: MIT
#include "watersky/wire/dataflash.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

#include "support/dataflash_maker.hpp"
#include "support/hex.hpp"
#include "support/real_data.hpp"

namespace watersky::dataflash {
namespace {

using test::DataflashMaker;

// The first record of any log, as ArduPlane 4.7 wrote it.
const Bytes kFmtOfFmt = [] {
  Bytes bytes = test::from_hex("a395808059464d5400");  // type 128, length 89, "FMT"
  const std::string format = "BBnNZ", columns = "Type,Length,Name,Format,Columns";
  bytes.insert(bytes.end(), format.begin(), format.end());
  bytes.resize(bytes.size() + 16 - format.size());
  bytes.insert(bytes.end(), columns.begin(), columns.end());
  bytes.resize(89);
  return bytes;
}();

const Format& of(const std::vector<Format>& formats, std::string_view name) {
  const auto it =
      std::find_if(formats.begin(), formats.end(), [&](const Format& f) { return f.name == name; });
  EXPECT_NE(it, formats.end()) << name;
  return *it;
}

TEST(Dataflash, EveryLetterIsReadWithItsScale) {
  DataflashMaker maker;
  maker.format(1, "NUM", "bBMhHiIqQfdcCeEL", "b,B,M,h,H,i,I,q,Q,f,d,c,C,e,E,L");
  maker.format(2, "TXT", "gnNZa", "g,n,N,Z,a");
  maker.record(1, std::int8_t{-5}, std::uint8_t{200}, std::uint8_t{7}, std::int16_t{-300},
               std::uint16_t{60000}, std::int32_t{-70000}, std::uint32_t{4000000000u},
               std::int64_t{-5000000000}, std::uint64_t{5000000000}, 1.5f, -2.25,
               std::int16_t{-6059}, std::uint16_t{34524}, std::int32_t{14394},
               std::uint32_t{3000000000u}, std::int32_t{782311375});
  maker.record(2, std::uint16_t{0xC000}, DataflashMaker::text<4>("abcd"),
               DataflashMaker::text<16>("name"), DataflashMaker::text<64>("hello"),
               DataflashMaker::text<64>(""));
  Reader reader(maker.bytes());
  std::map<std::string, int> seen;
  while (const auto record = reader.next()) {
    ++seen[record->format->name];
    if (record->format->name == "NUM") {
      const std::map<std::string, double> expected = {
          {"b", -5},     {"B", 200},    {"M", 7},   {"h", -300},      {"H", 60000}, {"i", -70000},
          {"I", 4e9},    {"q", -5e9},   {"Q", 5e9}, {"f", 1.5},       {"d", -2.25}, {"c", -60.59},
          {"C", 345.24}, {"e", 143.94}, {"E", 3e7}, {"L", 78.2311375}};
      for (const auto& [name, value] : expected)
        EXPECT_NEAR(record->number(name), value, 1e-9) << name;
      EXPECT_EQ(record->integer("L"), 782311375);
      EXPECT_EQ(record->integer("Q"), 5000000000);
    }
    if (record->format->name == "TXT") {
      EXPECT_EQ(record->number("g"), -2.0);
      EXPECT_EQ(record->text("n"), "abcd");
      EXPECT_EQ(record->text("N"), "name");
      EXPECT_EQ(record->text("Z"), "hello");
    }
  }
  EXPECT_EQ(seen["NUM"], 1);
  EXPECT_EQ(seen["TXT"], 1);
  EXPECT_EQ(reader.skipped_bytes() + reader.truncated_bytes(), 0u);
}

TEST(Dataflash, BeginsWithFmtDescribingItself) {
  Reader reader(kFmtOfFmt);
  const auto record = reader.next();
  ASSERT_TRUE(record);
  EXPECT_EQ(record->text("Name"), "FMT");
  EXPECT_EQ(record->integer("Length"), 89);
  EXPECT_EQ(record->text("Columns"), "Type,Length,Name,Format,Columns");
  EXPECT_FALSE(reader.next());
}

TEST(Dataflash, OfAScaleToldTwiceOneIsApplied) {
  DataflashMaker log;
  log.format(1, "X", "QcLf", "TimeUS,Alt,Lat,Cm");
  log.format(2, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds");
  log.format(3, "UNIT", "QbZ", "TimeUS,Id,Label");
  log.format(4, "MULT", "Qbd", "TimeUS,Id,Mult");
  log.record(2, std::uint64_t{0}, std::uint8_t{1}, DataflashMaker::text<16>("smDm"),
             DataflashMaker::text<16>("FBGB"));
  for (const auto& [id, label] : {std::pair('s', "s"), {'m', "m"}, {'D', "deglatitude"}})
    log.record(3, std::uint64_t{0}, static_cast<std::int8_t>(id), DataflashMaker::text<64>(label));
  for (const auto& [id, factor] : {std::pair('F', 1e-6), {'B', 1e-2}, {'G', 1e-7}})
    log.record(4, std::uint64_t{0}, static_cast<std::int8_t>(id), factor);
  Reader reader(log.bytes());
  while (reader.next()) {
  }
  const auto formats = reader.formats();
  const auto& x = of(formats, "X").fields;
  EXPECT_EQ(x[0].unit, "s");
  EXPECT_EQ(x[0].multiplier, 1e-6);
  EXPECT_EQ(x[1].multiplier, 1.0);  // 'c' has done it
  EXPECT_EQ(x[2].unit, "deglatitude");
  EXPECT_EQ(x[2].multiplier, 1.0);
  EXPECT_EQ(x[3].multiplier, 1e-2);
}

TEST(Dataflash, WithoutFmtNothingIsRead) {
  DataflashMaker log;
  log.record(7, std::uint64_t{1}, 2.0f);
  Reader reader(log.bytes());
  EXPECT_FALSE(reader.next());
  EXPECT_TRUE(reader.formats().empty());
  EXPECT_EQ(reader.skipped_bytes(), log.bytes().size());
  EXPECT_THAT(no_format_error(log.bytes()).message,
              testing::HasSubstr("byte 0: a record of type 7, but no FMT"));
  EXPECT_THAT(no_format_error(Bytes(10, 0)).message, testing::HasSubstr("begins with a3 95"));
}

TEST(Dataflash, AFormatThatContradictsItselfIsPassedOver) {
  DataflashMaker log;
  for (const auto& [type, letters, columns, length] :
       {std::tuple(1, "Qf", "TimeUS", 15), std::tuple(2, "Q", "TimeUS,More", 11),
        std::tuple(3, "Q?", "TimeUS,What", 15), std::tuple(4, "Qf", "TimeUS,F", 16)}) {
    log.format(static_cast<std::uint8_t>(type), "BAD", letters, columns,
               static_cast<std::uint8_t>(length));
    Bytes& bytes = log.bytes();
    bytes.insert(bytes.end(), {0xA3, 0x95, static_cast<std::uint8_t>(type)});
    bytes.resize(bytes.size() + static_cast<std::size_t>(length) - 3);
  }
  Reader reader(log.bytes());
  std::size_t bad = 0;
  while (const auto record = reader.next())
    if (record->format->name == "BAD") {
      ++bad;
      EXPECT_TRUE(record->format->fields.empty());
      EXPECT_FALSE(record->format->has("TimeUS"));
    }
  EXPECT_EQ(bad, 4u);
  EXPECT_EQ(reader.skipped_bytes(), 0u);
}

TEST(Dataflash, GoesOnBehindGarbageAndSaysWhereItWas) {
  DataflashMaker log;
  log.format(1, "X", "Qf", "TimeUS,V");
  log.record(1, std::uint64_t{1}, 1.0f);
  const std::size_t at = log.bytes().size();
  const Bytes garbage = test::from_hex("00a39509a3950100a3");
  log.bytes().insert(log.bytes().end(), garbage.begin(), garbage.end());
  log.record(1, std::uint64_t{2}, 2.0f);
  log.record(1, std::uint64_t{3}, 3.0f);
  Reader reader(log.bytes());
  std::vector<double> values;
  while (const auto record = reader.next())
    if (record->format->name == "X") values.push_back(record->number("V"));
  EXPECT_THAT(values, testing::ElementsAre(1, 2, 3));
  EXPECT_EQ(reader.gaps(), 1u);
  EXPECT_EQ(reader.first_gap_at(), at);
  EXPECT_EQ(reader.skipped_bytes(), 9u);
}

TEST(Dataflash, ACutEndIsToldFromGarbage) {
  DataflashMaker log;
  log.format(1, "X", "Qf", "TimeUS,V");
  const std::size_t head = log.bytes().size();
  log.record(1, std::uint64_t{1}, 1.0f);
  for (std::size_t n = head; n < log.bytes().size(); ++n) {
    Reader reader(std::span<const std::uint8_t>(log.bytes()).first(n));
    while (reader.next()) {
    }
    EXPECT_EQ(reader.truncated_bytes(), n - head);
    EXPECT_EQ(reader.skipped_bytes(), 0u);
  }
}

TEST(DataflashLog, OfArduPlaneIsReadToItsCutEnd) {
  const auto folder = test::real_data("autopilot_logs");
  if (!folder) GTEST_SKIP() << "the real data is not here";
  std::ifstream in(*folder / "arduplane_sitl_cam.BIN", std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(in), {}};
  Reader reader(bytes);
  std::map<std::string, std::size_t> seen;
  while (const auto record = reader.next()) {
    ++seen[record->format->name];
    EXPECT_FALSE(record->format->fields.empty()) << record->format->name;
    if (record->format->name == "CAM" && seen["CAM"] == 1) {
      EXPECT_EQ(record->integer("TimeUS"), 77884667);
      EXPECT_NEAR(record->number("Lat"), 78.2311375, 1e-9);
      EXPECT_NEAR(record->number("R"), -60.59, 1e-9);
      EXPECT_NEAR(record->number("Y"), 18.83, 1e-9);
    }
  }
  EXPECT_EQ(seen["CAM"], 25u);
  EXPECT_EQ(seen["ATT"], 1502u);
  EXPECT_EQ(seen["POS"], 1501u);
  EXPECT_EQ(seen["GPS"], 300u);
  EXPECT_EQ(seen["FMT"], 194u);
  EXPECT_EQ(reader.skipped_bytes(), 0u);
  EXPECT_EQ(reader.truncated_bytes(), 34u);  // the simulator was stopped in a record of 42
  const auto formats = reader.formats();
  const Format& pos = of(formats, "POS");
  EXPECT_EQ(pos.fields[pos.index("Lat")].unit, "deglatitude");
  EXPECT_EQ(pos.fields[pos.index("Alt")].unit, "m");
  EXPECT_NEAR(of(formats, "GPS").fields[0].multiplier, 1e-6, 1e-12);
}

}  // namespace
}  // namespace watersky::dataflash
