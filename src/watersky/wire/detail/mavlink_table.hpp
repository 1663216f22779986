// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

namespace watersky::mavlink::detail {

/// One message as a person writes it; see mavlink_messages.cpp.
struct TableRow {
  std::uint32_t id;
  std::string_view name;
  std::uint8_t crc_extra;
  std::uint8_t min_length;
  std::uint8_t max_length;
  std::string_view fields;
};

[[nodiscard]] std::span<const TableRow> table_rows();

}  // namespace watersky::mavlink::detail
