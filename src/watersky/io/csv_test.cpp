// SPDX-License-Identifier: MIT
#include "watersky/io/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace watersky {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Csv, ReadsQuotesCrLfAndAByteOrderMark) {
  const auto t = CsvTable::parse(
      "\xEF\xBB\xBF"
      "file, time_s ,note\r\na.jpg,1.5,\"one, \"\"two\"\"\nthree\"\r\n\r\nb.jpg,2,\r\n",
      "x.csv");
  ASSERT_TRUE(t) << t.error().message;
  EXPECT_THAT(t->columns(), ElementsAre("file", "time_s", "note"));
  ASSERT_EQ(t->rows(), 2u);
  EXPECT_EQ(t->cell(0, 2), "one, \"two\"\nthree");
  EXPECT_EQ(t->number(0, 1).value(), 1.5);
  EXPECT_EQ(t->cell(1, 2), "");
  EXPECT_EQ(t->place(0), "x.csv:2");
  EXPECT_EQ(t->place(1), "x.csv:5");
}

TEST(Csv, NamesFileLineAndColumnOfWhatIsWrong) {
  const auto t = CsvTable::parse("a,b\n1,2\n3,nan\n", "poses.csv").value();
  const auto x = t.number(1, 1);
  ASSERT_FALSE(x);
  EXPECT_THAT(x.error().message, HasSubstr("poses.csv:3: b is \"nan\""));
  EXPECT_THAT(CsvTable::parse("a,b\n1\n", "p").error().message, HasSubstr("p:2: has 1 cells"));
  EXPECT_THAT(CsvTable::parse("a,a\n", "p").error().message, HasSubstr("two columns"));
  EXPECT_THAT(CsvTable::parse("a,\"b\n", "p").error().message, HasSubstr("never closed"));
  EXPECT_THAT(CsvTable::parse("a\n\"b\"c\n", "p").error().message, HasSubstr("inside a cell"));
  EXPECT_THAT(CsvTable::parse("", "p").error().message, HasSubstr("empty"));
  EXPECT_FALSE(CsvTable::parse(std::string("a\n\0\n", 4), "p"));
  EXPECT_THAT(t.require({"a", "c"}).error().message, HasSubstr("no column c"));
  EXPECT_THAT(t.unknown_columns({"b"}), ElementsAre("a"));
}

TEST(Csv, ACellComesBackThroughItsQuotes) {
  for (const std::string text : {"plain", "a,b", "\"", "two\nlines", "", " \"x\" ,"}) {
    const auto t = CsvTable::parse("h,i\n" + csv_cell(text) + ",1\n", "x");
    ASSERT_TRUE(t) << text;
    EXPECT_EQ(t->cell(0, 0), text);
  }
}

TEST(Number, RefusesWhatIsNotWhollyAFiniteNumber) {
  for (const char* bad :
       {"", " ", "nan", "inf", "-inf", "1e999", "1.5x", "x1", "1 2", "+-1", "0x10", "1,5"})
    EXPECT_FALSE(parse_number(bad)) << bad;
  EXPECT_EQ(parse_number("+198.31"), 198.31);
  EXPECT_EQ(parse_number(" -1e-3 "), -1e-3);
}

TEST(TimeSeconds, KeepsNanosecondsThatADoubleWouldLose) {
  EXPECT_EQ(parse_time_seconds("1533430844.480000001")->time_since_epoch().count(),
            1533430844480000001);
  EXPECT_EQ(parse_time_seconds("-0.5")->time_since_epoch().count(), -500000000);
  EXPECT_EQ(parse_time_seconds("1.0000000005")->time_since_epoch().count(), 1000000001);
  EXPECT_EQ(parse_time_seconds("7")->time_since_epoch().count(), 7000000000);
  EXPECT_EQ(parse_time_seconds("1.5e3")->time_since_epoch().count(), 1500000000000);
  for (const char* bad :
       {"", ".", "-", "1.2.3", "nan", "99999999999", "1e300", "12:00", "99999999999999999999999"})
    EXPECT_FALSE(parse_time_seconds(bad)) << bad;
}

TEST(TimeSeconds, FormatAndParseUndoEachOther) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 10000; ++i) {
    const Time t(Duration(std::uniform_int_distribution<std::int64_t>(
        -9'000'000'000'000'000'000, 9'000'000'000'000'000'000)(rng)));
    EXPECT_EQ(parse_time_seconds(format_time_seconds(t)), t);
  }
}

TEST(Number, FormatAndParseUndoEachOther) {
  std::mt19937_64 rng(4);
  for (int i = 0; i < 10000; ++i) {
    const double x = std::ldexp(std::uniform_real_distribution(-1.0, 1.0)(rng),
                                std::uniform_int_distribution(-60, 60)(rng));
    EXPECT_EQ(parse_number(format_number(x)), x);
  }
}

}  // namespace
}  // namespace watersky
