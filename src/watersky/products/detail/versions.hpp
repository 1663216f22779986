// SPDX-License-Identifier: MIT
#pragma once
/// What made a product.
#include <string>

namespace watersky::detail {

struct Versions {
  std::string watersky, opencv, gdal, proj;
};
[[nodiscard]] Versions versions();

}  // namespace watersky::detail
