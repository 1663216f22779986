// SPDX-License-Identifier: MIT
#pragma once
/// The compressions of MCAP and rosbag chunks.
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

enum class Compression {
  None,
  Lz4,   ///< the frame format
  Zstd,  ///< MCAP only
  Bz2    ///< rosbag only
};

/// "none", "lz4", "zstd", "bz2".
[[nodiscard]] std::string_view to_string(Compression compression);

[[nodiscard]] Result<std::vector<std::uint8_t>> compress(Compression compression,
                                                         std::span<const std::uint8_t> bytes);

/// InvalidInput unless `bytes` unfold to exactly `size` bytes. Memory grows with what comes out,
/// never with what is claimed.
[[nodiscard]] Result<std::vector<std::uint8_t>> decompress(Compression compression,
                                                           std::span<const std::uint8_t> bytes,
                                                           std::uint64_t size);

/// zlib's CRC-32 of `bytes`, continued from `crc`.
[[nodiscard]] std::uint32_t crc32_of(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

}  // namespace watersky
