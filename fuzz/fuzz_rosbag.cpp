// SPDX-License-Identifier: MIT
/// Bags: read by their index or without it, every message twice.
#include <cstdint>
#include <cstdlib>

#include "watersky/wire/rosbag.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  const auto reader = rosbag::Reader::open(
      std::make_shared<MemorySource>(std::vector<std::uint8_t>(data, data + size)),
      {.max_record_bytes = 1 << 20});
  if (!reader) {
    if (reader.error().message.find("byte ") == std::string::npos) std::abort();
    return 0;
  }
  std::size_t n = 0;
  const auto damage =
      reader->for_each([&](const rosbag::Message& m, const rosbag::Location& where) {
        if (++n > 2000) return;
        const auto again = reader->read(where);
        if (!again || !std::equal(again->begin(), again->end(), m.data.begin(), m.data.end()))
          std::abort();
      });
  if (!damage) std::abort();  // memory does not fail to be read
  return 0;
}
