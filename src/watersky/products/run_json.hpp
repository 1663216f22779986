// SPDX-License-Identifier: MIT
#pragma once
/// run.json: how the products were made, their figures, and every frame left out and why. What
/// is not known is null.
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "watersky/products/products.hpp"

namespace watersky {

[[nodiscard]] nlohmann::json run_json(const Products& products);

/// The same as text, UTF-8 whatever the file names hold; `--json` prints it too.
[[nodiscard]] std::string run_json_text(const Products& products);

}  // namespace watersky
