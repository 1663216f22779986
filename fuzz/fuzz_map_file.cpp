// SPDX-License-Identifier: MIT
/// Map files: opened, read to their last tile, recovered; as they are, and with the checksums that
/// their parts should have, so that what stands behind a checksum is met as well.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "support/mend_checksums.hpp"
#include "watersky/store/map_file.hpp"

namespace {

using namespace watersky;

void read_all(const Result<MapFile>& file) {
  if (!file) return;
  for (const TileItem& item : file->tiles().items())
    if (const auto tile = item.load()) {
      // What was read can be written, and comes back.
      const auto again = unpack(pack(*tile));
      if (!again || !(*again == *tile)) std::abort();
    }
  for (int level = 1; level <= file->levels(); ++level)
    for (const TileIndex& index : file->overviews(level)) (void)file->overview(level, index).ok();
  if (!parse_header(header_json(file->header()))) std::abort();
}

void read_both_ways(const std::vector<std::uint8_t>& bytes) {
  read_all(MapFile::open(memory_file("fuzz.wsmap", bytes)));
  read_all(MapFile::recover(memory_file("fuzz.wsmap", bytes)));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> bytes(data, data + size);
  read_both_ways(bytes);
  test::mend_checksums(bytes);
  read_both_ways(bytes);
  return 0;
}
