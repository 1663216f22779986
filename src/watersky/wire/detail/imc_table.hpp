// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

#include "watersky/wire/imc_schema.hpp"

namespace watersky::imc::detail {

struct TypeName {
  FieldType type;
  std::string_view ours;
  std::string_view xml;  ///< in IMC.xml
  std::size_t size;      ///< bytes; 0: varies
};
/// In the order of FieldType.
inline constexpr TypeName kTypes[] = {
    {FieldType::U8, "u8", "uint8_t", 1},          {FieldType::I8, "i8", "int8_t", 1},
    {FieldType::U16, "u16", "uint16_t", 2},       {FieldType::I16, "i16", "int16_t", 2},
    {FieldType::U32, "u32", "uint32_t", 4},       {FieldType::I32, "i32", "int32_t", 4},
    {FieldType::I64, "i64", "int64_t", 8},        {FieldType::F32, "f32", "fp32_t", 4},
    {FieldType::F64, "f64", "fp64_t", 8},         {FieldType::Raw, "raw", "rawdata", 0},
    {FieldType::Text, "text", "plaintext", 0},    {FieldType::Message, "message", "message", 0},
    {FieldType::List, "list", "message-list", 0},
};

/// One message as a person writes it; see imc_messages.cpp.
struct TableRow {
  std::uint16_t id;
  std::string_view name;
  std::string_view fields;
};
struct GroupRow {
  std::string_view name;
  std::string_view members;  ///< a space between
};

[[nodiscard]] std::span<const TableRow> table_rows();
[[nodiscard]] std::span<const GroupRow> group_rows();

}  // namespace watersky::imc::detail
