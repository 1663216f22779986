// SPDX-License-Identifier: MIT
#pragma once
/// Numbers as they lie in IMC packets, of either byte order.
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "watersky/wire/imc_schema.hpp"

namespace watersky::imc::detail {

static_assert(std::endian::native == std::endian::little, "the swaps below take that for granted");

template <class Whole>
[[nodiscard]] Whole swapped(Whole value) {
  if constexpr (sizeof value == 2) return __builtin_bswap16(value);
  if constexpr (sizeof value == 4) return __builtin_bswap32(value);
  if constexpr (sizeof value == 8) return __builtin_bswap64(value);
  return value;
}

/// An unsigned number at `p`.
template <class Whole>
[[nodiscard]] Whole load(const std::uint8_t* p, std::endian order) {
  Whole value;
  std::memcpy(&value, p, sizeof value);
  return order == std::endian::little ? value : swapped(value);
}

/// The bits of a number of `size` bytes.
[[nodiscard]] inline std::uint64_t load_bits(const std::uint8_t* p, std::size_t size,
                                             std::endian order) {
  switch (size) {
    case 1: return *p;
    case 2: return load<std::uint16_t>(p, order);
    case 4: return load<std::uint32_t>(p, order);
    default: return load<std::uint64_t>(p, order);
  }
}

[[nodiscard]] constexpr bool is_number(FieldType type) { return type <= FieldType::F64; }
[[nodiscard]] constexpr bool is_whole(FieldType type) { return type <= FieldType::I64; }

/// Calls `use` with a zero of the field's C++ type; for numbers only.
template <class Use>
auto with_type(FieldType type, Use&& use) {
  switch (type) {
    case FieldType::I8: return use(std::int8_t{});
    case FieldType::U16: return use(std::uint16_t{});
    case FieldType::I16: return use(std::int16_t{});
    case FieldType::U32: return use(std::uint32_t{});
    case FieldType::I32: return use(std::int32_t{});
    case FieldType::I64: return use(std::int64_t{});
    case FieldType::F32: return use(float{});
    case FieldType::F64: return use(double{});
    default: return use(std::uint8_t{});
  }
}

/// The number that `bits` are.
template <class As>
[[nodiscard]] As number_from(std::uint64_t bits, FieldType type) {
  return with_type(type, [&](auto value) {
    std::memcpy(&value, &bits, sizeof value);
    return static_cast<As>(value);
  });
}

template <class Number>
[[nodiscard]] std::uint64_t bits_of(Number value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof value);
  return bits;
}

}  // namespace watersky::imc::detail
