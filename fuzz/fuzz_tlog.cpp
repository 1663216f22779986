// SPDX-License-Identifier: MIT
/// Logs as bytes: MAVLink frames, resynchronisation, clocks and the trajectory made of them.
#include <cstdint>
#include <cstdlib>

#include "watersky/io/autopilot_log.hpp"
#include "watersky/wire/tlog.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  const std::span bytes(data, size);
  mavlink::TlogReader reader(bytes);
  std::size_t used = 0;
  while (const auto record = reader.next()) used += 8 + record->frame.bytes.size();
  if (used + reader.skipped_bytes() + reader.truncated_bytes() != size) std::abort();
  if (const auto log = parse_tlog(bytes, "fuzz.tlog")) {
    const PositionSample& p = log->positions.front();
    (void)make_trajectory(*log, Datum({p.latitude, p.longitude, 0.0}));
  }
  return 0;
}
