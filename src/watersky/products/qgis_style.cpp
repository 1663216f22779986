// SPDX-License-Identifier: MIT
#include "watersky/products/qgis_style.hpp"

#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace watersky {

namespace {

constexpr const char* kQmlHead =
    "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
    "<qgis version=\"3.22\" styleCategories=\"Symbology\">\n";

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", x);
  return text;
}

/// QGIS's "red,green,blue,alpha".
std::string rgba(const Rgb& c, double opacity = 1.0) {
  return std::to_string(c.red) + "," + std::to_string(c.green) + "," + std::to_string(c.blue) +
         "," + std::to_string(std::lround(255 * opacity));
}

/// QGIS before 3.20 reads <prop>, later ones the map of options.
std::string properties(const std::vector<std::pair<std::string, std::string>>& values) {
  std::string xml = "     <Option type=\"Map\">\n";
  for (const auto& [key, value] : values)
    xml += "      <Option type=\"QString\" name=\"" + key + "\" value=\"" + value + "\"/>\n";
  xml += "     </Option>\n";
  for (const auto& [key, value] : values)
    xml += "     <prop k=\"" + key + "\" v=\"" + value + "\"/>\n";
  return xml;
}

}  // namespace

std::string raster_qml(Ramp ramp, double low, double high, const std::string& unit) {
  std::string items;
  for (const RampStop& stop : ramp) {
    const std::string value = number(low + stop.at * (high - low));
    items += "      <item alpha=\"255\" color=\"" + hex(stop.color) + "\" value=\"" + value +
             "\" label=\"" + value + (unit.empty() ? "" : " " + unit) + "\"/>\n";
  }
  return std::string(kQmlHead) +
         " <pipe>\n"
         "  <rasterrenderer type=\"singlebandpseudocolor\" band=\"1\" opacity=\"1\" "
         "alphaBand=\"-1\" "
         "classificationMin=\"" +
         number(low) + "\" classificationMax=\"" + number(high) +
         "\" nodataColor=\"\">\n"
         "   <rasterTransparency/>\n"
         "   <minMaxOrigin><limits>None</limits><extent>WholeRaster</extent>"
         "<statAccuracy>Estimated</statAccuracy></minMaxOrigin>\n"
         "   <rastershader>\n"
         "    <colorrampshader colorRampType=\"INTERPOLATED\" classificationMode=\"1\" clip=\"0\" "
         "minimumValue=\"" +
         number(low) + "\" maximumValue=\"" + number(high) + "\">\n" + items +
         "    </colorrampshader>\n"
         "   </rastershader>\n"
         "  </rasterrenderer>\n"
         "  <brightnesscontrast brightness=\"0\" contrast=\"0\" gamma=\"1\"/>\n"
         "  <huesaturation saturation=\"0\" colorizeOn=\"0\" grayscaleMode=\"0\"/>\n"
         "  <rasterresampler maxOversampling=\"2\"/>\n"
         " </pipe>\n"
         " <blendMode>0</blendMode>\n"
         "</qgis>\n";
}

std::string classes_qml(const std::vector<ClassStyle>& classes) {
  std::string items;
  for (const ClassStyle& c : classes)
    items += "    <paletteEntry value=\"" + std::to_string(c.value) + "\" color=\"" + hex(c.color) +
             "\" alpha=\"255\" label=\"" + c.label + "\"/>\n";
  return std::string(kQmlHead) +
         " <pipe>\n"
         "  <rasterrenderer type=\"paletted\" band=\"1\" opacity=\"1\" alphaBand=\"-1\" "
         "nodataColor=\"\">\n"
         "   <rasterTransparency/>\n"
         "   <colorPalette>\n" +
         items +
         "   </colorPalette>\n"
         "  </rasterrenderer>\n"
         " </pipe>\n"
         "</qgis>\n";
}

std::string vector_qml(const VectorStyle& style) {
  const bool line = style.kind == SymbolKind::Line;
  const bool fill = style.kind == SymbolKind::Fill;
  const std::string width = number(style.width_mm);
  const std::string layer =
      line ? "    <layer class=\"SimpleLine\" enabled=\"1\" locked=\"0\" pass=\"0\">\n" +
                 properties({{"line_color", rgba(style.color)},
                             {"line_width", width},
                             {"line_width_unit", "MM"},
                             {"line_style", "solid"},
                             {"capstyle", "round"},
                             {"joinstyle", "round"}})
           : "    <layer class=\"SimpleFill\" enabled=\"1\" locked=\"0\" pass=\"0\">\n" +
                 properties({{"color", rgba(style.color, fill ? style.fill_opacity : 0.0)},
                             {"style", fill ? "solid" : "no"},
                             {"outline_color", rgba(style.color)},
                             {"outline_style", "solid"},
                             {"outline_width", width},
                             {"outline_width_unit", "MM"},
                             {"joinstyle", "round"}});
  return std::string(kQmlHead) +
         " <renderer-v2 type=\"singleSymbol\" symbollevels=\"0\" forceraster=\"0\" "
         "enableorderby=\"0\">\n"
         "  <symbols>\n"
         "   <symbol type=\"" +
         (line ? "line" : "fill") +
         "\" name=\"0\" alpha=\"1\" clip_to_extent=\"1\" force_rhr=\"0\">\n" + layer +
         "    </layer>\n"
         "   </symbol>\n"
         "  </symbols>\n"
         "  <rotation/>\n"
         "  <sizescale/>\n"
         " </renderer-v2>\n"
         " <blendMode>0</blendMode>\n"
         " <layerGeometryType>" +
         (line ? "1" : "2") +
         "</layerGeometryType>\n"
         "</qgis>\n";
}

std::string vector_sld(const std::string& layer, const VectorStyle& style) {
  const auto parameter = [](const std::string& name, const std::string& value) {
    return "<CssParameter name=\"" + name + "\">" + value + "</CssParameter>";
  };
  // SLD counts in pixels of 0.28 mm.
  const std::string stroke = "<Stroke>" + parameter("stroke", hex(style.color)) +
                             parameter("stroke-width", number(style.width_mm / 0.28)) + "</Stroke>";
  const std::string fill = style.kind == SymbolKind::Fill
                               ? "<Fill>" + parameter("fill", hex(style.color)) +
                                     parameter("fill-opacity", number(style.fill_opacity)) +
                                     "</Fill>"
                               : "";
  const std::string symbol = style.kind == SymbolKind::Line
                                 ? "<LineSymbolizer>" + stroke + "</LineSymbolizer>"
                                 : "<PolygonSymbolizer>" + fill + stroke + "</PolygonSymbolizer>";
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<StyledLayerDescriptor xmlns=\"http://www.opengis.net/sld\" "
         "version=\"1.0.0\"><NamedLayer>"
         "<Name>" +
         layer + "</Name><UserStyle><Name>" + layer + "</Name><FeatureTypeStyle><Rule>" + symbol +
         "</Rule></FeatureTypeStyle></UserStyle></NamedLayer></StyledLayerDescriptor>\n";
}

}  // namespace watersky
