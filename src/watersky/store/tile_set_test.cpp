// SPDX-License-Identifier: MIT
/// The laws of the set of (source, tile, version), over random sets, orders, repeats and losses.
#include "watersky/store/tile_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "support/map_tiles.hpp"

namespace watersky {
namespace {

/// Messages as they may come from several aircraft: parts of what each had at some time.
class Sky {
 public:
  explicit Sky(unsigned seed) : random_(seed) {
    for (unsigned i = 0; i < 6; ++i) {
      MapTile tile;
      test::look(tile, static_cast<int>(i), 3, 100, test::at_second(i));
      contents_.push_back(tile);
    }
  }
  int from(int least, int most) { return std::uniform_int_distribution(least, most)(random_); }

  TileSet message() {
    std::vector<MapSource> sources;
    std::vector<TileItem> items;
    for (int s = 0; s < 4; ++s)
      if (from(0, 2) > 0) {
        MapSource source{"source " + std::to_string(s), "flight " + std::to_string(from(0, 1))};
        if (from(0, 1) == 1) source.first = test::at_second(from(0, 5));
        if (from(0, 1) == 1) source.last = test::at_second(from(0, 5));
        source.times_are_utc = from(0, 3) > 0;
        sources.push_back(source);
      }
    std::shuffle(sources.begin(), sources.end(), random_);
    if (sources.empty()) return {};
    for (int i = from(0, 12); i > 0; --i)
      // Equal versions of different content are nobody's intention; the laws hold even so.
      items.push_back(item_in_memory(
          {from(-1, 1), from(0, 1)},
          static_cast<std::uint32_t>(from(0, static_cast<int>(sources.size()) - 1)),
          static_cast<std::uint64_t>(from(1, 3)), contents_[static_cast<std::size_t>(from(0, 5))]));
    return {sources, items};
  }
  std::mt19937& random() { return random_; }

 private:
  std::mt19937 random_;
  std::vector<MapTile> contents_;
};

TEST(TileSet, UnionIsCommutativeAssociativeAndIdempotent) {
  Sky sky(1);
  for (int round = 0; round < 300; ++round) {
    const TileSet a = sky.message(), b = sky.message(), c = sky.message();
    EXPECT_TRUE(a.united(b) == b.united(a));
    EXPECT_TRUE(a.united(b).united(c) == a.united(b.united(c)));
    EXPECT_TRUE(a.united(a) == a);
    EXPECT_TRUE(a.united(b).united(b) == a.united(b));
    EXPECT_TRUE(a.united(TileSet()) == a);
  }
}

TEST(TileSet, WhateverOrderRepeatsAndLossesThatAreSentAgainAllEndWithOneSet) {
  Sky sky(2);
  for (int round = 0; round < 50; ++round) {
    std::vector<TileSet> messages;
    for (int i = 0; i < 8; ++i) messages.push_back(sky.message());
    TileSet all;
    for (const TileSet& m : messages) all = all.united(m);
    for (int listener = 0; listener < 4; ++listener) {
      // Half of what is sent is lost, and all is sent again until it has come.
      std::vector<TileSet> due = messages;
      TileSet heard;
      while (!due.empty()) {
        std::shuffle(due.begin(), due.end(), sky.random());
        std::vector<TileSet> lost;
        for (const TileSet& m : due) {
          const int times = sky.from(0, 2);
          for (int i = 0; i < times; ++i) heard = heard.united(m);
          if (times == 0) lost.push_back(m);
        }
        due = lost;
      }
      EXPECT_TRUE(heard == all);
    }
  }
}

TEST(TileSet, TheHighestVersionOfEachSourceAndTileCounts) {
  MapTile old_tile, new_tile;
  test::look(old_tile, 0, 0, 5, test::at_second(1));
  test::look(new_tile, 0, 0, 9, test::at_second(2));
  const std::vector<MapSource> one{{"a", "a"}}, two{{"b", "b"}};
  const TileSet older(one, {item_in_memory({4, 4}, 0, 1, old_tile)});
  const TileSet newer(one, {item_in_memory({4, 4}, 0, 2, new_tile)});
  const TileSet other(two, {item_in_memory({4, 4}, 0, 1, old_tile)});
  const TileSet all = newer.united(other).united(older);
  ASSERT_EQ(all.of({4, 4}).size(), 2u);
  EXPECT_EQ(all.of({4, 4})[0].version, 2u);
  EXPECT_EQ(*all.of({4, 4})[0].load(), new_tile);
  EXPECT_EQ(all.of({4, 4})[1].version, 1u);
  EXPECT_TRUE(all.of({4, 5}).empty());
  EXPECT_EQ(all.tiles(), (std::vector<TileIndex>{{4, 4}}));
}

TEST(TileSet, ShiftedThereAndBackIsTheSame) {
  Sky sky(3);
  for (int i = 0; i < 20; ++i) {
    const TileSet a = sky.message();
    EXPECT_TRUE(a.shifted({7, -3}).shifted({-7, 3}) == a);
    EXPECT_EQ(a.items().empty(), a.shifted({7, -3}) == a);
  }
}

TEST(PackedTile, UnpacksToTheSameTileAndNoticesEveryChange) {
  std::mt19937 random(4);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const MapTile tile = test::some_tile(seed);
    const PackedTile packed = pack(tile);
    const auto back = unpack(packed);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(*back, tile);
    EXPECT_EQ(packed.seen_cells, tile.seen_cells());
    PackedTile bad = packed;
    bad.planes[std::uniform_int_distribution<std::size_t>(0, bad.planes.size() - 1)(random)] ^= 4;
    EXPECT_FALSE(unpack(bad));
    bad = packed;
    bad.blocks ^= 1;
    EXPECT_FALSE(unpack(bad));
    bad = packed;
    bad.planes.resize(bad.planes.size() / 2);
    EXPECT_FALSE(unpack(bad));
  }
}

TEST(PackedTile, AChangeHoldsTheBlocksThatDifferAndNoOthers) {
  MapTile tile = test::some_tile(5);
  const TileChange all = change_of(tile, {});
  EXPECT_EQ(all.changed.digest, pack(tile).digest);
  EXPECT_EQ(tile_digest(all.digests), all.changed.digest);
  EXPECT_EQ(change_of(tile, all.digests).changed.blocks, 0u);
  test::look(tile, 33, 65, 50, test::at_second(5000));
  const TileChange one = change_of(tile, all.digests);
  EXPECT_EQ(one.changed.blocks, std::uint64_t{1} << MapTile::block_of(33, 65));
  EXPECT_EQ(one.seen_cells, tile.seen_cells());
}

}  // namespace
}  // namespace watersky
