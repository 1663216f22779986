// SPDX-License-Identifier: MIT
#pragma once
/// Reflected 16 bit CRCs, eight bytes a step ("slicing by 8").
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace watersky::detail {

/// table[k][b]: the remainder of byte b with k zero bytes behind it.
template <std::uint16_t kReflectedPolynomial>
inline constexpr auto kCrc16Table = [] {
  std::array<std::array<std::uint16_t, 256>, 8> table{};
  for (std::uint16_t b = 0; b < 256; ++b) {
    std::uint16_t c = b;
    for (int bit = 0; bit < 8; ++bit)
      c = static_cast<std::uint16_t>((c >> 1) ^ ((c & 1) != 0 ? kReflectedPolynomial : 0));
    table[0][b] = c;
  }
  for (std::size_t k = 1; k < 8; ++k)
    for (std::size_t b = 0; b < 256; ++b) {
      const std::uint16_t c = table[k - 1][b];
      table[k][b] = static_cast<std::uint16_t>((c >> 8) ^ table[0][c & 0xFF]);
    }
  return table;
}();

/// The remainder of `bytes`, continued from `crc`; nothing is added at the end.
template <std::uint16_t kReflectedPolynomial>
[[nodiscard]] inline std::uint16_t crc16(std::span<const std::uint8_t> bytes, std::uint16_t crc) {
  constexpr auto& t = kCrc16Table<kReflectedPolynomial>;
  const std::uint8_t* p = bytes.data();
  std::size_t n = bytes.size();
  for (; n >= 8; n -= 8, p += 8)
    crc = static_cast<std::uint16_t>(t[7][p[0] ^ (crc & 0xFF)] ^ t[6][p[1] ^ (crc >> 8)] ^
                                     t[5][p[2]] ^ t[4][p[3]] ^ t[3][p[4]] ^ t[2][p[5]] ^
                                     t[1][p[6]] ^ t[0][p[7]]);
  for (; n > 0; --n, ++p) crc = static_cast<std::uint16_t>((crc >> 8) ^ t[0][(crc ^ *p) & 0xFF]);
  return crc;
}

}  // namespace watersky::detail
