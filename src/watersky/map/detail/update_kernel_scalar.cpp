// SPDX-License-Identifier: MIT
#include "watersky/map/detail/simd_scalar.hpp"
// After the lanes that it is written in.
#include "watersky/map/detail/update_kernel_impl.hpp"

namespace watersky::detail {

const UpdateKernels kScalarKernels = kKernels;

}  // namespace watersky::detail
