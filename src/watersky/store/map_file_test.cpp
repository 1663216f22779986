// SPDX-License-Identifier: MIT
#include "watersky/store/map_file.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/map_tiles.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/store/detail/records.hpp"

namespace watersky {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

TileSet some_set(int tiles, unsigned seed = 1) {
  std::vector<TileItem> items;
  for (int i = 0; i < tiles; ++i)
    items.push_back(item_in_memory({i % 5 - 2, i / 5 - 1}, 0, static_cast<std::uint64_t>(i) + 1,
                                   test::some_tile(seed + static_cast<unsigned>(i))));
  return {test::some_header().sources, items};
}

Bytes bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Bytes written(const TileSet& set) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "map.wsmap";
  const Status done = write_map_file(disk(), path, test::some_header(), set);
  EXPECT_TRUE(done) << done.error().message;
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
  return bytes_of(path);
}

Result<MapFile> opened(Bytes bytes) {
  return MapFile::open(memory_file("some.wsmap", std::move(bytes)));
}

/// The first thing that is wrong with a map when all of it is read.
std::string fault_of(const Bytes& bytes) {
  const auto file = opened(bytes);
  if (!file) return file.error().message;
  for (const TileItem& item : file->tiles().items())
    if (const auto tile = item.load(); !tile) return tile.error().message;
  for (int level = 1; level <= file->levels(); ++level)
    for (const TileIndex& index : file->overviews(level))
      if (const auto tile = file->overview(level, index); !tile) return tile.error().message;
  return "";
}

TEST(MapFile, BringsBackHeaderTilesAndVersions) {
  const TileSet set = some_set(12);
  const auto file = opened(written(set));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->header(), test::some_header());
  EXPECT_TRUE(file->tiles() == set);
  for (std::size_t i = 0; i < set.items().size(); ++i) {
    const auto tile = file->tiles().items()[i].load();
    ASSERT_TRUE(tile) << tile.error().message;
    EXPECT_EQ(*tile, *set.items()[i].load());
    EXPECT_EQ(file->tiles().items()[i].seen_cells, tile->seen_cells());
  }
}

TEST(MapFile, OfNoTilesIsAMap) {
  const auto file = opened(written(TileSet(test::some_header().sources, {})));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(file->tiles().items().empty());
  EXPECT_EQ(file->levels(), 0);
}

TEST(MapFile, ItsTilesCanBeReadWhenTheFileItselfIsGoneFromHand) {
  TileSet tiles;
  {
    const auto file = opened(written(some_set(3)));
    ASSERT_TRUE(file);
    tiles = file->tiles();
  }
  EXPECT_TRUE(tiles.items().front().load());
}

TEST(MapFile, OverviewsAreThoseOfTheMapHalvedStepByStep) {
  const TileSet set = some_set(20);
  const auto file = opened(written(set));
  ASSERT_TRUE(file);
  Overviews live(log_odds(test::some_header().prior));
  for (const TileItem& item : set.items()) live.change(item.index, *item.load());
  live.refresh();
  ASSERT_EQ(file->levels(), live.levels());
  ASSERT_GT(file->levels(), 1);
  std::size_t tiles = 0;
  for (int level = 1; level <= file->levels(); ++level)
    for (const TileIndex& index : file->overviews(level)) {
      const auto tile = file->overview(level, index);
      ASSERT_TRUE(tile && *tile);
      ASSERT_NE(live.tile(level, index), nullptr);
      EXPECT_EQ(**tile, *live.tile(level, index)) << level;
      ++tiles;
    }
  EXPECT_GT(tiles, 6u);
  const auto nowhere = file->overview(1, {1000, 1000});
  ASSERT_TRUE(nowhere);
  EXPECT_FALSE(*nowhere);
}

TEST(MapFile, EveryCutIsToldWithItsPlaceAndRemedy) {
  const Bytes whole = written(some_set(2));
  for (std::size_t size = 0; size < whole.size(); size += size < 64 ? 1 : 211) {
    const auto file =
        opened(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_FALSE(file) << size;
    EXPECT_THAT(file.error().message, HasSubstr("some.wsmap"));
    EXPECT_THAT(file.error().message,
                testing::AnyOf(HasSubstr("take another copy"), HasSubstr("give a .wsmap")))
        << size;
  }
}

TEST(MapFile, EveryFlippedBitIsNoticed) {
  const Bytes whole = written(some_set(2));
  ASSERT_EQ(fault_of(whole), "");
  for (std::size_t i = 0; i < whole.size(); i += i < 600 ? 1 : 97) {
    Bytes bad = whole;
    bad[i] ^= static_cast<std::uint8_t>(1 << (i % 8));
    const std::string fault = fault_of(bad);
    // Padding after a record, at most seven bytes, is nobody's.
    if (fault.empty() && whole[i] == 0) continue;
    EXPECT_THAT(fault, HasSubstr("some.wsmap")) << i;
  }
}

TEST(MapFile, OfANewerVersionAsksForANewerWatersky) {
  Bytes newer = written(some_set(1));
  newer[8] = 2;
  const std::uint64_t sum = detail::checksum(std::span(newer).first(16));
  std::memcpy(newer.data() + 16, &sum, sizeof sum);
  const auto file = opened(newer);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::Unsupported);
  EXPECT_THAT(file.error().message, HasSubstr("has version 2"));
  EXPECT_THAT(file.error().message, HasSubstr("use a newer watersky"));
}

TEST(MapFile, WhatIsNoMapIsSaidToBeNone) {
  const auto file = opened({'I', 'I', '*', 0, 8, 0, 0, 0});
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().message, HasSubstr("is no map of watersky"));
}

TEST(MapFile, OfACutOrDamagedFileAllWholeTilesAreRecovered) {
  const TileSet set = some_set(10);
  const Bytes whole = written(set);
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    Bytes bad = whole;
    // Behind the header: of a map without one nobody knows where its cells lie.
    const std::size_t hole =
        std::uniform_int_distribution<std::size_t>(2000, whole.size() - 3000)(random);
    std::fill_n(bad.begin() + static_cast<std::ptrdiff_t>(hole), 2000, 0xAA);
    if (round % 2 == 1) bad.resize(bad.size() - 1000);
    const auto file = MapFile::recover(memory_file("some.wsmap", bad));
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_FALSE(file->notes().empty());
    // A hole of 2000 bytes meets two tiles at most.
    EXPECT_GE(file->tiles().items().size(), 8u);
    for (const TileItem& item : file->tiles().items()) {
      const auto tile = item.load();
      ASSERT_TRUE(tile) << tile.error().message;
      EXPECT_EQ(*tile, *set.of(item.index).front().load());
    }
  }
}

TEST(MapFile, RecoversWhatHasLostItsFirstBytes) {
  Bytes bad = written(some_set(3));
  std::fill_n(bad.begin(), 20, 0);
  EXPECT_FALSE(opened(bad));
  const auto file = MapFile::recover(memory_file("some.wsmap", bad));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->tiles().items().size(), 3u);
}

TEST(MapFile, AWriterThatDoesNotFinishLeavesNothing) {
  const test::TemporaryFolder folder;
  {
    auto writer = MapFileWriter::begin(disk(), folder.path() / "map.wsmap", test::some_header());
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->add(0, {0, 0}, 1, pack(test::some_tile(1))));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(MapFile, IntoAFolderThatIsNotThereIsRefusedWithItsName) {
  const Status done =
      write_map_file(disk(), "/nowhere/map.wsmap", test::some_header(), some_set(1));
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().message, HasSubstr("/nowhere/map.wsmap"));
}

/// What tests/data/golden.wsmap holds: written once, by the first watersky that had the format.
TileSet golden_set() {
  MapTile tile;
  test::look(tile, 5, 6, 1234, test::at_second(1000.5));
  test::look(tile, 5, 6, -34, test::at_second(1001.25));
  test::look(tile, 255, 255, -7072, test::at_second(1000.5));
  return {test::some_header("golden").sources, {item_in_memory({-3, 7}, 0, 42, tile)}};
}

TEST(MapFile, TheFormatIsThatOfTheGoldenFile) {
  // Remade with WATERSKY_GOLDEN=file, and only together with a new version of the format.
  if (const char* file = std::getenv("WATERSKY_GOLDEN")) {
    ASSERT_TRUE(write_map_file(disk(), file, test::some_header("golden"), golden_set()));
  }
  const auto golden =
      MapFile::open(disk(), std::filesystem::path(WATERSKY_SOURCE_DIR) / "tests/data/golden.wsmap");
  ASSERT_TRUE(golden) << golden.error().message;
  EXPECT_EQ(golden->header(), test::some_header("golden"));
  EXPECT_TRUE(golden->tiles() == golden_set()) << "digests and versions too";
  EXPECT_EQ(*golden->tiles().items().front().load(), *golden_set().items().front().load());
}

TEST(Records, AreTheBytesOfTheDocument) {
  // Its checksums are those of xxhsum -H3.
  Bytes bytes = detail::encode_preamble({detail::FileKind::Map, 0x01020304});
  const Bytes payload{'i', 'c', 'e'};
  detail::append_record(bytes, detail::RecordKind::Header, 0x01020304, payload);
  const Bytes expected{0x89, 0x57, 0x53, 0x4d, 0x0d, 0x0a, 0x1a, 0x0a, 0x01, 0x00, 0x01, 0x00,
                       0x04, 0x03, 0x02, 0x01, 0xd9, 0x75, 0x11, 0xba, 0x2b, 0x19, 0x07, 0x36,
                       0x57, 0x52, 0x65, 0x63, 0x01, 0x00, 0x00, 0x00, 0x03, 0x00, 0x00, 0x00,
                       0x04, 0x03, 0x02, 0x01, 0xfc, 0x92, 0xff, 0x71, 0xaf, 0xe1, 0x0b, 0xd7,
                       0x69, 0x63, 0x65, 0x00, 0x00, 0x00, 0x00, 0x00};
  EXPECT_EQ(bytes, expected);
}

TEST(MapHeader, JsonBringsItBack) {
  MapHeader header = test::some_header();
  header.sources.push_back(
      {"two", "Ünterwegs \"2\"", test::at_second(1.5), test::at_second(9), false});
  const auto back = parse_header(header_json(header));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(*back, header);
}

TEST(MapHeader, AFieldThatIsMissingOrWrongIsNamed) {
  const auto whole = nlohmann::json::parse(header_json(test::some_header()));
  for (const char* field : {"cell_m", "prior", "anchor_easting_m", "tile_cells", "projection",
                            "sources", "max_probability", "evidence_units"}) {
    for (const nlohmann::json& value :
         {nlohmann::json(), nlohmann::json(-1e300), nlohmann::json("x")}) {
      auto bad = whole;
      bad[field] = value;
      const auto header = parse_header(bad.dump());
      ASSERT_FALSE(header) << field << value;
      EXPECT_THAT(header.error().message, HasSubstr(field));
    }
  }
  EXPECT_FALSE(parse_header("[]"));
  EXPECT_FALSE(parse_header("{"));
}

TEST(MapHeader, MapsOfOneGridAreWholeTilesApartAndOthersAreRefused) {
  const MapHeader a = test::some_header();
  MapHeader b = a;
  b.anchor_easting_m += 3 * 128.0;
  b.anchor_northing_m += 2 * 128.0;
  const auto between = tiles_between(b, a);
  ASSERT_TRUE(between);
  EXPECT_EQ(*between, (TileIndex{3, -2}));
  EXPECT_EQ(*tiles_between(a, b), (TileIndex{-3, 2}));
  b.anchor_easting_m += 1.0;
  EXPECT_THAT(tiles_between(a, b).error().message, HasSubstr("tiles do not meet"));
  MapHeader cell = a;
  cell.cell_m = 0.25;
  EXPECT_THAT(tiles_between(a, cell).error().message, HasSubstr("cells of 0.5 m"));
  EXPECT_THAT(tiles_between(a, cell).error().message, HasSubstr("--cell-m"));
  MapHeader prior = a;
  prior.prior = 0.3;
  EXPECT_THAT(tiles_between(a, prior).error().message, HasSubstr("different priors"));
}

}  // namespace
}  // namespace watersky
