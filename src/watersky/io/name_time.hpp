// SPDX-License-Identifier: MIT
#pragma once
/// Times that stand in file names.
#include <optional>
#include <string_view>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"

namespace watersky {

/// By a pattern of Y M D h m s and c (fraction of a second), '?' for any one character; all
/// others stand for themselves. It may match anywhere in the name; nullopt when it does not.
[[nodiscard]] std::optional<Time> time_from_name(std::string_view stem, std::string_view pattern);

/// Usage unless the pattern names year (four digits) to second (two digits each).
[[nodiscard]] Status check_name_pattern(std::string_view pattern);

/// Times that say themselves that they are UTC: a date and time that ends in Z
/// (2018080501004480Z, 2018-08-05T01-00-44.80Z), or seconds, milli-, micro- or nanoseconds since
/// 1970. Anything else might be a local time and is not guessed at.
[[nodiscard]] std::optional<Time> utc_from_name(std::string_view stem);

/// ISO 8601 to the second or finer that says its zone: Z or an offset such as +02:00. nullopt for
/// anything more or less.
[[nodiscard]] std::optional<Time> parse_iso8601(std::string_view text);

}  // namespace watersky
