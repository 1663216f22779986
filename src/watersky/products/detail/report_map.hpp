// SPDX-License-Identifier: MIT
#pragma once
/// The map of a report, as inline SVG.
#include <string>

#include "watersky/products/products.hpp"

namespace watersky::detail {

/// The map's layers: classes l-probability, l-mosaic, l-looks (one is shown at a time),
/// l-footprints, l-track, l-icebergs, l-graticule.
[[nodiscard]] Result<std::string> map_svg(const Products& products);

/// The largest number of looks at any cell, at least 1: the end of the looks ramp.
[[nodiscard]] int most_looks(const Products& products);

}  // namespace watersky::detail
