// SPDX-License-Identifier: MIT
#include "watersky/io/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace watersky {

namespace {

/// One record of cells, and where the next one begins.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  [[nodiscard]] bool at_end() const { return at_ >= text_.size(); }
  [[nodiscard]] std::size_t line() const { return line_; }

  Result<std::vector<std::string>> record() {
    std::vector<std::string> cells(1);
    while (true) {
      if (at_end()) return cells;
      const char c = text_[at_];
      if (c == '"' && cells.back().empty() && !quoted_) {
        WATERSKY_CHECK(quoted(cells.back()));
        continue;
      }
      ++at_;
      if (c == '\n' || (c == '\r' && (at_end() || text_[at_] == '\n'))) {
        if (c == '\r' && !at_end()) ++at_;
        ++line_;
        quoted_ = false;
        return cells;
      }
      if (c == ',') {
        cells.emplace_back();
        quoted_ = false;
        continue;
      }
      if (c == '\0') return bad("holds a zero byte; is it a text file?");
      if (quoted_ || c == '"') return bad("has a quotation mark inside a cell");
      cells.back() += c;
    }
  }

 private:
  static Error bad(std::string message) { return {ErrorCode::InvalidInput, std::move(message)}; }

  Status quoted(std::string& cell) {
    quoted_ = true;
    for (++at_; !at_end(); ++at_) {
      const char c = text_[at_];
      if (c == '"') {
        ++at_;
        if (at_end() || text_[at_] != '"') return {};
      }
      if (c == '\n') ++line_;
      cell += c;
    }
    return bad("has a quotation mark that is never closed");
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  bool quoted_ = false;  ///< the cell at hand was quoted and has ended
};

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t')) s.remove_suffix(1);
  return s;
}

/// What goes into an error message: short, and printable on one line.
std::string shown(std::string_view cell) {
  std::string out;
  for (const char c : cell.substr(0, 40)) out += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  return "\"" + out + (cell.size() > 40 ? "…\"" : "\"");
}

}  // namespace

Result<CsvTable> CsvTable::parse(std::string_view text, std::string name) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  CsvTable table;
  table.name_ = std::move(name);
  Scanner scanner(text);
  const auto bad = [&](std::size_t line, const std::string& what) {
    return Error{ErrorCode::InvalidInput, table.name_ + ":" + std::to_string(line) + ": " + what};
  };
  while (!scanner.at_end()) {
    const std::size_t line = scanner.line();
    auto record = scanner.record();
    if (!record) return bad(line, record.error().message);
    std::vector<std::string>& cells = *record;
    if (cells.size() == 1 && trimmed(cells[0]).empty()) continue;
    if (table.columns_.empty()) {
      for (const std::string& cell : cells) {
        const std::string_view column = trimmed(cell);
        if (column.empty()) return bad(line, "has a column without a name");
        if (table.column(column)) return bad(line, "has two columns named " + shown(column));
        table.columns_.emplace_back(column);
      }
      continue;
    }
    if (cells.size() != table.columns_.size())
      return bad(line, "has " + std::to_string(cells.size()) + " cells where the header has " +
                           std::to_string(table.columns_.size()));
    for (std::string& cell : cells) table.cells_.push_back(std::move(cell));
    table.lines_.push_back(line);
  }
  if (table.columns_.empty())
    return Error{ErrorCode::InvalidInput,
                 table.name_ + ": is empty; its first line must name the columns"};
  return table;
}

std::optional<std::size_t> CsvTable::column(std::string_view column_name) const {
  const auto it = std::find(columns_.begin(), columns_.end(), column_name);
  if (it == columns_.end()) return std::nullopt;
  return static_cast<std::size_t>(it - columns_.begin());
}

Status CsvTable::require(std::initializer_list<std::string_view> column_names) const {
  for (const std::string_view wanted : column_names)
    if (!column(wanted))
      return Error{ErrorCode::NotFound,
                   name_ + ": has no column " + std::string(wanted) + "; add it"};
  return {};
}

std::vector<std::string> CsvTable::unknown_columns(
    std::initializer_list<std::string_view> known) const {
  std::vector<std::string> out;
  for (const std::string& c : columns_)
    if (std::find(known.begin(), known.end(), c) == known.end()) out.push_back(c);
  return out;
}

std::string CsvTable::place(std::size_t row) const {
  return name_ + ":" + std::to_string(lines_[row]);
}

Result<double> CsvTable::number(std::size_t row, std::size_t column) const {
  if (const auto x = parse_number(cell(row, column))) return *x;
  return Error{ErrorCode::InvalidInput, place(row) + ": " + columns_[column] + " is " +
                                            shown(cell(row, column)) +
                                            ", not a finite number; correct or remove the line"};
}

Result<Time> CsvTable::time(std::size_t row, std::size_t column) const {
  if (const auto t = parse_time_seconds(cell(row, column))) return *t;
  return Error{ErrorCode::InvalidInput, place(row) + ": " + columns_[column] + " is " +
                                            shown(cell(row, column)) +
                                            ", not a time in seconds; correct or remove the line"};
}

std::optional<double> parse_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return std::nullopt;
  }
  double x = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (ec != std::errc{} || end != text.data() + text.size() || !std::isfinite(x))
    return std::nullopt;
  return x;
}

std::optional<Time> parse_time_seconds(std::string_view text) {
  text = trimmed(text);
  if (text.find_first_of("eE") != std::string_view::npos) {
    const auto s = parse_number(text);
    return s ? time_from_seconds(*s) : std::nullopt;
  }
  bool negative = false;
  if (text.starts_with('-') || text.starts_with('+')) {
    negative = text.front() == '-';
    text.remove_prefix(1);
  }
  std::int64_t whole = 0, ns = 0;
  std::size_t digits = 0, i = 0;
  const auto digit = [&](std::size_t k) { return text[k] >= '0' && text[k] <= '9'; };
  for (; i < text.size() && digit(i); ++i, ++digits) {
    whole = whole * 10 + (text[i] - '0');
    if (whole > 9'200'000'000) return std::nullopt;
  }
  if (i < text.size() && text[i] == '.') {
    std::int64_t unit = 100'000'000;
    bool rounded = false;
    for (++i; i < text.size() && digit(i); ++i, ++digits) {
      if (unit > 0) {
        ns += unit * (text[i] - '0');
        unit /= 10;
      } else if (!rounded) {
        ns += text[i] >= '5' ? 1 : 0;
        rounded = true;
      }
    }
  }
  if (digits == 0 || i != text.size()) return std::nullopt;
  const std::int64_t all = whole * 1'000'000'000 + ns;
  return Time(Duration(negative ? -all : all));
}

std::string format_time_seconds(Time t) {
  const std::int64_t all = t.time_since_epoch().count();
  const std::uint64_t magnitude = all < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(all)
                                          : static_cast<std::uint64_t>(all);
  char text[40];
  std::snprintf(text, sizeof text, "%s%llu.%09llu", all < 0 ? "-" : "",
                static_cast<unsigned long long>(magnitude / 1'000'000'000),
                static_cast<unsigned long long>(magnitude % 1'000'000'000));
  return text;
}

std::string format_number(double x) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, x).ptr;
  return {text, end};
}

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace watersky
