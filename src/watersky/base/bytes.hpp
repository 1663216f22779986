// SPDX-License-Identifier: MIT
#pragma once
/// Little-endian numbers into bytes and out of them.
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace watersky {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie");

using Bytes = std::vector<std::uint8_t>;

template <class T>
  requires std::is_arithmetic_v<T>
void put(Bytes& out, T value) {
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

/// The number at `at`; the caller has seen that it is there.
template <class T>
[[nodiscard]] T number_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

}  // namespace watersky
