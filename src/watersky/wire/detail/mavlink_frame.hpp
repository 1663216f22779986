// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <cstdint>

/// Where things lie in a frame.
namespace watersky::mavlink::detail {

inline constexpr std::uint8_t kMagic1 = 0xFE;
inline constexpr std::uint8_t kMagic2 = 0xFD;
inline constexpr std::size_t kHeader1 = 6;  ///< bytes before the payload
inline constexpr std::size_t kHeader2 = 10;
inline constexpr std::size_t kCrc = 2;
inline constexpr std::size_t kSignature = 13;
inline constexpr std::uint8_t kIncompatSigned = 0x01;

}  // namespace watersky::mavlink::detail
