// SPDX-License-Identifier: MIT
/// A live map's folder with one journal in it, read and gone on with; as it is, and with the
/// checksums that its parts should have.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "support/losing_storage.hpp"
#include "support/map_tiles.hpp"
#include "support/mend_checksums.hpp"
#include "watersky/store/map_journal.hpp"

namespace {

using namespace watersky;

void live_on(const std::vector<std::uint8_t>& bytes) {
  test::LosingStorage storage;
  const std::filesystem::path folder = "live";
  if (!storage.make_folder(folder)) std::abort();
  auto file = storage.open(folder / "journal-00000001.wsj", FileAccess::Create);
  if (!file || !(*file)->append(bytes)) std::abort();
  const auto store = MapStore::open(storage, folder);
  if (store)
    for (const TileItem& item : store->tiles().items()) (void)item.load().ok();
  auto journal = MapJournal::open(storage, folder, store ? store->header() : test::some_header());
  if (!journal || journal->header().sources.empty()) return;
  MapTile tile;
  test::look(tile, 1, 2, 300, test::at_second(1));
  journal->change({3, 4}, UINT64_MAX, tile);
  if (!journal->commit(test::at_second(1))) std::abort();
  const auto again = MapStore::open(storage, folder);
  if (!again) std::abort();
  for (const TileItem& item : again->tiles().of({3, 4}))
    if (item.version == UINT64_MAX && !(item.load() && *item.load() == tile)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> bytes(data, data + size);
  live_on(bytes);
  test::mend_checksums(bytes);
  live_on(bytes);
  return 0;
}
