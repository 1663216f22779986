// SPDX-License-Identifier: MIT
#pragma once
/// Loops compiled for several instruction sets, the best chosen when the program starts.
///
/// A Debian build knows only SSE2. A function marked WATERSKY_MULTIVERSION is compiled also for
/// AVX2 and AVX-512. On ARM NEON is the baseline. Left out under sanitizers, whose run time is
/// not yet set up when the choice is made.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define WATERSKY_MULTIVERSION \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define WATERSKY_MULTIVERSION
#endif
