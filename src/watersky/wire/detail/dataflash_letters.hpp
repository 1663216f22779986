// SPDX-License-Identifier: MIT
#pragma once
/// The layout of DataFlash records, for those who read and those who write.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace watersky::dataflash::detail {

inline constexpr std::uint8_t kHead1 = 0xA3, kHead2 = 0x95;
inline constexpr std::size_t kHead = 3;
inline constexpr std::uint8_t kFmt = 128;
inline constexpr std::size_t kFmtLength = 89;

/// What a letter of FMT means.
struct Letter {
  char letter;
  std::size_t size;
  double scale;  ///< 0: text or an array, no number
};
inline constexpr Letter kLetters[] = {
    {'b', 1, 1},    {'B', 1, 1},    {'M', 1, 1},    {'h', 2, 1},    {'H', 2, 1},    {'i', 4, 1},
    {'I', 4, 1},    {'q', 8, 1},    {'Q', 8, 1},    {'f', 4, 1},    {'d', 8, 1},    {'g', 2, 1},
    {'c', 2, 0.01}, {'C', 2, 0.01}, {'e', 4, 0.01}, {'E', 4, 0.01}, {'L', 4, 1e-7}, {'n', 4, 0},
    {'N', 16, 0},   {'Z', 64, 0},   {'a', 64, 0},
};

[[nodiscard]] inline const Letter* find_letter(char letter) {
  const auto* found = std::find_if(std::begin(kLetters), std::end(kLetters),
                                   [&](const Letter& l) { return l.letter == letter; });
  return found == std::end(kLetters) ? nullptr : found;
}

}  // namespace watersky::dataflash::detail
