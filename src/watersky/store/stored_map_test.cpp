// SPDX-License-Identifier: MIT
#include "watersky/store/stored_map.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/core.hpp>

#include "support/map_tiles.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/store/map_diff.hpp"
#include "watersky/store/map_file.hpp"
#include "watersky/store/map_journal.hpp"

namespace watersky {
namespace {

using test::at_second;
using ::testing::HasSubstr;

StoredMap some_map(const std::string& name, std::vector<TileItem> items) {
  const MapHeader header = test::some_header(name);
  return {header, TileSet(header.sources, std::move(items))};
}

TEST(StoredMap, MapsWithOtherAnchorsMeetTileByTile) {
  StoredMap a = some_map("a", {item_in_memory({5, 5}, 0, 1, test::some_tile(1))});
  StoredMap b = some_map("b", {item_in_memory({2, 7}, 0, 1, test::some_tile(2))});
  b.header.anchor_easting_m += 3 * 128.0;
  b.header.anchor_northing_m += 2 * 128.0;
  const auto merged = merge_maps({a, b}, {"a", "b"});
  ASSERT_TRUE(merged) << merged.error().message;
  EXPECT_EQ(merged->tiles.of({5, 5}).size(), 2u);
  EXPECT_EQ(merged->header.sources.size(), 2u);
  const auto other = merge_maps({b, a}, {"b", "a"});
  ASSERT_TRUE(other);
  EXPECT_EQ(other->tiles.of({2, 7}).size(), 2u);
  EXPECT_TRUE(other->in_grid_of(a.header)->tiles == merged->tiles);
}

TEST(StoredMap, MergingAMapWithWhatIsInItAlreadyChangesNothing) {
  const StoredMap a = some_map("a", {item_in_memory({0, 0}, 0, 1, test::some_tile(1))});
  const StoredMap b = some_map("b", {item_in_memory({0, 0}, 0, 1, test::some_tile(2))});
  const auto ab = merge_maps({a, b}, {"a", "b"});
  const auto again = merge_maps({*ab, b, a, *ab}, {"ab", "b", "a", "ab"});
  EXPECT_TRUE(again->tiles == ab->tiles);
}

TEST(StoredMap, AMapThatForgetsIsShownAsAtItsLastLookAndSaysHowItForgets) {
  MapTile tile;
  test::look(tile, 3, 4, 2000, at_second(0));
  test::look(tile, 5, 4, 2000, at_second(600));
  StoredMap map = some_map("a", {item_in_memory({0, 0}, 0, 1, tile)});
  map.header.half_life_s = 600;
  map.header.sources[0].last = at_second(600);
  const auto header = parse_header(header_json(map.header));
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_EQ(*header, map.header);
  const auto shown = view_tile(map.tiles, {0, 0}, map.view());
  ASSERT_TRUE(shown);
  const double prior = log_odds(map.header.prior);
  const auto p_of = [&](int column) {
    const auto* block = shown->block(0);
    const auto cell = static_cast<std::size_t>(MapTile::cell_in_block(column, 4));
    return probability(static_cast<double>(block->evidence[cell]) / kEvidenceUnits + prior);
  };
  const double fresh = probability(2000.0 / kEvidenceUnits + prior);
  EXPECT_NEAR(p_of(5), fresh, 1e-3);
  EXPECT_NEAR(p_of(3), map.header.prior + (fresh - map.header.prior) / 2, 1e-3);

  StoredMap keeps = some_map("b", {});
  EXPECT_EQ(merge_maps({keeps, map}, {"b", "a"})->header.half_life_s, 600);
  keeps.header.half_life_s = 60;
  EXPECT_EQ(merge_maps({map, keeps}, {"a", "b"})->header.half_life_s, 60);
}

TEST(StoredMap, TilesOfAMapInMemoryAreItsOwn) {
  IceMap map = IceMap::make({.cell_m = 0.5}).value();
  map.set_tile({2, -1}, test::some_tile(4), 7);
  const MapSource source = test::some_header("a").sources[0];
  const TileSet tiles = tiles_of(map, source, 9);
  ASSERT_EQ(tiles.items().size(), 1u);
  EXPECT_EQ(tiles.items()[0].version, 9u);
  EXPECT_EQ(tiles.items()[0].load()->encode(), test::some_tile(4).encode());
}

TEST(StoredMap, MapsOfOtherGridsAreRefusedByName) {
  StoredMap a = some_map("a", {}), b = some_map("b", {});
  b.header.cell_m = 1.0;
  const auto merged = merge_maps({a, b}, {"first", "second"});
  ASSERT_FALSE(merged);
  EXPECT_THAT(merged.error().message, HasSubstr("first and second: the maps do not share a grid"));
}

TEST(StoredMap, OpensFilesFoldersAndLiveMaps) {
  const test::TemporaryFolder folder;
  const StoredMap map = some_map("a", {item_in_memory({0, 0}, 0, 1, test::some_tile(1))});
  const auto run = folder.path() / "run", live = folder.path() / "live";
  std::filesystem::create_directory(run);
  ASSERT_TRUE(write_map_file(disk(), run / kMapFileName, map.header, map.tiles));
  {
    auto journal = MapJournal::open(disk(), live, map.header);
    ASSERT_TRUE(journal);
    journal->change({0, 0}, 1, test::some_tile(1));
    ASSERT_TRUE(journal->commit(at_second(1)));
  }
  for (const auto& path : {run, run / kMapFileName, live}) {
    const auto opened = open_map(disk(), path);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_TRUE(opened->tiles == map.tiles) << path;
  }
  EXPECT_THAT(open_map(disk(), folder.path()).error().message, HasSubstr("holds no map"));
  EXPECT_EQ(open_map(disk(), folder.path() / "no").error().code, ErrorCode::NotFound);
}

TEST(StoredMap, RecoversADamagedFileOnlyWhenAsked) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "a.wsmap";
  const StoredMap map = some_map("a", {item_in_memory({0, 0}, 0, 1, test::some_tile(1)),
                                       item_in_memory({1, 0}, 0, 1, test::some_tile(2))});
  ASSERT_TRUE(write_map_file(disk(), path, map.header, map.tiles));
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 10);
  const auto refused = open_map(disk(), path);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("watersky merge --recover"));
  const auto recovered = open_map(disk(), path, true);
  ASSERT_TRUE(recovered) << recovered.error().message;
  EXPECT_TRUE(recovered->tiles == map.tiles);
  EXPECT_FALSE(recovered->notes.empty());
}

TEST(MapDiff, TellsWhatBecameOfEachCell) {
  MapTile before, after;
  const int ice = 2000, water = -2000;
  const auto cell = [&](int column, int was, int is) {
    if (was != 0) test::look(before, column, 8, was, at_second(1));
    if (is != 0) test::look(after, column, 8, is, at_second(2));
  };
  cell(0, water, water);
  cell(1, ice, ice);
  cell(2, ice, water);
  cell(3, water, ice);
  cell(4, 0, water);
  cell(5, 0, ice);
  cell(6, ice, 0);
  const TileChanges changes = changes_of(before, after, 0.0, 0.5);
  for (int c = 0; c < 7; ++c) EXPECT_EQ(changes[static_cast<std::size_t>(8 * 256 + c)], c);
  EXPECT_EQ(changes[8 * 256 + 7], kNeitherSeen);

  const StoredMap a = some_map("a", {item_in_memory({0, 0}, 0, 1, before)});
  StoredMap b = some_map("b", {item_in_memory({-1, 0}, 0, 1, after)});
  b.header.anchor_easting_m += 128.0;
  const auto diff = MapDiff::of(a, b, "a", "b");
  ASSERT_TRUE(diff) << diff.error().message;
  const auto counts = diff->count();
  ASSERT_TRUE(counts);
  EXPECT_THAT(*counts, testing::Each(1u));
  EXPECT_EQ(*diff->seen(), (CellBox{0, 8, 7, 1}));
}

TEST(MapDiff, OfAMapAndItselfIsNothing) {
  const StoredMap a = some_map("a", {item_in_memory({0, 0}, 0, 1, test::some_tile(1))});
  const auto diff = MapDiff::of(a, a, "a", "a");
  const auto counts = diff->count();
  ASSERT_TRUE(counts);
  EXPECT_EQ((*counts)[0] + (*counts)[1], test::some_tile(1).seen_cells());
}

}  // namespace
}  // namespace watersky
