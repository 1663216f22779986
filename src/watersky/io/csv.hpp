// SPDX-License-Identifier: MIT
#pragma once
/// A small strict reader of comma-separated values with a line of column names: quotes as in
/// RFC 4180, CRLF, a byte order mark. Numbers must be finite; errors name the file and line.
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"

namespace watersky {

class CsvTable {
 public:
  /// `name` stands in errors: "poses.csv". Empty lines are skipped; a line with another number
  /// of cells than the header, an empty or repeated column name, or an open quote is InvalidInput.
  [[nodiscard]] static Result<CsvTable> parse(std::string_view text, std::string name);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] std::size_t rows() const { return lines_.size(); }

  [[nodiscard]] std::optional<std::size_t> column(std::string_view column_name) const;
  /// NotFound naming the first column that is missing.
  [[nodiscard]] Status require(std::initializer_list<std::string_view> column_names) const;
  /// Columns that are not among `known`.
  [[nodiscard]] std::vector<std::string> unknown_columns(
      std::initializer_list<std::string_view> known) const;

  [[nodiscard]] const std::string& cell(std::size_t row, std::size_t column) const {
    return cells_[row * columns_.size() + column];
  }
  /// A finite number.
  [[nodiscard]] Result<double> number(std::size_t row, std::size_t column) const;
  /// Seconds since the epoch, exact to the nanosecond.
  [[nodiscard]] Result<Time> time(std::size_t row, std::size_t column) const;
  /// "poses.csv:7"
  [[nodiscard]] std::string place(std::size_t row) const;

 private:
  std::string name_;
  std::vector<std::string> columns_;
  std::vector<std::string> cells_;
  std::vector<std::size_t> lines_;  ///< where each row begins, from 1
};

/// A whole finite decimal number, nothing before or after it ('+' allowed); nullopt otherwise.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// "1533430844.480000001" to the nanosecond, digits beyond it rounded. A double of today's UTC
/// seconds could hold only 0.24 µs. nullopt for what is no time before the year 2262.
[[nodiscard]] std::optional<Time> parse_time_seconds(std::string_view text);
/// parse_time_seconds undoes it.
[[nodiscard]] std::string format_time_seconds(Time t);

/// The shortest text from which parse_number gives the same double.
[[nodiscard]] std::string format_number(double x);

/// A cell, in quotes where it needs them.
[[nodiscard]] std::string csv_cell(std::string_view text);

}  // namespace watersky
