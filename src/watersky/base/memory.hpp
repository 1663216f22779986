// SPDX-License-Identifier: MIT
#pragma once
/// How the process gets its memory.

namespace watersky {

/// Keeps freed memory for the next picture instead of giving it back to the system, page by page,
/// and asking for it again: a tenth of the time of `map` (bench/map_brighton), a quarter of that
/// of the learned segmenter. For programs, at their start; a library leaves the choice to them.
void keep_freed_memory();

}  // namespace watersky
