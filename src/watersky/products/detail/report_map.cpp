// SPDX-License-Identifier: MIT
#include "watersky/products/detail/report_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "watersky/io/pyramid.hpp"
#include "watersky/products/detail/graticule.hpp"
#include "watersky/products/detail/html.hpp"
#include "watersky/products/detail/picture.hpp"
#include "watersky/products/frame_figures.hpp"
#include "watersky/products/palette.hpp"

namespace watersky::detail {

namespace {

constexpr int kMaxPictureSide = 2000;
constexpr double kMapSide = 1000;  // units of the longer side
constexpr double kMargin = 44;     // for the graticule's labels, left and below
constexpr std::size_t kMaxLabelledIcebergs = 40;

/// Raster to drawing: units of the SVG's viewBox, y down.
class Sheet {
 public:
  explicit Sheet(const Products& products) : products_(products) {
    const cv::Mat& p = products.rasters.probability;
    units_per_cell_ = kMapSide / std::max(p.cols, p.rows);
    width_ = p.cols * units_per_cell_;
    height_ = p.rows * units_per_cell_;
  }
  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }
  [[nodiscard]] double metres_per_unit() const {
    return products_.ground_cell_m() / units_per_cell_;
  }

  [[nodiscard]] Eigen::Vector2d from_grid(const Eigen::Vector2d& grid) const {
    return (grid + Eigen::Vector2d(0.5, 0.5)) * units_per_cell_;
  }
  [[nodiscard]] Eigen::Vector2d from_easting_northing(const Eigen::Vector2d& en) const {
    return {(en.x() - products_.geotransform[0]) / metres_per_unit(),
            (products_.geotransform[3] - en.y()) / metres_per_unit()};
  }

 private:
  const Products& products_;
  double units_per_cell_ = 1, width_ = 0, height_ = 0;
};

std::string xy(const Eigen::Vector2d& p) { return number(p.x(), 1) + "," + number(p.y(), 1); }

/// An SVG path; points closer than a unit to the last are dropped.
std::string path_of(const std::vector<Eigen::Vector2d>& points, bool closed) {
  std::string d;
  Eigen::Vector2d last(1e300, 1e300);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((points[i] - last).norm() < 1.0 && i + 1 < points.size()) continue;
    d += d.empty() ? 'M' : 'L';
    d += xy(points[i]);
    last = points[i];
  }
  return closed && !d.empty() ? d + "Z" : d;
}

cv::Mat display_level(const cv::Mat& raster) {
  const std::vector<cv::Mat> levels = pyramid(raster, kMaxPictureSide);
  return levels.empty() ? raster : levels.back();
}

/// 0 for not seen, otherwise 1 to 255.
cv::Mat probability_index(const cv::Mat& probability) {
  cv::Mat index(probability.size(), CV_8U);
  for (int r = 0; r < index.rows; ++r) {
    const float* p = probability.ptr<float>(r);
    std::uint8_t* out = index.ptr<std::uint8_t>(r);
    for (int c = 0; c < index.cols; ++c)
      out[c] = p[c] == p[c]
                   ? static_cast<std::uint8_t>(1.5F + 254.0F * std::clamp(p[c], 0.0F, 1.0F))
                   : 0;
  }
  return index;
}

cv::Mat looks_index(const cv::Mat& looks, int most) {
  cv::Mat index(looks.size(), CV_8U);
  for (int r = 0; r < index.rows; ++r) {
    const std::uint16_t* n = looks.ptr<std::uint16_t>(r);
    std::uint8_t* out = index.ptr<std::uint8_t>(r);
    for (int c = 0; c < index.cols; ++c) {
      const int above_one = std::min<int>(n[c], most) - 1;
      const int step = most > 1 ? 254 * above_one / (most - 1) : 254;
      out[c] = static_cast<std::uint8_t>(n[c] == 0 ? 0 : 1 + step);
    }
  }
  return index;
}

std::string image(const Sheet& sheet, const std::string& uri, bool pixelated,
                  const std::string& more = {}) {
  return "<image x=\"0\" y=\"0\" width=\"" + number(sheet.width(), 2) + "\" height=\"" +
         number(sheet.height(), 2) + "\" preserveAspectRatio=\"none\"" +
         (pixelated ? " style=\"image-rendering:pixelated\"" : "") + more + " href=\"" + uri +
         "\"/>";
}

Result<std::string> pictures(const Products& products, const Sheet& sheet) {
  const cv::Mat probability = display_level(products.rasters.probability);
  // A map of few cells shows its cells, not a blur.
  const bool pixelated = std::max(probability.cols, probability.rows) < 700;
  WATERSKY_TRY(const std::string p, png_data_uri(probability_index(probability), kProbabilityRamp));
  std::string svg = "<g class=\"base l-probability\">" + image(sheet, p, pixelated) + "</g>";
  if (!products.rasters.looks.empty()) {
    const cv::Mat looks = display_level(products.rasters.looks);
    WATERSKY_TRY(const std::string uri,
                 png_data_uri(looks_index(looks, most_looks(products)), kCountRamp));
    svg += "<g class=\"base l-looks\">" + image(sheet, uri, pixelated) + "</g>";
  }
  if (!products.mosaic_bgra.empty()) {
    const cv::Mat mosaic = display_level(products.mosaic_bgra);
    cv::Mat seen(mosaic.size(), CV_8U);
    for (int r = 0; r < mosaic.rows; ++r)
      for (int c = 0; c < mosaic.cols; ++c)
        seen.at<std::uint8_t>(r, c) = mosaic.at<cv::Vec4b>(r, c)[3];
    WATERSKY_TRY(const std::string picture, jpeg_data_uri(mosaic));
    WATERSKY_TRY(const std::string mask, mask_data_uri(seen));
    svg += "<mask id=\"seen\" maskUnits=\"userSpaceOnUse\" x=\"0\" y=\"0\" width=\"" +
           number(sheet.width(), 2) + "\" height=\"" + number(sheet.height(), 2) + "\">" +
           image(sheet, mask, true) + "</mask><g class=\"base l-mosaic\">" +
           image(sheet, picture, pixelated, " mask=\"url(#seen)\"") + "</g>";
  }
  return svg;
}

std::string footprints(const Products& products, const Sheet& sheet) {
  std::string d;
  for (const UsedFrame& frame : products.used) {
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector2d& en : frame.footprint_easting_northing_m)
      points.push_back(sheet.from_easting_northing(en));
    d += path_of(points, true);
  }
  return "<g class=\"l-footprints\"><path d=\"" + d + "\"/></g>";
}

std::string track(const Products& products, const Sheet& sheet) {
  std::vector<Eigen::Vector2d> points;
  for (const TrackPoint& p : aircraft_track(products))
    points.push_back(sheet.from_easting_northing(p.easting_northing_m));
  if (points.empty()) return {};
  const std::string d = path_of(points, false);
  std::string svg =
      "<g class=\"l-track\"><path class=\"halo\" d=\"" + d + "\"/><path d=\"" + d + "\"/>";
  if (points.size() <= 200)
    for (const Eigen::Vector2d& p : points)
      svg += "<circle r=\"3.2\" cx=\"" + number(p.x(), 1) + "\" cy=\"" + number(p.y(), 1) + "\"/>";
  return svg + "<circle class=\"start\" r=\"7\" cx=\"" + number(points[0].x(), 1) + "\" cy=\"" +
         number(points[0].y(), 1) + "\"><title>first frame</title></circle></g>";
}

std::string icebergs(const Products& products, const Sheet& sheet) {
  std::string svg = "<g class=\"l-icebergs\">";
  std::size_t candidates = 0;
  for (const ice::IceObject& o : products.objects)
    candidates += o.kind == ice::ObjectKind::IcebergCandidate ? 1 : 0;
  for (const ice::IceObject& o : products.objects) {
    if (o.kind != ice::ObjectKind::IcebergCandidate) continue;
    const Eigen::Vector2d at = sheet.from_grid(o.centroid);
    const double radius = std::max(9.0, 0.5 * o.length_m / sheet.metres_per_unit() + 5);
    svg += "<circle cx=\"" + number(at.x(), 1) + "\" cy=\"" + number(at.y(), 1) + "\" r=\"" +
           number(radius, 1) + "\"><title>" + std::to_string(o.id) + ": " + escaped(o.size_class) +
           ", " + metres(o.length_m) + "</title></circle>";
    if (candidates <= kMaxLabelledIcebergs)
      svg += "<text x=\"" + number(at.x() + radius + 3, 1) + "\" y=\"" + number(at.y() + 5, 1) +
             "\">" + std::to_string(o.id) + "</text>";
  }
  return svg + "</g>";
}

std::string scale_bar(const Sheet& sheet) {
  const double most_m = 0.26 * sheet.width() * sheet.metres_per_unit();
  const double decade = std::pow(10.0, std::floor(std::log10(most_m)));
  const double length_m = decade * (most_m >= 5 * decade ? 5 : most_m >= 2 * decade ? 2 : 1);
  const double width = length_m / sheet.metres_per_unit();
  const std::string half = number(width / 2, 2);
  const std::string label = length_m >= 1000 ? rounded(length_m / 1000) + " km"
                                             : number(length_m, length_m < 1 ? 2 : 0) + " m";
  return "<g class=\"scale\" transform=\"translate(18," + number(sheet.height() - 22, 1) +
         ")\"><rect class=\"panel\" x=\"-9\" y=\"-28\" width=\"" + number(width + 18, 1) +
         "\" height=\"42\" rx=\"5\"/><rect class=\"dark\" x=\"0\" y=\"0\" width=\"" + half +
         "\" height=\"6\"/><rect class=\"light\" x=\"" + half + "\" y=\"0\" width=\"" + half +
         "\" height=\"6\"/><text x=\"" + half + "\" y=\"-8\" text-anchor=\"middle\">" + label +
         "</text></g>";
}

std::string north_arrow(const Products& products, const Sheet& sheet) {
  const Eigen::Vector2d middle = products.easting_northing_m(
      {0.5 * products.rasters.probability.cols, 0.5 * products.rasters.probability.rows});
  const auto place = products.projection.inverse(middle);
  if (!place) return {};
  const auto projected = products.projection.at(*place);
  if (!projected) return {};
  // Seen from grid north, which is up, true north lies the other way.
  const double turn_deg = -projected->convergence().degrees();
  return "<g class=\"north\" transform=\"translate(" + number(sheet.width() - 38, 1) +
         ",46)\"><circle class=\"panel\" r=\"30\"/><g transform=\"rotate(" + number(turn_deg, 2) +
         ")\"><path class=\"dark\" d=\"M0,-14L0,18L-8,24Z\"/><path class=\"light\" "
         "d=\"M0,-14L0,18L8,24Z\"/>"
         "<text x=\"0\" y=\"-16\" text-anchor=\"middle\">N</text></g><title>True north; grid north "
         "is up, " +
         number(std::abs(turn_deg), 1) + "° " + (turn_deg >= 0 ? "west" : "east") +
         " of it</title></g>";
}

}  // namespace

int most_looks(const Products& products) {
  int most = 1;
  const cv::Mat& looks = products.rasters.looks;
  for (int r = 0; r < looks.rows; ++r) {
    const std::uint16_t* n = looks.ptr<std::uint16_t>(r);
    for (int c = 0; c < looks.cols; ++c) most = std::max<int>(most, n[c]);
  }
  return most;
}

Result<std::string> map_svg(const Products& products) {
  const Sheet sheet(products);
  const auto to_sheet = [&](const Eigen::Vector2d& en) { return sheet.from_easting_northing(en); };
  const Graticule graticule = make_graticule(products, sheet.width(), sheet.height(), to_sheet);
  std::string lines;
  for (const auto& line : graticule.lines) lines += path_of(line, false);
  std::string labels;
  for (const GraticuleLabel& label : graticule.labels) {
    const bool left = label.side == GraticuleSide::Left;
    const std::string at = left ? "-10," + number(label.position, 1)
                                : number(label.position, 1) + "," + number(sheet.height() + 20, 1);
    labels += "<text text-anchor=\"middle\" transform=\"translate(" + at + ")" +
              (left ? " rotate(-90)" : "") + "\">" + label.text + "</text>";
  }
  WATERSKY_TRY(const std::string base, pictures(products, sheet));
  const std::string w = number(sheet.width(), 2);
  const std::string h = number(sheet.height(), 2);
  const std::string frame = "x=\"0\" y=\"0\" width=\"" + w + "\" height=\"" + h + "\"";
  return "<svg class=\"map\" role=\"img\" aria-label=\"Map of the ice\" "
         "xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" +
         number(-kMargin, 0) + " -4 " + number(sheet.width() + kMargin + 4, 2) + " " +
         number(sheet.height() + kMargin, 2) +
         "\"><defs><pattern id=\"unseen\" width=\"9\" height=\"9\" patternUnits=\"userSpaceOnUse\" "
         "patternTransform=\"rotate(45)\"><rect class=\"unseen-ground\" width=\"9\" height=\"9\"/>"
         "<rect class=\"unseen-line\" width=\"1.6\" height=\"9\"/></pattern><clipPath "
         "id=\"sheet\"><rect " +
         frame + "/></clipPath></defs><rect " + frame +
         " fill=\"url(#unseen)\"/><g clip-path=\"url(#sheet)\">" + base +
         "<g class=\"l-graticule\"><path d=\"" + lines + "\"/></g>" + footprints(products, sheet) +
         track(products, sheet) + icebergs(products, sheet) + scale_bar(sheet) +
         north_arrow(products, sheet) + "</g><rect class=\"neatline\" " + frame +
         "/><g class=\"l-graticule labels\">" + labels + "</g></svg>";
}

}  // namespace watersky::detail
