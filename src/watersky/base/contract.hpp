// SPDX-License-Identifier: MIT
#pragma once
/// Contracts: what must be true if we made no mistake. Fatal without NDEBUG, free with it.
#include <cassert>

#define WATERSKY_REQUIRE(condition) assert(condition)
