// SPDX-License-Identifier: MIT
#pragma once
/// Errors that name the byte.
#include "watersky/wire/byte_source.hpp"

namespace watersky::detail {

[[nodiscard]] inline Error bad_at(std::uint64_t offset, const std::string& what) {
  return {ErrorCode::InvalidInput, "byte " + std::to_string(offset) + ": " + what};
}

/// Without the error's own "byte N: " where that is the same.
[[nodiscard]] inline Damage damage_at(std::uint64_t offset, const Error& error) {
  const std::string prefix = "byte " + std::to_string(offset) + ": ";
  return {offset, error.message.rfind(prefix, 0) == 0 ? error.message.substr(prefix.size())
                                                      : error.message};
}

}  // namespace watersky::detail
