// SPDX-License-Identifier: MIT
/// FLIR's thermal data in a JPEG: chunks, directory, raw image, camera record. What is too long to
/// be found by chance, the JPEG around it, is put there.
#include <cstdint>
#include <vector>

#include "watersky/io/flir.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  (void)find_flir_image({data, size}, "fuzzed");
  if (size > 60000) return 0;
  const auto length = static_cast<unsigned>(size + 10);
  std::vector<std::uint8_t> jpeg = {0xFF,
                                    0xD8,
                                    0xFF,
                                    0xE1,
                                    static_cast<std::uint8_t>(length >> 8),
                                    static_cast<std::uint8_t>(length),
                                    'F',
                                    'L',
                                    'I',
                                    'R',
                                    0,
                                    1,
                                    0,
                                    0};
  jpeg.insert(jpeg.end(), data, data + size);
  if (const auto image = find_flir_image(jpeg, "fuzzed"); image && *image && (*image)->scale)
    (void)kelvin_of(13000, *(*image)->scale);
  return 0;
}
