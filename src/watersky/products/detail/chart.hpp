// SPDX-License-Identifier: MIT
#pragma once
/// Quantities over time, as inline SVG.
#include <Eigen/Core>
#include <string>
#include <vector>

namespace watersky::detail {

/// One quantity. `look` is its colour's class in the style sheet: tone-a, tone-b or tone-c.
struct ChartSeries {
  std::string name;
  std::string look;
  std::vector<Eigen::Vector2d> line{};  ///< (time, value), in order of time
  std::vector<double> sigma{};          ///< of the line's points: a band; empty: none
  std::vector<Eigen::Vector2d> dots{};
};

struct Chart {
  std::string label;  ///< what it shows, for those who cannot see it
  std::string unit;   ///< of the values
  std::vector<ChartSeries> series;
};

/// The chart with a key below it where there are several quantities; of many points some are
/// left away. Empty when there is nothing to draw.
[[nodiscard]] std::string time_chart(const Chart& chart);

}  // namespace watersky::detail
