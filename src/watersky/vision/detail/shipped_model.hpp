// SPDX-License-Identifier: MIT
#pragma once
/// The text of the model file that the build puts into the program.
#include <string_view>

namespace watersky::detail {

[[nodiscard]] std::string_view shipped_model_text();

}  // namespace watersky::detail
