// SPDX-License-Identifier: MIT
#include "watersky/base/memory.hpp"

#include <malloc.h>

namespace watersky {

void keep_freed_memory() {
  constexpr int kLargestPicture = 1 << 29;
  mallopt(M_MMAP_THRESHOLD, kLargestPicture);
  mallopt(M_TRIM_THRESHOLD, kLargestPicture);
}

}  // namespace watersky
