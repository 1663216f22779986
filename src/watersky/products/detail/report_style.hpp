// SPDX-License-Identifier: MIT
#pragma once
/// How a report looks.
#include <string>

namespace watersky::detail {

/// The page's style sheet; its colours come from palette.hpp.
[[nodiscard]] std::string report_css();

}  // namespace watersky::detail
