// SPDX-License-Identifier: MIT
#include "watersky/map/map_tile.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace watersky {
namespace {

Time at(double s) { return *time_from_seconds(s); }

/// What a look does to a cell.
void look(MapTile::Block& block, std::size_t cell, std::uint8_t place) {
  block.seen[cell] = block.looks[cell] == 0 ? place : std::max(block.seen[cell], place);
  if (block.looks[cell] < MapTile::kMostLooks) ++block.looks[cell];
}

TEST(MapTile, CellsKeepTheTimeOfTheirLatestLookWhateverTheOrderOfLooks) {
  std::mt19937 random(3);
  MapTile tile;
  MapTile::Block& block = tile.make_block(5);
  std::map<std::size_t, double> latest;
  for (int i = 0; i < 4000; ++i) {
    const double time_s = std::uniform_int_distribution(0, 150)(random);
    const std::size_t first = std::uniform_int_distribution<std::size_t>(0, 1000)(random);
    const std::uint8_t place = block.place_of(at(time_s));
    for (std::size_t c = first; c < first + 20; ++c) {
      look(block, c, place);
      latest[c] = std::max(latest[c], time_s);
    }
  }
  for (const auto& [cell, time_s] : latest)
    EXPECT_EQ(block.times[block.seen[cell]], at(time_s)) << cell;
}

TEST(MapTile, MoreTimesThanABlockCanNameMakeCellsOlderNeverFresher) {
  MapTile tile;
  MapTile::Block& block = tile.make_block(0);
  for (std::size_t c = 0; c < 1000; ++c) look(block, c, block.place_of(at(static_cast<double>(c))));
  ASSERT_LE(block.times.size(), MapTile::kMostTimes);
  for (std::size_t c = 0; c < 1000; ++c) {
    const double age_s = to_seconds(at(static_cast<double>(c)) - block.times[block.seen[c]]);
    EXPECT_GE(age_s, 0) << c;
    EXPECT_LE(age_s, 1000) << c;
  }
  EXPECT_EQ(block.times[block.seen[999]], at(999));
}

TEST(MapTile, LooksOfManyFramesASecondAreToldToATenthOfASecondAndTakeLittleMemory) {
  MapTile tile;
  MapTile::Block& block = tile.make_block(0);
  // A footprint's edge goes over the block: each frame is the last to see a few cells.
  for (std::size_t c = 0; c < 1000; ++c)
    look(block, c, block.place_of(at(static_cast<double>(c) / 300)));
  EXPECT_LE(block.times.capacity(), 48u);
  for (std::size_t c = 0; c < 1000; ++c) {
    const double age_s = to_seconds(at(static_cast<double>(c) / 300) - block.times[block.seen[c]]);
    EXPECT_GE(age_s, 0) << c;
    EXPECT_LT(age_s, 0.1) << c;
  }
}

TEST(MapTile, TimesThatNoCellUsesMakeRoomWithoutLoss) {
  MapTile tile;
  MapTile::Block& block = tile.make_block(0);
  for (int i = 0; i < 1000; ++i) {
    const std::uint8_t place = block.place_of(at(i));
    for (std::size_t c = 0; c < 64; ++c) look(block, c + static_cast<std::size_t>(i % 10), place);
  }
  for (std::size_t c = 9; c < 64; ++c) EXPECT_EQ(block.times[block.seen[c]], at(999));
}

MapTile some_tile(unsigned seed) {
  std::mt19937 random(seed);
  MapTile tile;
  for (const int b : {0, 7, 33, 63}) {
    MapTile::Block& block = tile.make_block(b);
    for (int i = 0; i < 30; ++i) {
      const std::uint8_t place = block.place_of(at(std::uniform_real_distribution(0., 9.)(random)));
      const std::size_t first = std::uniform_int_distribution<std::size_t>(0, 900)(random);
      for (std::size_t c = first; c < first + 100; ++c) {
        look(block, c, place);
        block.evidence[c] =
            static_cast<std::int16_t>(std::uniform_int_distribution(-7000, 7000)(random));
      }
    }
  }
  return tile;
}

TEST(MapTile, BytesBringBackTheTile) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const MapTile tile = some_tile(seed);
    const auto bytes = tile.encode();
    const auto back = MapTile::decode(bytes.data(), bytes.size());
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(*back, tile);
    EXPECT_EQ(back->encode(), bytes);
    EXPECT_EQ(back->seen_cells(), tile.seen_cells());
  }
}

TEST(MapTile, BytesThatAreNoTileAreRefusedAndTheByteNamed) {
  const auto bytes = some_tile(1).encode();
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    const auto cut = MapTile::decode(bytes.data(), size);
    ASSERT_FALSE(cut) << size;
    EXPECT_NE(cut.error().message.find("at byte"), std::string::npos);
  }
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(MapTile::decode(longer.data(), longer.size()));
  auto many_times = bytes;
  many_times[8] = 0xFF, many_times[9] = 0xFF;
  EXPECT_FALSE(MapTile::decode(many_times.data(), many_times.size()));
}

TEST(MapTile, EqualTilesHaveEqualBytesWhateverTimesWereForgotten) {
  MapTile a, b;
  look(a.make_block(3), 17, a.make_block(3).place_of(at(5)));
  look(b.make_block(3), 17, b.make_block(3).place_of(at(2)));
  look(b.make_block(3), 17, b.make_block(3).place_of(at(5)));
  b.block(3)->looks[17] = 1;
  EXPECT_EQ(a.encode(), b.encode());
}

TEST(MapTile, TimesThatNoCellHasAnyMoreTakeNoMemory) {
  MapTile tile;
  MapTile::Block& block = tile.make_block(0);
  for (int frame = 0; frame < 5000; ++frame) {
    const std::uint8_t place = block.place_of(at(frame));
    for (std::size_t c = 0; c < block.looks.size(); ++c) look(block, c, place);
  }
  EXPECT_LE(block.times.capacity(), 16u);
  EXPECT_EQ(block.times[block.seen[0]], at(4999));
}

TEST(MapTile, ABlockTakesFourBytesACellAndItsTimes) {
  MapTile tile;
  const std::size_t empty = tile.bytes();
  (void)tile.make_block(0);
  EXPECT_EQ(tile.bytes() - empty, 4 * MapTile::kCellsInBlock + 64);
}

}  // namespace
}  // namespace watersky
