// SPDX-License-Identifier: MIT
#pragma once
/// What all tables of a flight have in common.
#include "watersky/io/csv.hpp"

namespace watersky::detail {

/// InvalidInput naming the line when `now`, of `row`, is not later than the row before.
[[nodiscard]] Status times_must_rise(const CsvTable& table, std::size_t row, Time before, Time now);

/// One note of columns that mean nothing to us, where there are any.
void note_unknown(const CsvTable& table, const std::vector<std::string>& unknown,
                  std::vector<std::string>& notes);

}  // namespace watersky::detail
