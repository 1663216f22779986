// SPDX-License-Identifier: MIT
#include "watersky/store/overviews.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/map_tiles.hpp"
#include "watersky/map/log_odds.hpp"

namespace watersky {
namespace {

TEST(Overviews, ACellIsTheMeanOfTheKnownCellsBelowIt) {
  MapTile tile;
  test::look(tile, 10, 20, kEvidenceUnits, test::at_second(1));       // P = 0.731
  test::look(tile, 11, 20, -2 * kEvidenceUnits, test::at_second(1));  // P = 0.119
  Overviews overviews(0.0);
  overviews.change({2, 4}, tile);
  overviews.refresh();
  const OverviewTile* above = overviews.tile(1, {1, 2});
  ASSERT_NE(above, nullptr);
  const double expected = (probability(1.0) + probability(-2.0)) / 2;
  EXPECT_NEAR(above->cells[10 * 256 + 5] / OverviewTile::kSteps, expected, 1.0 / 254);
  EXPECT_EQ(above->cells[10 * 256 + 6], OverviewTile::kUnseen);
}

TEST(Overviews, TheQuarterOfATileIsItsPlaceAlsoWestAndNorthOfTheAnchor) {
  for (const TileIndex index : {TileIndex{-1, -1}, {-2, -1}, {-3, 0}, {0, 5}}) {
    MapTile tile;
    test::look(tile, 0, 0, 7000, test::at_second(1));
    Overviews overviews(0.0);
    overviews.change(index, tile);
    overviews.refresh();
    const TileIndex above = half_of(index);
    const OverviewTile* found = overviews.tile(1, above);
    ASSERT_NE(found, nullptr);
    const int column = (index.column - 2 * above.column) * 128;
    const int row = (index.row - 2 * above.row) * 128;
    EXPECT_NE(found->cells[static_cast<std::size_t>(row * 256 + column)], OverviewTile::kUnseen);
  }
}

TEST(Overviews, ChangesBringTheSameLevelsAsMakingThemAnew) {
  std::mt19937 random(6);
  std::map<TileIndex, MapTile> map;
  Overviews live(log_odds(0.3));
  for (int step = 0; step < 40; ++step) {
    for (int i = 0; i < 3; ++i) {
      const TileIndex index{std::uniform_int_distribution(-6, 6)(random),
                            std::uniform_int_distribution(-6, 6)(random)};
      test::frame(map[index], random, 30, 40, 90, 70, 500, test::at_second(step));
      live.change(index, map[index]);
    }
    live.refresh();
  }
  Overviews anew(log_odds(0.3));
  for (const auto& [index, tile] : map) anew.change(index, tile);
  anew.refresh();
  ASSERT_EQ(live.levels(), anew.levels());
  ASSERT_GE(live.levels(), 2);
  for (int level = 1; level <= live.levels(); ++level)
    for (int c = -8; c < 8; ++c)
      for (int r = -8; r < 8; ++r) {
        const OverviewTile *a = live.tile(level, {c, r}), *b = anew.tile(level, {c, r});
        ASSERT_EQ(a == nullptr, b == nullptr);
        if (a) {
          EXPECT_EQ(*a, *b);
        }
      }
}

TEST(Overviews, AChangeTouchesOneTileALevelWhateverTheSizeOfTheMap) {
  MapTile tile;
  test::look(tile, 1, 1, 100, test::at_second(1));
  Overviews overviews(0.0);
  for (int c = -20; c < 20; ++c)
    for (int r = -20; r < 20; ++r) overviews.change({c, r}, tile);
  overviews.refresh();
  test::look(tile, 1, 1, 100, test::at_second(2));
  overviews.change({3, 3}, tile);
  const auto changed = overviews.refresh();
  EXPECT_EQ(changed.size(), static_cast<std::size_t>(overviews.levels()));
}

TEST(Overviews, LevelsDoNotDriftFromTheMean) {
  // Noise about P = 0.5: the mean of all cells is the mean of the last level's.
  std::mt19937 random(8);
  Overviews overviews(0.0);
  double sum = 0;
  std::size_t count = 0;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) {
      MapTile tile;
      test::frame(tile, random, 0, 0, 256, 256, 300, test::at_second(1));
      for (const std::uint8_t p : overview_of(tile, 0.0).cells) sum += p, ++count;
      overviews.change({c, r}, tile);
    }
  overviews.refresh();
  const OverviewTile* last = overviews.tile(overviews.levels(), {0, 0});
  ASSERT_NE(last, nullptr);
  double last_sum = 0;
  std::size_t last_count = 0;
  for (const std::uint8_t p : last->cells)
    if (p != OverviewTile::kUnseen) last_sum += p, ++last_count;
  EXPECT_NEAR(last_sum / static_cast<double>(last_count), sum / static_cast<double>(count), 0.05);
}

}  // namespace
}  // namespace watersky
