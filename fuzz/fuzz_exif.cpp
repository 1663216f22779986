// SPDX-License-Identifier: MIT
/// The head of a JPEG: segments, EXIF, XMP, and the intrinsics made of them.
#include <cstdint>

#include "watersky/io/camera_table.hpp"
#include "watersky/io/exif.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  if (const auto photo = parse_photo_metadata({data, size})) {
    (void)photo->utc();
    (void)intrinsics_from(*photo);
  }
  return 0;
}
