// SPDX-License-Identifier: MIT
#pragma once
/// QGIS styles, so that files look right when opened: `.qml` beside a raster, `layer_styles` in
/// a GeoPackage.
#include <string>
#include <vector>

#include "watersky/products/palette.hpp"

namespace watersky {

/// A single-band raster coloured along a ramp from `low` to `high`.
[[nodiscard]] std::string raster_qml(Ramp ramp, double low, double high, const std::string& unit);

/// A class of a raster of small whole numbers.
struct ClassStyle {
  int value = 0;
  Rgb color;
  std::string label;
};
[[nodiscard]] std::string classes_qml(const std::vector<ClassStyle>& classes);

enum class SymbolKind { Line, Outline, Fill };

/// A vector layer with one symbol: a line, an outline without fill, or a translucent fill.
struct VectorStyle {
  SymbolKind kind = SymbolKind::Outline;
  Rgb color;
  double width_mm = 0.3;
  double fill_opacity = 0.0;  ///< from 0 to 1, of Fill
};
[[nodiscard]] std::string vector_qml(const VectorStyle& style);
/// The same for other programs, SLD 1.0.
[[nodiscard]] std::string vector_sld(const std::string& layer, const VectorStyle& style);

}  // namespace watersky
