// SPDX-License-Identifier: MIT
/// DataFlash logs: what they say of themselves, resynchronisation, clocks and the trajectory.
#include <cstdint>
#include <cstdlib>

#include "watersky/io/dataflash_log.hpp"
#include "watersky/wire/dataflash.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  const std::span bytes(data, size);
  dataflash::Reader reader(bytes);
  std::size_t used = 0;
  while (const auto record = reader.next()) {
    used += record->format->length;
    for (const dataflash::Field& field : record->format->fields) {
      if (field.type == 'n' || field.type == 'N' || field.type == 'Z')
        (void)record->text(field.name);
      else if (field.type != 'a')
        (void)record->number(field.name);
    }
  }
  if (used + reader.skipped_bytes() + reader.truncated_bytes() != size) std::abort();
  (void)reader.formats();
  if (const auto log = parse_dataflash(bytes, "fuzz.bin")) {
    const PositionSample& p = log->positions.front();
    (void)make_trajectory(*log, Datum({p.latitude, p.longitude, 0.0}));
  }
  return 0;
}
