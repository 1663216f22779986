// SPDX-License-Identifier: MIT
#include "watersky/io/detail/csv_checks.hpp"

namespace watersky::detail {

Status times_must_rise(const CsvTable& table, std::size_t row, Time before, Time now) {
  if (now > before) return {};
  return Error{ErrorCode::InvalidInput,
               table.place(row) + (now == before ? ": has the same time as " +
                                                       table.place(row - 1) + "; remove one of them"
                                                 : ": is earlier than " + table.place(row - 1) +
                                                       "; sort the lines by time")};
}

void note_unknown(const CsvTable& table, const std::vector<std::string>& unknown,
                  std::vector<std::string>& notes) {
  if (unknown.empty()) return;
  std::string list;
  for (const std::string& u : unknown) list += (list.empty() ? "" : ", ") + u;
  notes.push_back(table.name() +
                  ": columns that mean nothing to us were ignored: " + list.substr(0, 200));
}

}  // namespace watersky::detail
