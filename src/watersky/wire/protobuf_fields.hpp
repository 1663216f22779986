// SPDX-License-Identifier: MIT
#pragma once
/// How messages describe their fields for protobuf.hpp.
#include <array>
#include <cstdint>

namespace watersky::protobuf {

struct FieldInfo {
  std::int32_t number;
  const char* name;
};

struct TypeName {
  const char* package;
  const char* name;
};

/// An enumeration of one message, its values counted from 0.
template <std::size_t N>
struct EnumInfo {
  const char* name;
  std::array<const char*, N> values;
};

}  // namespace watersky::protobuf
