// SPDX-License-Identifier: MIT
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "watersky/base/bytes.hpp"

namespace watersky::test {

/// A DataFlash log, record by record.
class DataflashMaker {
 public:
  template <std::size_t n>
  static std::array<char, n> text(std::string_view value) {
    std::array<char, n> out{};
    std::copy_n(value.begin(), std::min(n, value.size()), out.begin());
    return out;
  }

  /// An FMT record; `length` where it is to be wrong.
  void format(std::uint8_t type, std::string_view name, std::string_view letters,
              std::string_view columns, std::uint8_t length = 0) {
    static const std::map<char, int> kSizes = {
        {'b', 1}, {'B', 1}, {'M', 1}, {'h', 2}, {'H', 2},  {'i', 4},  {'I', 4},
        {'q', 8}, {'Q', 8}, {'f', 4}, {'d', 8}, {'g', 2},  {'c', 2},  {'C', 2},
        {'e', 4}, {'E', 4}, {'L', 4}, {'n', 4}, {'N', 16}, {'Z', 64}, {'a', 64}};
    if (length == 0) {
      length = 3;
      for (const char letter : letters)
        length = static_cast<std::uint8_t>(length + kSizes.at(letter));
    }
    record(128, type, length, text<4>(name), text<16>(letters), text<64>(columns));
  }

  template <class... Values>
  void record(std::uint8_t type, const Values&... values) {
    for (const std::uint8_t head : {std::uint8_t{0xA3}, std::uint8_t{0x95}, type})
      put(bytes_, head);
    (append(values), ...);
  }

  Bytes& bytes() { return bytes_; }

 private:
  template <class T>
  void append(const T& value) {
    if constexpr (std::is_arithmetic_v<T>)
      put(bytes_, value);
    else
      bytes_.insert(bytes_.end(), value.begin(), value.end());
  }
  Bytes bytes_;
};

}  // namespace watersky::test
