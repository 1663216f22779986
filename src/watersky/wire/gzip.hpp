// SPDX-License-Identifier: MIT
#pragma once
/// gzip, as far as somebody wrote it before the power went.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

/// Whether the bytes begin as gzip does.
[[nodiscard]] bool is_gzip(std::span<const std::uint8_t> bytes);

struct Gunzipped {
  std::vector<std::uint8_t> bytes;
  bool whole = true;           ///< false: cut short or damaged; `bytes` are what came before
  std::size_t stopped_at = 0;  ///< byte of the input where it ended
};

/// All members, one behind the other, as appending writers leave them. InvalidInput when it is no
/// gzip at all, OutOfRange when more than `max_bytes` would come out.
[[nodiscard]] Result<Gunzipped> gunzip(std::span<const std::uint8_t> bytes, std::size_t max_bytes);

}  // namespace watersky
