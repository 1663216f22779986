// SPDX-License-Identifier: MIT
/// Power goes at every moment of a life of commits, compactions and restarts, and each time in many
/// ways.
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "support/losing_storage.hpp"
#include "support/map_tiles.hpp"
#include "watersky/store/map_journal.hpp"

namespace watersky {
namespace {

using test::LosingStorage;

const std::filesystem::path kFolder = "live";

/// A map's content, to compare.
using Content = std::map<TileIndex, std::vector<std::uint8_t>>;

Content content_of(const TileSet& tiles) {
  Content out;
  for (const TileItem& item : tiles.items()) {
    const auto tile = item.load();
    EXPECT_TRUE(tile) << tile.error().message;
    if (tile) out[item.index] = tile->encode();
  }
  return out;
}

/// A life: what it committed, and what of that was acknowledged.
class Life {
 public:
  explicit Life(unsigned seed) : random_(seed) { history_.emplace_back(); }

  /// Changes some tiles and commits them.
  [[nodiscard]] Status step(MapJournal& journal) {
    ++second_;
    for (int i = 0; i < 2; ++i) {
      const TileIndex index{std::uniform_int_distribution(-1, 1)(random_),
                            std::uniform_int_distribution(0, 1)(random_)};
      MapTile& tile = map_[index];
      test::frame(tile, random_, std::uniform_int_distribution(0, 200)(random_),
                  std::uniform_int_distribution(0, 200)(random_), 40, 30, 700,
                  test::at_second(second_));
      journal.change(index, ++versions_[index], tile);
    }
    Content now;
    for (const auto& [index, tile] : map_) now[index] = tile.encode();
    history_.push_back(now);
    const Status done = journal.commit(test::at_second(second_));
    if (done) acknowledged_ = history_.size() - 1;
    return done;
  }

  /// What may be found: what was acknowledged, or what was being committed.
  void expect_nothing_lost(LosingStorage& storage, const std::string& when) const {
    const auto store = MapStore::open(storage, kFolder);
    if (!store) {
      EXPECT_EQ(acknowledged_, 0u) << when << ": " << store.error().message;
      EXPECT_EQ(store.error().code, ErrorCode::NotFound) << store.error().message;
      return;
    }
    EXPECT_TRUE(store->notes().empty()) << when << ": " << store->notes().front();
    const Content found = content_of(store->tiles());
    bool known = false;
    for (std::size_t k = acknowledged_; k < history_.size(); ++k) known |= found == history_[k];
    EXPECT_TRUE(known) << when << ": the map is none of those that may be, after " << acknowledged_
                       << " acknowledged commits";
  }

  void forget_what_was_not_kept(const Content& found) {
    while (history_.size() > 1 && history_.back() != found) history_.pop_back();
    EXPECT_EQ(history_.back(), found) << "the map is none that was ever committed";
    acknowledged_ = history_.size() - 1;
    map_.clear();
    for (const auto& [index, bytes] : found)
      map_[index] = *MapTile::decode(bytes.data(), bytes.size());
  }

  [[nodiscard]] std::size_t acknowledged() const { return acknowledged_; }

 private:
  std::mt19937 random_;
  std::map<TileIndex, MapTile> map_;
  std::map<TileIndex, std::uint64_t> versions_;
  std::vector<Content> history_;
  std::size_t acknowledged_ = 0;
  double second_ = 0;
};

TEST(PowerCut, AtAnyMomentLosesNothingThatWasAcknowledged) {
  std::mt19937 random(1);
  Life life(7);
  LosingStorage storage;
  std::size_t moments = 0;
  std::string doing;
  storage.before_each = [&] {
    ++moments;
    for (int way = 0; way < 12; ++way)
      life.expect_nothing_lost(*storage.after_power_cut(random),
                               doing + ", moment " + std::to_string(moments));
  };
  for (int restart = 0; restart < 3; ++restart) {
    doing = "opening";
    auto journal = MapJournal::open(storage, kFolder, test::some_header());
    ASSERT_TRUE(journal) << journal.error().message;
    for (int i = 0; i < 6; ++i) {
      doing = "committing";
      ASSERT_TRUE(life.step(*journal));
      if (i == 2) {
        doing = "compacting";
        ASSERT_TRUE(journal->compact());
      }
      if (i == 4) {
        doing = "compacting while commits go on";
        auto work = journal->begin_compaction();
        ASSERT_TRUE(work);
        ASSERT_TRUE(life.step(*journal));
        ASSERT_TRUE((*work)());
        ASSERT_TRUE(life.step(*journal));
        ASSERT_TRUE(journal->end_compaction());
      }
    }
  }
  EXPECT_GT(moments, 100u);
}

TEST(PowerCut, AfterPowerCutAfterPowerCutTheMapGoesOn) {
  std::mt19937 random(2);
  for (unsigned seed = 0; seed < 10; ++seed) {
    Life life(seed);
    auto storage = std::make_unique<LosingStorage>();
    for (int cut = 0; cut < 8; ++cut) {
      // Power goes at a moment in the middle of what this life does.
      const int last_moment = std::uniform_int_distribution(0, 40)(random);
      int moment = 0;
      std::unique_ptr<LosingStorage> found;
      storage->before_each = [&] {
        if (moment++ == last_moment) found = storage->after_power_cut(random);
      };
      {
        auto journal = MapJournal::open(*storage, kFolder, test::some_header());
        ASSERT_TRUE(journal) << journal.error().message;
        while (!found) {
          ASSERT_TRUE(life.step(*journal));
          if (!found && journal->last()->sequence % 3 == 0) {
            ASSERT_TRUE(journal->compact());
          }
        }
      }
      // The life went a step or a compaction beyond the cut: what it acknowledged then is not
      // owed.
      found->before_each = nullptr;
      const auto store = MapStore::open(*found, kFolder);
      if (store) {
        life.forget_what_was_not_kept(content_of(store->tiles()));
      } else {
        life.forget_what_was_not_kept({});
      }
      storage = std::move(found);
    }
    life.expect_nothing_lost(*storage, "in the end");
  }
}

/// Thrown at the moment at which a process is killed: what it wrote stays, synced or not.
struct Killed {};

TEST(PowerCut, AfterAKillWhatWasReadButNeverSyncedIsOnTheDiskBeforeMoreIsAdded) {
  std::mt19937 random(6);
  std::size_t unsynced_found = 0;
  for (int moment_of_kill = 0; moment_of_kill < 16; ++moment_of_kill) {
    LosingStorage storage;
    Life life(17);
    int moment = 0;
    storage.before_each = [&] {
      if (moment++ == moment_of_kill) throw Killed();
    };
    try {
      auto journal = MapJournal::open(storage, kFolder, test::some_header());
      ASSERT_TRUE(journal) << journal.error().message;
      while (true) ASSERT_TRUE(life.step(*journal));
    } catch (const Killed&) {
      storage.before_each = nullptr;
    }
    auto journal = MapJournal::open(storage, kFolder, test::some_header());
    ASSERT_TRUE(journal) << journal.error().message;
    const std::size_t before = life.acknowledged();
    life.forget_what_was_not_kept(content_of(journal->tiles()));
    unsynced_found += life.acknowledged() > before;
    for (int i = 0; i < 2; ++i) {
      for (int way = 0; way < 20; ++way)
        life.expect_nothing_lost(*storage.after_power_cut(random),
                                 "killed at moment " + std::to_string(moment_of_kill));
      ASSERT_TRUE(life.step(*journal));
    }
  }
  EXPECT_GT(unsynced_found, 0u) << "no kill came between a write and its sync";
}

TEST(PowerCut, FullDiskKeepsTheChangesAndTheNextCommitBringsThemAll) {
  LosingStorage storage;
  std::mt19937 random(3);
  Life life(9);
  auto journal = MapJournal::open(storage, kFolder, test::some_header());
  ASSERT_TRUE(journal);
  ASSERT_TRUE(life.step(*journal));
  storage.capacity = 0;
  for (int i = 0; i < 4; ++i) {
    const Status full = life.step(*journal);
    ASSERT_FALSE(full);
    EXPECT_NE(full.error().message.find("No space left"), std::string::npos);
    for (int way = 0; way < 10; ++way)
      life.expect_nothing_lost(*storage.after_power_cut(random), "full disk");
  }
  EXPECT_GT(journal->uncommitted_tiles(), 0u);
  storage.capacity = UINT64_MAX;
  ASSERT_TRUE(life.step(*journal));
  EXPECT_EQ(journal->uncommitted_tiles(), 0u);
  for (int way = 0; way < 10; ++way)
    life.expect_nothing_lost(*storage.after_power_cut(random), "room again");
}

TEST(PowerCut, ADiskThatFillsInTheMiddleOfABatchLeavesNoHalfOfIt) {
  for (std::uint64_t room = 0; room < 6000; room += 500) {
    LosingStorage storage;
    std::mt19937 random(4);
    Life life(11);
    auto journal = MapJournal::open(storage, kFolder, test::some_header());
    ASSERT_TRUE(journal);
    ASSERT_TRUE(life.step(*journal));
    std::uint64_t used = 0;
    for (const std::string& name : storage.names()) used += storage.bytes(kFolder / name).size();
    storage.capacity = used + room;
    (void)life.step(*journal).ok();
    storage.capacity = UINT64_MAX;
    ASSERT_TRUE(life.step(*journal));
    for (int way = 0; way < 10; ++way)
      life.expect_nothing_lost(*storage.after_power_cut(random), "filled");
  }
}

TEST(PowerCut, AFailedSyncIsNotTrustedAndItsChangesAreWrittenAnew) {
  LosingStorage storage;
  std::mt19937 random(5);
  Life life(13);
  auto journal = MapJournal::open(storage, kFolder, test::some_header());
  ASSERT_TRUE(journal);
  ASSERT_TRUE(life.step(*journal));
  storage.syncs_fail = true;
  ASSERT_FALSE(life.step(*journal));
  storage.syncs_fail = false;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(life.step(*journal));
    for (int way = 0; way < 20; ++way)
      life.expect_nothing_lost(*storage.after_power_cut(random), "after a failed sync");
  }
}

}  // namespace
}  // namespace watersky
