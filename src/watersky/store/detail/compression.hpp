// SPDX-License-Identifier: MIT
#pragma once
/// zstd, in one place.
#include <span>

#include "watersky/base/result.hpp"
#include "watersky/base/bytes.hpp"

namespace watersky::detail {

[[nodiscard]] Bytes compress(std::span<const std::uint8_t> bytes);
/// InvalidInput when it is not exactly `size` bytes.
[[nodiscard]] Result<Bytes> decompress(std::span<const std::uint8_t> bytes, std::size_t size);

}  // namespace watersky::detail
