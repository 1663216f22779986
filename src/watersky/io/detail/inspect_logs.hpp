// SPDX-License-Identifier: MIT
#pragma once
/// What an autopilot's log holds.
#include <algorithm>

#include "watersky/io/inspect.hpp"

namespace watersky::detail {

inline void add_place(Inspection& out, double latitude_deg, double longitude_deg) {
  if (!out.extent) out.extent.emplace();
  out.extent->add(latitude_deg, longitude_deg);
}

inline void add_time(Inspection& out, Time t) {
  out.first = out.first ? std::min(*out.first, t) : t;
  out.last = out.last ? std::max(*out.last, t) : t;
}

/// Of n samples over a span: n - 1 intervals.
inline void add_rate(Inspection& out, const std::string& what, std::size_t n, Time first,
                     Time last) {
  if (n > 1 && last > first)
    out.rates_hz[what] = static_cast<double>(n - 1) / to_seconds(last - first);
}

/// InvalidInput when the file is no log of its kind.
[[nodiscard]] Result<Inspection> inspect_tlog(const std::filesystem::path& file);
[[nodiscard]] Result<Inspection> inspect_dataflash(const std::filesystem::path& file);
[[nodiscard]] Result<Inspection> inspect_lsf(const std::filesystem::path& file);

}  // namespace watersky::detail
