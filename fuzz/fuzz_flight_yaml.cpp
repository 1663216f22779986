// SPDX-License-Identifier: MIT
#include <cstdint>

#include "watersky/io/flight_folder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)watersky::parse_flight_yaml(std::string(reinterpret_cast<const char*>(data), size),
                                    "flight.yaml");
  return 0;
}
