// SPDX-License-Identifier: MIT
/// Model files of the ice classifier, as they are and with the checksum that they should have.
#include <boost/crc.hpp>
#include <cstdint>
#include <cstdio>

#include "watersky/vision/ice_model.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string text(reinterpret_cast<const char*>(data), size);
  (void)watersky::parse_ice_model(text, "fuzz.ice-model");
  if (!text.empty() && text.back() != '\n') text += '\n';
  boost::crc_32_type crc;
  crc.process_bytes(text.data(), text.size());
  char last[32];
  std::snprintf(last, sizeof last, "crc32 %x\n", crc.checksum());
  if (const auto model = watersky::parse_ice_model(text + last, "fuzz.ice-model"))
    if (!watersky::parse_ice_model(watersky::format_ice_model(*model), "again")) __builtin_trap();
  return 0;
}
