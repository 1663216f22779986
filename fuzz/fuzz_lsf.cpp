// SPDX-License-Identifier: MIT
/// DUNE's logs, packed or not: gzip, packets, clocks and the trajectory made of them.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "watersky/io/lsf_log.hpp"
#include "watersky/wire/gzip.hpp"
#include "watersky/wire/lsf.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  const auto& schema = imc::Schema::builtin();
  std::span bytes(data, size);
  std::vector<std::uint8_t> unpacked;
  if (is_gzip(bytes)) {
    auto out = gunzip(bytes, std::size_t{1} << 20);
    if (!out) return 0;
    unpacked = std::move(out->bytes);
    bytes = unpacked;
  }
  imc::LsfReader reader(bytes, schema);
  std::size_t used = 0;
  while (const auto record = reader.next()) used += record->packet.bytes.size();
  if (used + reader.skipped_bytes() + reader.truncated_bytes() != bytes.size()) std::abort();
  if (const auto log = parse_lsf(bytes, schema, "fuzz.lsf")) {
    const PositionSample& p = log->positions.front();
    (void)make_trajectory(*log, Datum({p.latitude, p.longitude, 0.0}));
  }
  return 0;
}
