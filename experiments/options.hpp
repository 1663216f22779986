// SPDX-License-Identifier: MIT
#pragma once
/// What a person may tell a study on its command line.
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky::study {

/// `--seeds N`, or without a name a path that stands by itself.
struct Option {
  std::string_view name;   ///< "--seeds"; empty: by its place
  std::string_view value;  ///< as the usage spells it: "N"
  std::variant<int*, double*, std::string*, std::filesystem::path*> target;
  double least = 1.0;  ///< of a number
};

/// Fills the targets. Where the program has nothing to do, its exit status: 0 after --help, 2 where
/// the call is at fault; the usage has then been printed.
[[nodiscard]] std::optional<int> read_options(int argc, char** argv, const std::string& program,
                                              const std::vector<Option>& options);

/// A study's exit status; why it failed is printed.
[[nodiscard]] int exit_status(const std::string& program, const Status& done);

}  // namespace watersky::study
