// SPDX-License-Identifier: MIT
#include "watersky/store/map_journal.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>

#include "support/killed_flight.hpp"
#include "support/losing_storage.hpp"
#include "support/map_tiles.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/store/journal_writer.hpp"
#include "watersky/store/map_file.hpp"

namespace watersky {
namespace {

using test::at_second;
using test::LosingStorage;
using ::testing::HasSubstr;

const std::filesystem::path kFolder = "live";

MapJournal open_in(Storage& storage, const std::filesystem::path& folder = kFolder) {
  auto journal = MapJournal::open(storage, folder, test::some_header());
  EXPECT_TRUE(journal) << journal.error().message;
  return *std::move(journal);
}

TEST(MapJournal, ARestartBringsBackTilesVersionsAndTime) {
  const test::TemporaryFolder folder;
  MapTile a = test::some_tile(1), b = test::some_tile(2);
  {
    MapJournal journal = open_in(disk(), folder.path());
    journal.change({0, 0}, 1, a);
    journal.change({-5, 7}, 3, b);
    ASSERT_TRUE(journal.commit(at_second(50)));
    test::look(a, 100, 100, 300, at_second(60));
    journal.change({0, 0}, 2, a);
    ASSERT_TRUE(journal.commit(at_second(60)));
  }
  const auto store = MapStore::open(disk(), folder.path());
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_EQ(store->header(), test::some_header());
  ASSERT_EQ(store->tiles().items().size(), 2u);
  const TileItem& first = store->tiles().of({0, 0}).front();
  EXPECT_EQ(first.version, 2u);
  EXPECT_EQ(*first.load(), a);
  EXPECT_EQ(first.digest, pack(a).digest);
  EXPECT_EQ(first.seen_cells, a.seen_cells());
  EXPECT_EQ(*store->tiles().of({-5, 7}).front().load(), b);
  ASSERT_TRUE(store->last());
  EXPECT_EQ(store->last()->time, at_second(60));
  EXPECT_EQ(store->last()->sequence, 2u);
}

TEST(MapJournal, AfterCompactionTheFolderHoldsASnapshotThatIsAMapFileAndOneJournal) {
  const test::TemporaryFolder folder;
  MapJournal journal = open_in(disk(), folder.path());
  std::map<TileIndex, MapTile> map;
  for (unsigned i = 0; i < 8; ++i) {
    const TileIndex index{static_cast<int>(i % 3), 0};
    map[index] = test::some_tile(i);
    journal.change(index, i + 1, map[index]);
    ASSERT_TRUE(journal.commit(at_second(i)));
  }
  ASSERT_TRUE(journal.compact());
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    names.push_back(entry.path().filename().string());
  EXPECT_THAT(names, testing::UnorderedElementsAre("lock", "snapshot-00000002.wsmap",
                                                   "journal-00000002.wsj"));
  const auto snapshot = MapFile::open(disk(), folder.path() / "snapshot-00000002.wsmap");
  ASSERT_TRUE(snapshot) << snapshot.error().message;
  EXPECT_TRUE(snapshot->tiles() == journal.tiles());
  const auto store = MapStore::open(disk(), folder.path());
  ASSERT_TRUE(store);
  EXPECT_EQ(store->last()->sequence, 8u);
  for (const TileItem& item : store->tiles().items()) EXPECT_EQ(*item.load(), map[item.index]);
}

TEST(MapJournal, WritesBlocksThatChangedAndNotTheTile) {
  LosingStorage storage;
  MapJournal journal = open_in(storage);
  std::mt19937 random(1);
  MapTile tile;
  test::frame(tile, random, 0, 0, 256, 256, 100, at_second(1));
  journal.change({0, 0}, 1, tile);
  ASSERT_TRUE(journal.commit(at_second(1)));
  const std::size_t whole = storage.bytes(kFolder / "journal-00000001.wsj").size();
  test::look(tile, 5, 5, 10, at_second(2));
  journal.change({0, 0}, 2, tile);
  ASSERT_TRUE(journal.commit(at_second(2)));
  EXPECT_LT(storage.bytes(kFolder / "journal-00000001.wsj").size() - whole, whole / 20);
}

TEST(MapJournal, TwoFlightsOfOneGridLieInOneFolderAsTwoSources) {
  LosingStorage storage;
  {
    MapJournal monday = open_in(storage);
    monday.change({0, 0}, 1, test::some_tile(1));
    ASSERT_TRUE(monday.commit(at_second(1)));
    ASSERT_TRUE(monday.compact());
  }
  // "source of a" comes before Monday's in the order of ids, so numbers in files differ.
  auto tuesday = MapJournal::open(storage, kFolder, test::some_header("a"));
  ASSERT_TRUE(tuesday) << tuesday.error().message;
  const auto source = tuesday->header().find_source("source of a");
  ASSERT_TRUE(source);
  tuesday->change({0, 0}, 1, test::some_tile(2), *source);
  ASSERT_TRUE(tuesday->commit(at_second(2)));
  for (int round = 0; round < 2; ++round) {
    const auto store = MapStore::open(storage, kFolder);
    ASSERT_TRUE(store);
    const auto items = store->tiles().of({0, 0});
    ASSERT_EQ(items.size(), 2u);
    EXPECT_EQ(*items[0].load(), test::some_tile(2));
    EXPECT_EQ(*items[1].load(), test::some_tile(1));
    ASSERT_TRUE(tuesday->compact());
  }
}

TEST(MapJournal, AnotherGridIsRefusedAndSoIsASecondWriter) {
  const test::TemporaryFolder folder;
  MapHeader other = test::some_header();
  other.cell_m = 0.25;
  {
    MapJournal journal = open_in(disk(), folder.path());
    const auto second = MapJournal::open(disk(), folder.path(), test::some_header());
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::Exists);
    EXPECT_THAT(second.error().message, HasSubstr("another process writes this map"));
  }
  const auto wrong = MapJournal::open(disk(), folder.path(), other);
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("a map of another grid"));
}

TEST(MapJournal, AFolderThatCannotBeWrittenIsToldAtTheStart) {
  const auto journal = MapJournal::open(disk(), "/proc/watersky", test::some_header());
  ASSERT_FALSE(journal);
  EXPECT_THAT(journal.error().message, HasSubstr("/proc/watersky"));
}

TEST(MapStore, AFolderWithoutAMapIsSaidToHoldNone) {
  const test::TemporaryFolder folder;
  const auto store = MapStore::open(disk(), folder.path());
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, ErrorCode::NotFound);
  EXPECT_EQ(MapStore::open(disk(), folder.path() / "no").error().code, ErrorCode::NotFound);
}

TEST(MapStore, DamageInTheMiddleOfAJournalCostsWhatStoodThereAndIsTold) {
  LosingStorage storage;
  std::map<TileIndex, std::uint64_t> ends;
  const auto path = kFolder / "journal-00000001.wsj";
  MapJournal journal = open_in(storage);
  for (int i = 0; i < 10; ++i) {
    journal.change({i, 0}, 1, test::some_tile(static_cast<unsigned>(i)));
    ASSERT_TRUE(journal.commit(at_second(i)));
    ends[{i, 0}] = storage.bytes(path).size();
  }
  storage.bytes(path)[ends.at({4, 0}) - 3000] ^= 1;
  const auto store = MapStore::open(storage, kFolder);
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_THAT(store->notes(), testing::ElementsAre(HasSubstr("a part of it is damaged")));
  EXPECT_EQ(store->tiles().items().size(), 9u);
  EXPECT_TRUE(store->tiles().of({4, 0}).empty());
  EXPECT_EQ(store->last()->sequence, 10u);
}

TEST(MapStore, ATornEndIsNoDamageAndIsCutWhenTheMapGoesOn) {
  LosingStorage storage;
  const auto path = kFolder / "journal-00000001.wsj";
  std::size_t good = 0;
  {
    MapJournal journal = open_in(storage);
    journal.change({0, 0}, 1, test::some_tile(1));
    ASSERT_TRUE(journal.commit(at_second(1)));
    good = storage.bytes(path).size();
    journal.change({1, 0}, 1, test::some_tile(2));
    ASSERT_TRUE(journal.commit(at_second(2)));
  }
  auto& bytes = storage.bytes(path);
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(good) + 100, bytes.end(), 0);
  const auto store = MapStore::open(storage, kFolder);
  ASSERT_TRUE(store);
  EXPECT_TRUE(store->notes().empty());
  EXPECT_EQ(store->tiles().items().size(), 1u);
  MapJournal journal = open_in(storage);
  EXPECT_EQ(storage.bytes(path).size(), good);
}

TEST(JournalWriter, CommitsWhatIsOfferedAndRecoversWhenTheDiskHasRoomAgain) {
  LosingStorage storage;
  auto writer = JournalWriter::start(storage, kFolder, test::some_header(), "source of flight",
                                     {.retry_after = std::chrono::milliseconds(5)});
  ASSERT_TRUE(writer) << writer.error().message;
  std::vector<OfferedTile> tiles;
  tiles.push_back({{0, 0}, 1, test::some_tile(1)});
  (*writer)->offer(std::move(tiles), at_second(1));
  ASSERT_TRUE((*writer)->flush());
  EXPECT_FALSE((*writer)->trouble());
  storage.capacity = 0;
  for (std::uint64_t i = 2; i < 5; ++i) {
    std::vector<OfferedTile> more;
    more.push_back({{0, 0}, i, test::some_tile(static_cast<unsigned>(i))});
    (*writer)->offer(std::move(more), at_second(static_cast<double>(i)));
  }
  EXPECT_FALSE((*writer)->flush());
  ASSERT_TRUE((*writer)->trouble());
  EXPECT_THAT(*(*writer)->trouble(), HasSubstr("in memory only for now"));
  storage.capacity = UINT64_MAX;
  while ((*writer)->trouble()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  writer->reset();
  const auto store = MapStore::open(storage, kFolder);
  ASSERT_TRUE(store);
  EXPECT_EQ(*store->tiles().of({0, 0}).front().load(), test::some_tile(4));
}

TEST(JournalWriter, CompactsWhileItGoesOn) {
  const test::TemporaryFolder folder;
  auto writer = JournalWriter::start(disk(), folder.path(), test::some_header(), "source of flight",
                                     {.journal = {.compact_above_bytes = 50'000}});
  ASSERT_TRUE(writer) << writer.error().message;
  std::map<TileIndex, MapTile> map;
  for (unsigned i = 0; i < 40; ++i) {
    const TileIndex index{static_cast<int>(i % 4), 0};
    map[index] = test::some_tile(i);
    std::vector<OfferedTile> tiles;
    tiles.push_back({index, i + 1, map[index]});
    (*writer)->offer(std::move(tiles), at_second(i));
    ASSERT_TRUE((*writer)->flush());
  }
  writer->reset();
  std::size_t snapshots = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    snapshots += entry.path().extension() == ".wsmap" ? 1 : 0;
  EXPECT_EQ(snapshots, 1u);
  const auto store = MapStore::open(disk(), folder.path());
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_EQ(store->last()->sequence, 40u);
  ASSERT_EQ(store->tiles().items().size(), map.size());
  for (const TileItem& item : store->tiles().items()) EXPECT_EQ(*item.load(), map[item.index]);
}

// A thousand kills: experiments/map_kills.
TEST(JournalWriter, KilledAgainAndAgainKeepsAMapThatOnceWas) {
  const test::TemporaryFolder folder;
  const test::KillFigures figures = test::kill_flights(folder.path() / "live", 6, 0.9, 1);
  EXPECT_EQ(figures.kills, 6);
  EXPECT_EQ(figures.corrupt, 0);
}

}  // namespace
}  // namespace watersky
