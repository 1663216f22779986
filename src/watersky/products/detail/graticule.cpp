// SPDX-License-Identifier: MIT
#include "watersky/products/detail/graticule.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "watersky/products/detail/html.hpp"

namespace watersky::detail {

namespace {

struct Range {
  double low = 1e300;
  double high = -1e300;
  void include(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  [[nodiscard]] double size() const { return high - low; }
};

struct Step {
  double minutes = 0.0;
  int decimals = 0;  ///< of the minute, enough to write every line exactly
};

/// The smallest round step that gives at most six lines.
std::optional<Step> step_for(double range_deg) {
  const double range = range_deg * 60;
  for (int decimals = 5; decimals > 0; --decimals)
    for (const double digit : {1.0, 2.0, 5.0})
      if (const double minutes = digit * std::pow(10.0, -decimals); range <= 6 * minutes)
        return Step{minutes, decimals};
  for (const double minutes : {1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0})
    if (range <= 6 * minutes) return Step{minutes, 0};
  return std::nullopt;
}

constexpr int kSamples = 48;

}  // namespace

Graticule make_graticule(const Products& products, double width, double height,
                         const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& to_sheet) {
  Graticule graticule;
  const int columns = products.rasters.probability.cols;
  const int rows = products.rasters.probability.rows;
  const auto place_at = [&](double u, double v) {
    return products.projection.inverse(
        products.easting_northing_m({u * columns - 0.5, v * rows - 0.5}));
  };
  const auto middle = place_at(0.5, 0.5);
  if (!middle) return graticule;
  const double middle_lon_deg = middle->longitude.degrees();
  Range lat;
  Range lon;
  for (int i = 0; i <= 16; ++i) {
    for (const auto& [u, v] :
         {std::pair{i / 16.0, 0.0}, {i / 16.0, 1.0}, {0.0, i / 16.0}, {1.0, i / 16.0}}) {
      const auto place = place_at(u, v);
      if (!place) return graticule;
      lat.include(place->latitude.degrees());
      // Counted from the middle, so that the date line is no edge.
      lon.include(Angle::degrees(place->longitude.degrees() - middle_lon_deg).wrapped().degrees());
    }
  }
  if (lon.size() > 90 || lat.high > 89.9 || lat.low < -89.9) return graticule;
  const auto lat_step = step_for(lat.size());
  const auto lon_step = step_for(lon.size());
  if (!lat_step || !lon_step) return graticule;

  // Along one line, from one end of the other coordinate's range to the other.
  const auto draw = [&](bool parallel, double fixed_deg, const std::string& text) {
    const Range& along = parallel ? lon : lat;
    std::vector<Eigen::Vector2d> line;
    for (int i = 0; i <= kSamples; ++i) {
      const double t = along.low + along.size() * (1.1 * i / kSamples - 0.05);
      const double lat_deg = parallel ? fixed_deg : t;
      const double lon_deg = parallel ? middle_lon_deg + t : fixed_deg;
      const auto en =
          products.projection.forward(Angle::degrees(lat_deg), Angle::degrees(lon_deg).wrapped());
      if (en) line.push_back(to_sheet(*en));
    }
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Eigen::Vector2d& a = line[i - 1];
      const Eigen::Vector2d& b = line[i];
      const double side_a = parallel ? a.x() : a.y() - height;
      const double side_b = parallel ? b.x() : b.y() - height;
      if ((side_a < 0) == (side_b < 0)) continue;
      const Eigen::Vector2d crossing = a + (b - a) * (side_a / (side_a - side_b));
      const double position = parallel ? crossing.y() : crossing.x();
      const double side = parallel ? height : width;
      // Clear of the corners, where the other side's labels stand.
      if (position > 0.04 * side && position < 0.97 * side)
        graticule.labels.push_back(
            {parallel ? GraticuleSide::Left : GraticuleSide::Bottom, position, text});
    }
    graticule.lines.push_back(std::move(line));
  };
  const double lat_step_deg = lat_step->minutes / 60;
  for (double k = std::ceil(lat.low / lat_step_deg); k * lat_step_deg <= lat.high; ++k)
    draw(true, k * lat_step_deg, latitude(Angle::degrees(k * lat_step_deg), lat_step->decimals));
  const double lon_step_deg = lon_step->minutes / 60;
  for (double k = std::ceil((middle_lon_deg + lon.low) / lon_step_deg);
       k * lon_step_deg <= middle_lon_deg + lon.high; ++k)
    draw(false, k * lon_step_deg, longitude(Angle::degrees(k * lon_step_deg), lon_step->decimals));
  return graticule;
}

}  // namespace watersky::detail
