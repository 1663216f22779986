// SPDX-License-Identifier: MIT
/// The verbs on a flight that is right.
#include <gmock/gmock.h>

#include "cli_support.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

TEST(Map, WritesAllThatTheReadmePromises) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "map";
  const Outcome o =
      watersky("map '" + small_flight().string() + "' -o '" + out.string() + "' --json");
  ASSERT_EQ(o.status, 0) << o.err;
  for (const char* file : {"probability.tif", "looks.tif", "last_seen.tif", "mosaic.tif",
                           "ice.gpkg", "icebergs.geojson", "report.html", "run.json"})
    EXPECT_GT(fs::file_size(out / file), 0u) << file;
  const auto run = nlohmann::json::parse(read_text(out / "run.json"));
  EXPECT_EQ(run["frames"], o.json()["frames"]);
  EXPECT_EQ(run["frames"]["used"], run["frames"]["total"]);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1)
      << "no temporary folder stays";
}

TEST(Map, SmoothsWhenAskedAndLeavesTheRawMapAsItIs) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "map", raw = folder.path() / "raw";
  const std::string map = "map '" + small_flight().string() + "' -o '";
  ASSERT_EQ(watersky(map + raw.string() + "' --quiet").status, 0);
  const Outcome o = watersky(map + out.string() + "' --smooth --coupling 0.25");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("coupling 0.250 (given)"));
  for (const char* file : {"smoothed.tif", "most_likely.tif", "smoothed.qml", "most_likely.qml"}) {
    EXPECT_TRUE(fs::exists(out / file)) << file;
    EXPECT_FALSE(fs::exists(raw / file)) << file;
  }
  EXPECT_TRUE(read_text(out / "probability.tif") == read_text(raw / "probability.tif"));
  EXPECT_EQ(nlohmann::json::parse(read_text(out / "run.json"))["smoothing"]["coupling"], 0.25);
  EXPECT_EQ(watersky(map + (folder.path() / "no").string() + "' --smooth --coupling 99").status, 2);
}

TEST(Map, TheSameWhateverTheNumberOfThreads) {
  const TemporaryFolder folder;
  std::string rasters[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const fs::path out = folder.path() / std::to_string(threads);
    ASSERT_EQ(watersky("map '" + small_flight().string() + "' -o '" + out.string() +
                       "' --threads " + std::to_string(threads))
                  .status,
              0);
    rasters[threads - 1] = read_text(out / "probability.tif");
  }
  EXPECT_TRUE(rasters[0] == rasters[1]);
}

TEST(Map, TheSameWhateverTheOrderOfTheFrames) {
  const TemporaryFolder folder;
  const fs::path flight = copy_of_flight(folder);
  std::istringstream in(read_text(flight / "frames.csv"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  std::reverse(lines.begin() + 1, lines.end());
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  write_text(flight / "frames.csv", text);
  const fs::path out = folder.path() / "map", straight = folder.path() / "straight";
  ASSERT_EQ(watersky("map '" + flight.string() + "' -o '" + out.string() + "'").status, 0);
  ASSERT_EQ(watersky("map '" + small_flight().string() + "' -o '" + straight.string() + "'").status,
            0);
  EXPECT_TRUE(read_text(out / "looks.tif") == read_text(straight / "looks.tif"));
  EXPECT_TRUE(read_text(out / "probability.tif") == read_text(straight / "probability.tif"));
}

TEST(Map, AreasAreThoseOnTheGround) {
  const TemporaryFolder folder;
  double area_m2[2];
  const char* const projections[] = {"EPSG:32633", "EPSG:3413"};
  for (int i = 0; i < 2; ++i) {
    const Outcome o = watersky("map '" + small_flight().string() + "' -o '" +
                               (folder.path() / std::to_string(i)).string() +
                               "' --json --projection " + projections[i]);
    ASSERT_EQ(o.status, 0) << o.err;
    area_m2[i] = o.json()["figures"]["seen_area_m2"];
  }
  EXPECT_NEAR(area_m2[0] / area_m2[1], 1.0, 0.01);  // in grid metres: 4 % apart
}

TEST(Map, OverwriteReplacesAMapOfOurs) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "map";
  const std::string call =
      "map '" + small_flight().string() + "' -o '" + out.string() + "' --no-mosaic";
  ASSERT_EQ(watersky(call).status, 0);
  EXPECT_FALSE(fs::exists(out / "mosaic.tif"));
  EXPECT_EQ(watersky(call).status, 1);
  EXPECT_EQ(watersky(call + " --overwrite").status, 0);
}

TEST(Map, QuietPrintsNothing) {
  const TemporaryFolder folder;
  const Outcome o = watersky("map '" + small_flight().string() + "' -o '" +
                             (folder.path() / "map").string() + "' --quiet");
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.out + o.err, "");
}

TEST(Simulate, TheSameSeedIsTheSameFlightAndAnotherIsNot) {
  const TemporaryFolder folder;
  const std::string small =
      " --legs 1 --leg-length-m 20 --width-px 64 --height-px 48 --focal-px 60 --quiet";
  for (const char* seed : {"1", "1 ", "2"}) {
    const std::string name(seed == std::string("1 ") ? "again" : seed);
    ASSERT_EQ(watersky("simulate '" + (folder.path() / name).string() + "' --seed " + seed + small)
                  .status,
              0);
  }
  const auto first = [&](const char* name) {
    return read_text(images_of(folder.path() / name).front());
  };
  EXPECT_TRUE(first("1") == first("again"));
  EXPECT_FALSE(first("1") == first("2"));
  EXPECT_TRUE(fs::exists(folder.path() / "1" / "truth" / "truth.tif"));
  EXPECT_TRUE(fs::exists(folder.path() / "1" / "truth" / "objects.csv"));
}

TEST(Map, ForgetsWhenAskedAndSaysSoInReportFileAndInspection) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "map";
  const Outcome made = watersky("map '" + small_flight().string() + "' -o '" + out.string() +
                                "' --no-align --half-life-s 30");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_NE(read_text(out / "report.html").find("Cells forget: half of what is known"),
            std::string::npos);
  const auto facts = watersky("inspect '" + (out / "map.wsmap").string() + "' --json").json();
  EXPECT_EQ(facts.value(nlohmann::json::json_pointer("/facts/half_life_s"), ""), "30");
}

TEST(Inspect, SaysWhatAFlightHolds) {
  const Outcome o = watersky("inspect '" + small_flight().string() + "' --json");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(o.json().is_object()) << o.out;
  EXPECT_EQ(watersky("inspect /no/such/file").status, 1);
}

TEST(Help, ShowsUnitsAndDefaults) {
  for (const char* verb : {"map", "align", "segment", "simulate", "inspect"}) {
    const Outcome o = watersky(std::string(verb) + " --help");
    EXPECT_EQ(o.status, 0);
    EXPECT_THAT(o.out, HasSubstr("--json"));
  }
  const Outcome map = watersky("map --help");
  EXPECT_THAT(map.out, HasSubstr("--cell-m"));
  EXPECT_THAT(map.out, HasSubstr("[m]"));
  EXPECT_THAT(map.out, HasSubstr("0.5"));
}

}  // namespace
}  // namespace watersky::test
