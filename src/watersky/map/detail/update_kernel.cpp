// SPDX-License-Identifier: MIT
#include "watersky/map/detail/update_kernel.hpp"

namespace watersky::detail {

const UpdateKernels* const* all_update_kernels() {
  struct Found {
    const UpdateKernels* kernels[4] = {};
  };
  static const Found found = [] {
    Found f;
    std::size_t count = 0;
    f.kernels[count++] = &kScalarKernels;
#if defined(WATERSKY_X86_KERNELS)
    if (__builtin_cpu_supports("sse4.1")) f.kernels[count++] = &kSse41Kernels;
    if (__builtin_cpu_supports("avx2")) f.kernels[count++] = &kAvx2Kernels;
#elif defined(__aarch64__)
    f.kernels[count++] = &kNeonKernels;
#endif
    return f;
  }();
  return found.kernels;
}

const UpdateKernels& update_kernels() {
  static const UpdateKernels& fastest = []() -> const UpdateKernels& {
    const UpdateKernels* const* k = all_update_kernels();
    while (k[1] != nullptr) ++k;
    return **k;
  }();
  return fastest;
}

}  // namespace watersky::detail
