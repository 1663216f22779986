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

/// An error about a file in the folder in the making, in the words of the user, who asked for
/// `out`.
[[nodiscard]] Error named_as_asked(Error error, const std::filesystem::path& in_the_making,
                                   const std::filesystem::path& out);

}  // namespace watersky::detail
