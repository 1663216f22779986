// SPDX-License-Identifier: MIT
/// convert, and map of what it makes, as a user calls them.
#include <gmock/gmock.h>

#include "cli_support.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

std::string quoted(const fs::path& path) { return " '" + path.string() + "'"; }

/// The height of the sea in the small flight, which a bag cannot say.
std::string sea_level() {
  const std::string yaml = read_text(small_flight() / "flight.yaml");
  const auto number = [&](const std::string& key) {
    const auto at = yaml.find(key + ": ");
    return at == std::string::npos ? 0.0 : std::stod(yaml.substr(at + key.size() + 2));
  };
  std::ostringstream out;
  out.precision(17);
  out << "ellipsoid:" << number("height_ellipsoid_m") + number("sea_above_datum_m");
  return out.str();
}

void expect_same_map(const fs::path& a, const fs::path& b) {
  const Outcome diff = watersky("diff" + quoted(a) + quoted(b) + " --json");
  ASSERT_EQ(diff.status, 0) << diff.err;
  const auto json = diff.json();
  for (const char* change : {"became_ice", "became_water", "new_ice", "new_water", "only_before"})
    EXPECT_EQ(json["changes"][change]["cells"], 0) << change;
  EXPECT_GT(json["changes"]["stayed_ice"]["cells"], 0);
}

TEST(Convert, AFlightMapsTheSameFromEveryForm) {
  const TemporaryFolder folder;
  const fs::path mcap = folder.path() / "f.mcap", bag = folder.path() / "f.bag",
                 again = folder.path() / "again";
  const Outcome to_mcap = watersky("convert" + quoted(small_flight()) + quoted(mcap) + " --json");
  ASSERT_EQ(to_mcap.status, 0) << to_mcap.err;
  EXPECT_EQ(to_mcap.json()["kind"], "mcap");
  EXPECT_GT(to_mcap.json()["frames"], 3);
  EXPECT_EQ(to_mcap.json()["left_out"].size(), 0u);
  ASSERT_EQ(watersky("convert" + quoted(mcap) + quoted(again)).status, 0);
  const Outcome to_bag = watersky("convert" + quoted(mcap) + quoted(bag));
  ASSERT_EQ(to_bag.status, 0) << to_bag.err;
  EXPECT_THAT(to_bag.err, HasSubstr("--sea-level"));

  // Back as a folder, images, times and poses are the same to the byte.
  EXPECT_EQ(images_of(again).size(), images_of(small_flight()).size());
  for (const fs::path& image : images_of(small_flight()))
    EXPECT_TRUE(read_text(image) == read_text(again / "images" / image.filename())) << image;
  EXPECT_EQ(read_text(again / "frames.csv"), read_text(small_flight() / "frames.csv"));
  EXPECT_EQ(read_text(again / "poses.csv"), read_text(small_flight() / "poses.csv"));

  const auto map = [&](const fs::path& flight, const std::string& more = "") {
    fs::path out = folder.path() / ("map_of_" + flight.filename().string());
    const Outcome made =
        watersky("map" + quoted(flight) + " -o" + quoted(out) + " --no-align --json" + more);
    EXPECT_EQ(made.status, 0) << made.err;
    return out;
  };
  const fs::path before = map(small_flight());
  expect_same_map(before, map(mcap));
  expect_same_map(before, map(again));
  expect_same_map(before, map(bag, " --sea-level " + sea_level()));
}

TEST(Convert, WhatALogDoesNotSayIsToldAndThenTheMapIsTheSame) {
  const TemporaryFolder folder;
  const fs::path before = folder.path() / "before", after = folder.path() / "after";
  const auto map = [&](const fs::path& flight, const fs::path& out, const std::string& more) {
    const Outcome made =
        watersky("map" + quoted(flight) + " -o" + quoted(out) + " --no-align" + more);
    ASSERT_EQ(made.status, 0) << made.err;
  };
  map(small_flight(), before, "");
  for (const char* log : {"tlog", "bin", "lsf"}) {
    const fs::path made = folder.path() / log;
    const Outcome converted = watersky("convert" + quoted(small_flight()) + quoted(made) +
                                       " --as-log " + log + " --json");
    ASSERT_EQ(converted.status, 0) << converted.err;
    EXPECT_EQ(converted.json()["kind"], "photographs_with_log");
    const auto from = converted.err.find("give ") + 5, to = converted.err.find(" when you map");
    ASSERT_LT(from, to) << converted.err;
    fs::remove_all(after);
    map(made, after, " " + converted.err.substr(from, to - from));
    const auto changes =
        watersky("diff" + quoted(before) + quoted(after) + " --json").json()["changes"];
    const auto cells = [&](const char* change) { return changes[change]["cells"].get<double>(); };
    const double same = cells("stayed_ice") + cells("stayed_water");
    EXPECT_GT(same, 1000);
    for (const char* change : {"became_ice", "became_water", "new_ice", "new_water", "only_before"})
      EXPECT_LT(cells(change), 0.01 * same) << log << ": " << change;
  }
}

TEST(Convert, RefusesToReplaceWhatItDidNotMake) {
  const TemporaryFolder folder;
  const fs::path mcap = folder.path() / "f.mcap";
  write_text(mcap, "something");
  const Outcome refused = watersky("convert" + quoted(small_flight()) + quoted(mcap));
  expect_one_line_error(refused, 1);
  EXPECT_EQ(read_text(mcap), "something");
  EXPECT_EQ(watersky("convert" + quoted(small_flight()) + quoted(mcap) + " --overwrite").status, 0);
  EXPECT_GT(fs::file_size(mcap), 1000u);
  fs::create_directory(folder.path() / "mine");
  expect_one_line_error(watersky("convert" + quoted(small_flight()) +
                                 quoted(folder.path() / "mine") + " --overwrite"),
                        1);
  EXPECT_EQ(watersky("convert" + quoted(mcap) + quoted(mcap) + " --overwrite").status, 2);
  expect_one_line_error(
      watersky("convert" + quoted(folder.path() / "none.bag") + quoted(folder.path() / "x.mcap")),
      1);
}

TEST(Convert, OfARecordingWithNothingInItMakesNothing) {
  const TemporaryFolder folder;
  const fs::path mcap = folder.path() / "f.mcap", out = folder.path() / "out.mcap";
  ASSERT_EQ(watersky("convert" + quoted(small_flight()) + quoted(mcap)).status, 0);
  fs::resize_file(mcap, 3000);
  const Outcome refused = watersky("convert" + quoted(mcap) + quoted(out) + " --quiet");
  expect_one_line_error(refused, 1);
  EXPECT_THAT(refused.err, HasSubstr("holds neither frames nor poses"));
  EXPECT_FALSE(fs::exists(out));
}

TEST(Convert, HelpShowsTheFormsAndEveryOption) {
  const Outcome help = watersky("convert --help");
  EXPECT_EQ(help.status, 0);
  for (const char* word : {".mcap", ".bag", "--jpeg", "--overwrite", "--as-log", "--image-topic",
                           "--camera-frame", "--map-frame", "--datum"})
    EXPECT_THAT(help.out, HasSubstr(word));
}

TEST(Inspect, SaysWhatAnMcapFileHoldsAndWhatACrashLeft) {
  const TemporaryFolder folder;
  const fs::path mcap = folder.path() / "f.mcap";
  ASSERT_EQ(watersky("convert" + quoted(small_flight()) + quoted(mcap)).status, 0);
  auto whole = watersky("inspect" + quoted(mcap) + " --json").json();
  EXPECT_EQ(whole["kind"], "mcap");
  EXPECT_GT(whole["counts"]["/camera/image"], 3);
  EXPECT_EQ(whole["facts"]["topic /fix"], "foxglove.LocationFix, protobuf");
  EXPECT_TRUE(whole["extent"].is_object());
  EXPECT_EQ(whole["notes"].size(), 0u);
  fs::resize_file(mcap, fs::file_size(mcap) / 2);
  auto cut = watersky("inspect" + quoted(mcap) + " --json").json();
  EXPECT_GT(cut["counts"]["/camera/image"], 0);
  EXPECT_LT(cut["counts"]["/camera/image"], whole["counts"]["/camera/image"]);
  EXPECT_THAT(cut["notes"][0].get<std::string>(), HasSubstr("byte "));
}

}  // namespace
}  // namespace watersky::test
