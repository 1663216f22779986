# SPDX-License-Identifier: MIT
# Toolchain: builds on a PC for AArch64 with Debian's cross compiler, against the folder of
# arm64 packages that scripts/aarch64 makes, and runs what was built under qemu-user.
# WATERSKY_SYSROOT: another such folder, for instance the root of a board, mounted.
set(WATERSKY_SYSROOT "${CMAKE_CURRENT_LIST_DIR}/../build/aarch64-sysroot" CACHE PATH
    "The arm64 Debian that is built against")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES WATERSKY_SYSROOT)
get_filename_component(sysroot "${WATERSKY_SYSROOT}" ABSOLUTE)
if(NOT EXISTS "${sysroot}/usr/lib/aarch64-linux-gnu")
  message(FATAL_ERROR "${sysroot} holds no arm64 Debian; scripts/aarch64 makes it")
endif()

set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_SYSROOT "${sysroot}")
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR "qemu-aarch64-static;-L;${sysroot}")

# Programs are this machine's; libraries, headers and packages only the board's.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} "${sysroot}")
set(ENV{PKG_CONFIG_LIBDIR}
    "${sysroot}/usr/lib/aarch64-linux-gnu/pkgconfig:${sysroot}/usr/share/pkgconfig")

# The libraries that libraries need, which Debian's alternatives would have put in place.
string(APPEND CMAKE_EXE_LINKER_FLAGS_INIT
       " -Wl,-rpath-link,${sysroot}/usr/lib/aarch64-linux-gnu"
       ":${sysroot}/usr/lib/aarch64-linux-gnu/blas:${sysroot}/usr/lib/aarch64-linux-gnu/lapack")
