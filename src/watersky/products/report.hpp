// SPDX-License-Identifier: MIT
#pragma once
/// report.html: one page that needs nothing else. It reads on a phone, on paper, in light and in
/// dark.
#include <filesystem>
#include <string>

#include "watersky/products/products.hpp"

namespace watersky {

/// The page. Pictures inside are at most 2000 cells wide and high. Fails only when a picture
/// cannot be encoded.
[[nodiscard]] Result<std::string> report_html(const Products& products);

Status write_report(const std::filesystem::path& path, const Products& products);

}  // namespace watersky
