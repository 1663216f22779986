// SPDX-License-Identifier: MIT
#pragma once
/// Folders that hold a run of one verb.
#include <filesystem>
#include <string>

#include "watersky/base/result.hpp"

namespace watersky::detail {

/// Whether `out` may be made: it is not there, or an empty folder, or with `overwrite` an earlier
/// run of `verb`, which `mark`, a JSON file of ours, tells. Exists otherwise.
[[nodiscard]] Status check_run_folder(const std::filesystem::path& out, const std::string& mark,
                                      const std::string& verb, bool overwrite);

}  // namespace watersky::detail
