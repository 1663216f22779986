// SPDX-License-Identifier: MIT
/// A stand-in for OpenCL drivers that are broken; WATERSKY_TEST_DRIVER says how. As a driver that
/// the loader opens it crashes or hangs. As the loader itself (OPENCV_OPENCL_RUNTIME) it passes
/// every call on to the true one, but kernels do a small part of their work.
#include <dlfcn.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <string_view>

namespace {

std::string_view fault() {
  const char* name = std::getenv("WATERSKY_TEST_DRIVER");
  return name ? name : "";
}

__attribute__((constructor)) void loaded() {
  if (fault() == "crash") std::raise(SIGSEGV);
  while (fault() == "hang") ::sleep(1);
}

}  // namespace

// OpenCV asks this library for each function; those that are not here are found in the libraries
// that it is linked with: the true loader.
extern "C" int clEnqueueNDRangeKernel(void* queue, void* kernel, unsigned dimensions,
                                      const std::size_t* offset, const std::size_t* global,
                                      const std::size_t* local, unsigned waits,
                                      const void* wait_for, void* event) {
  using Enqueue = decltype(&clEnqueueNDRangeKernel);
  static const auto true_one =
      reinterpret_cast<Enqueue>(::dlsym(RTLD_NEXT, "clEnqueueNDRangeKernel"));
  std::size_t part[3];
  for (unsigned i = 0; i < dimensions; ++i) part[i] = local ? local[i] : 1;
  return true_one(queue, kernel, dimensions, offset, fault() == "wrong" ? part : global, local,
                  waits, wait_for, event);
}
