// SPDX-License-Identifier: MIT
/// merge, diff and map --continue, as a user calls them.
#include <gmock/gmock.h>

#include "cli_support.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

std::string quoted(const fs::path& path) { return " '" + path.string() + "'"; }

/// Two flights over neighbouring seas, mapped; made once.
struct TwoMaps {
  TemporaryFolder folder;
  fs::path a = folder.path() / "a", b = folder.path() / "b", second = folder.path() / "flight_b";
  TwoMaps() {
    const Outcome simulated =
        watersky("simulate" + quoted(second) +
                 " --legs 1 --leg-length-m 120 --width-px 320 --height-px 256 --focal-px 300 "
                 "--supersampling 1 --seed 7 --quiet");
    EXPECT_EQ(simulated.status, 0) << simulated.err;
    for (const auto& [flight, out] : {std::pair(small_flight(), a), std::pair(second, b)}) {
      const Outcome made = watersky("map" + quoted(flight) + " -o" + quoted(out) + " --no-align");
      EXPECT_EQ(made.status, 0) << made.err;
    }
  }
};
const TwoMaps& two_maps() {
  static const TwoMaps maps;
  return maps;
}

TEST(Merge, InWhateverOrderAndHoweverOftenMakesTheSameMap) {
  const TemporaryFolder folder;
  const TwoMaps& maps = two_maps();
  const fs::path ab = folder.path() / "ab", ba = folder.path() / "ba";
  const Outcome first =
      watersky("merge" + quoted(maps.a) + quoted(maps.b) + " -o" + quoted(ab) + " --json");
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(first.json()["sources"].size(), 2u);
  EXPECT_GT(first.json()["figures"]["seen_cells"], 0);
  const Outcome second = watersky("merge" + quoted(maps.b / "map.wsmap") + quoted(ab) +
                                  quoted(maps.a) + " -o" + quoted(ba) + " --json");
  ASSERT_EQ(second.status, 0) << second.err;
  EXPECT_EQ(second.json()["figures"], first.json()["figures"]);
  for (const char* file : {"probability.tif", "looks.tif", "last_seen.tif"})
    EXPECT_TRUE(read_text(ab / file) == read_text(ba / file)) << file;
}

TEST(Merge, OfOneMapIsThatMap) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  ASSERT_EQ(watersky("merge" + quoted(two_maps().a) + " -o" + quoted(out)).status, 0);
  const Outcome diff = watersky("diff" + quoted(two_maps().a) + quoted(out) + " --json");
  ASSERT_EQ(diff.status, 0) << diff.err;
  for (const char* change : {"became_ice", "became_water", "new_ice", "new_water", "only_before"})
    EXPECT_EQ(diff.json()["changes"][change]["cells"], 0) << change;
  EXPECT_GT(diff.json()["changes"]["stayed_ice"]["area_m2"], 0);
}

TEST(Merge, MappedTwiceAFlightCountsOnce) {
  const TemporaryFolder folder;
  const fs::path again = folder.path() / "again", out = folder.path() / "out";
  ASSERT_EQ(watersky("map" + quoted(small_flight()) + " -o" + quoted(again) + " --no-align").status,
            0);
  const Outcome merged =
      watersky("merge" + quoted(two_maps().a) + quoted(again) + " -o" + quoted(out) + " --json");
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_EQ(merged.json()["sources"].size(), 1u);
  EXPECT_TRUE(read_text(out / "looks.tif") != "");
  const Outcome diff = watersky("diff" + quoted(two_maps().a) + quoted(out) + " --json");
  EXPECT_EQ(diff.json()["changes"]["became_ice"]["cells"], 0);
}

TEST(Map, ContinuedIsTheMergeOfBoth) {
  const TemporaryFolder folder;
  const TwoMaps& maps = two_maps();
  const fs::path merged = folder.path() / "merged", continued = folder.path() / "continued";
  ASSERT_EQ(watersky("merge" + quoted(maps.a) + quoted(maps.b) + " -o" + quoted(merged)).status, 0);
  const Outcome o = watersky("map" + quoted(maps.second) + " -o" + quoted(continued) +
                             " --no-align --continue" + quoted(maps.a));
  ASSERT_EQ(o.status, 0) << o.err;
  const Outcome diff = watersky("diff" + quoted(merged) + quoted(continued) + " --json");
  ASSERT_EQ(diff.status, 0) << diff.err;
  for (const char* change : {"became_ice", "became_water", "new_ice", "new_water", "only_before"})
    EXPECT_EQ(diff.json()["changes"][change]["cells"], 0) << change;
  EXPECT_EQ(watersky("map" + quoted(maps.second) + " -o" + quoted(folder.path() / "x") +
                     " --cell-m 1 --continue" + quoted(maps.a))
                .status,
            2);
}

TEST(Diff, WritesARasterOfTheChanges) {
  const TemporaryFolder folder;
  const fs::path tif = folder.path() / "changes.tif";
  const Outcome o =
      watersky("diff" + quoted(two_maps().a) + quoted(two_maps().b) + " -o" + quoted(tif));
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("became ice"));
  EXPECT_GT(fs::file_size(tif), 0u);
  EXPECT_TRUE(fs::exists(folder.path() / "changes.qml"));
}

TEST(Merge, RefusesMapsOfOtherCellsAndWhatIsNoMap) {
  const TemporaryFolder folder;
  const fs::path coarse = folder.path() / "coarse", out = folder.path() / "out";
  ASSERT_EQ(
      watersky("map" + quoted(small_flight()) + " -o" + quoted(coarse) + " --no-align --cell-m 1")
          .status,
      0);
  const Outcome other =
      watersky("merge" + quoted(two_maps().a) + quoted(coarse) + " -o" + quoted(out));
  expect_one_line_error(other, 1);
  EXPECT_THAT(other.err, HasSubstr("do not share a grid"));
  write_text(folder.path() / "no.wsmap", "no map at all, but long enough to be read");
  for (const fs::path& path :
       {folder.path() / "no.wsmap", folder.path(), folder.path() / "nowhere"})
    expect_one_line_error(watersky("merge" + quoted(path) + " -o" + quoted(out)), 1);
  EXPECT_FALSE(fs::exists(out));
}

TEST(Merge, TakesWhatIsWholeOfADamagedMapWhenAsked) {
  const TemporaryFolder folder;
  const fs::path cut = folder.path() / "cut.wsmap", out = folder.path() / "out";
  fs::copy_file(two_maps().a / "map.wsmap", cut);
  fs::resize_file(cut, fs::file_size(cut) - 100);
  const Outcome refused = watersky("merge" + quoted(cut) + " -o" + quoted(out));
  expect_one_line_error(refused, 1);
  EXPECT_THAT(refused.err, HasSubstr("merge --recover"));
  const Outcome taken = watersky("merge" + quoted(cut) + " -o" + quoted(out) + " --recover");
  EXPECT_EQ(taken.status, 0) << taken.err;
  EXPECT_THAT(taken.err, HasSubstr("whole tiles were found"));
}

}  // namespace
}  // namespace watersky::test
