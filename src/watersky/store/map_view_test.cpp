// SPDX-License-Identifier: MIT
#include "watersky/store/map_view.hpp"

#include <gtest/gtest.h>

#include "support/map_tiles.hpp"

namespace watersky {
namespace {

using test::at_second;

TEST(MapView, OfOneSourceIsThatSource) {
  const MapTile tile = test::some_tile(1);
  EXPECT_EQ(sum_of(std::vector{tile}, {}), tile);
}

TEST(MapView, SumsEvidenceAndLooksAndTakesTheLatestLook) {
  MapTile a, b;
  test::look(a, 3, 4, 500, at_second(10));
  test::look(a, 3, 4, 500, at_second(11));
  test::look(b, 3, 4, -300, at_second(5));
  test::look(b, 200, 4, 700, at_second(6));
  const MapTile sum = sum_of(std::vector{a, b}, {});
  const MapTile::Block& block = *sum.block(MapTile::block_of(3, 4));
  const auto cell = static_cast<std::size_t>(MapTile::cell_in_block(3, 4));
  EXPECT_EQ(block.evidence[cell], 700);
  EXPECT_EQ(block.looks[cell], 3);
  EXPECT_EQ(block.times[block.seen[cell]], at_second(11));
  EXPECT_EQ(*sum.block(MapTile::block_of(200, 4)), *b.block(MapTile::block_of(200, 4)));
}

TEST(MapView, DoesNotDependOnTheOrderOfSources) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const MapTile a = test::some_tile(seed), b = test::some_tile(seed + 50, 6),
                  c = test::some_tile(seed + 90);
    const MapTile abc = sum_of(std::vector{a, b, c}, {});
    EXPECT_EQ(sum_of(std::vector{c, a, b}, {}), abc);
    EXPECT_EQ(sum_of(std::vector{b, c, a}, {}), abc);
  }
}

TEST(MapView, IsTheExactFilterWhereNothingWasClampedOrForgotten) {
  std::mt19937 random(3);
  MapTile exact, a, b;
  for (int i = 0; i < 6; ++i) {
    MapTile& one = i % 2 == 0 ? a : b;
    for (int c = 0; c < 200; ++c) {
      const int evidence = std::uniform_int_distribution(-900, 900)(random);
      test::look(exact, c, 7, evidence, at_second(i));
      test::look(one, c, 7, evidence, at_second(i));
    }
  }
  EXPECT_EQ(sum_of(std::vector{a, b}, {}), exact);
}

TEST(MapView, IsClampedLast) {
  MapTile ice, water;
  test::look(ice, 0, 0, 7000, at_second(1));
  test::look(water, 0, 0, -6900, at_second(1));
  EXPECT_EQ(sum_of(std::vector{ice, ice, water}, {}).block(0)->evidence[0],
            std::lround(log_odds(0.999) * kEvidenceUnits));
  EXPECT_EQ(sum_of(std::vector{ice, water}, {}).block(0)->evidence[0], 100);
}

TEST(MapView, BringsEachSourceToTheCommonTime) {
  const auto dynamics = CellDynamics::make(0.9, 0.1, 60.0, 0.5);
  ASSERT_TRUE(dynamics);
  MapTile a, b;
  test::look(a, 0, 0, 2 * kEvidenceUnits, at_second(0));
  test::look(b, 0, 0, kEvidenceUnits, at_second(120));
  const MapTile sum =
      sum_of(std::vector{a, b}, {.dynamics = *dynamics, .common_time = at_second(120)});
  const double expected = log_odds(dynamics->predict(probability(2.0), 120.0)) + 1.0;
  EXPECT_NEAR(sum.block(0)->evidence[0], expected * kEvidenceUnits, 1.0);
}

TEST(MapView, NamesMoreTimesThanABlockCanByMakingCellsOlderNeverFresher) {
  MapTile a, b;
  for (int i = 0; i < 200; ++i) {
    test::look(a, i % 32, i / 32, 10, at_second(2 * i));
    test::look(b, i % 32, 10 + i / 32, 10, at_second(2 * i + 1));
  }
  const MapTile sum = sum_of(std::vector{a, b}, {});
  const MapTile::Block& block = *sum.block(0);
  EXPECT_LE(block.times.size(), MapTile::kMostTimes);
  for (int i = 0; i < 200; ++i) {
    const auto cell = static_cast<std::size_t>(MapTile::cell_in_block(i % 32, i / 32));
    EXPECT_LE(block.times[block.seen[cell]], at_second(2 * i));
    EXPECT_GE(block.times[block.seen[cell]], at_second(2 * i - 8));
  }
}

TEST(MapView, TheBoxOfCellsSeenIsExact) {
  MapTile a, b;
  test::look(a, 250, 100, 10, at_second(1));
  test::look(b, 3, 9, 10, at_second(1));
  const TileSet set({{"s", "s"}},
                    {item_in_memory({-1, 0}, 0, 1, a), item_in_memory({1, 2}, 0, 1, b)});
  const auto box = seen_box(set);
  ASSERT_TRUE(box);
  EXPECT_EQ(*box, (CellBox{-6, 100, 256 + 3 + 6 + 1, 512 + 9 - 100 + 1}));
  EXPECT_TRUE(seen_box(TileSet())->empty());
}

}  // namespace
}  // namespace watersky
