// SPDX-License-Identifier: MIT
#include "watersky/map/detail/simd_sse41.hpp"
// After the lanes that it is written in.
#include "watersky/map/detail/update_kernel_impl.hpp"

namespace watersky::detail {

const UpdateKernels kSse41Kernels = kKernels;

}  // namespace watersky::detail
