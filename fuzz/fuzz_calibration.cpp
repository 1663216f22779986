// SPDX-License-Identifier: MIT
/// Calibration files as text, YAML and XML.
#include <cstdint>

#include "watersky/camera/calibration_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  for (const char* name : {"fuzz.yaml", "fuzz.xml"})
    if (const auto camera = watersky::parse_calibration(text, name))
      (void)camera->direction({0.0, 0.0});
  return 0;
}
