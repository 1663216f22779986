// SPDX-License-Identifier: MIT
#pragma once
/// Whole files, or none.
#include <filesystem>
#include <string_view>

#include "watersky/base/result.hpp"

namespace watersky::io::detail {

/// Writes under a temporary name in the same folder and renames, so that nobody ever reads half
/// a file. Io when the system refuses (no space, no permission); then nothing is left.
Status write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace watersky::io::detail
