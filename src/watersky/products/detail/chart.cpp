// SPDX-License-Identifier: MIT
#include "watersky/products/detail/chart.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "watersky/products/detail/html.hpp"

namespace watersky::detail {

namespace {

constexpr double kWidth = 640, kHeight = 190;
constexpr std::size_t kMostPoints = 800;

/// Values between which something is drawn.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  /// A range of no width gets one.
  void open() {
    if (high > low) return;
    const double half = low == 0 ? 1.0 : 0.1 * std::abs(low);
    low -= half;
    high += half;
  }
};

/// 1, 2 or 5 times a power of ten: about `count` of them fill the range.
double round_step(const Range& range, int count) {
  const double raw = (range.high - range.low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double times : {1.0, 2.0, 5.0})
    if (times * power >= raw * 0.999) return times * power;
  return 10 * power;
}

std::string tick_text(double value, double step) {
  if (std::abs(value) < 1e-9 * step) value = 0;
  return number(value, std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6));
}

/// Every so many-th of the points, the last one too.
std::vector<std::size_t> thinned(std::size_t count) {
  std::vector<std::size_t> kept;
  const std::size_t every = count / kMostPoints + 1;
  for (std::size_t i = 0; i < count; i += every) kept.push_back(i);
  if (!kept.empty() && kept.back() + 1 != count) kept.push_back(count - 1);
  return kept;
}

/// Where nothing was measured for so long no curve is drawn. With a sigma it is one that goes on.
double gap_of(const ChartSeries& series) {
  std::vector<double> steps;
  for (const std::size_t i : thinned(series.line.size()))
    if (i > 0) steps.push_back(series.line[i].x() - series.line[i - 1].x());
  if (steps.empty() || !series.sigma.empty()) return std::numeric_limits<double>::infinity();
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const std::size_t every = series.line.size() / kMostPoints + 1;
  return 6 * *middle * static_cast<double>(every);
}

}  // namespace

std::string time_chart(const Chart& chart) {
  Range t, v;
  for (const ChartSeries& s : chart.series) {
    for (std::size_t i = 0; i < s.line.size(); ++i) {
      t.add(s.line[i].x());
      const double sigma = i < s.sigma.size() ? s.sigma[i] : 0.0;
      v.add(s.line[i].y() - sigma);
      v.add(s.line[i].y() + sigma);
    }
    for (const Eigen::Vector2d& p : s.dots) {
      t.add(p.x());
      v.add(p.y());
    }
  }
  if (!(t.high >= t.low) || !(v.high >= v.low)) return {};
  t.open();
  v.open();
  const double step_v = round_step(v, 5), step_t = round_step(t, 8);
  v.low = std::floor(v.low / step_v + 1e-9) * step_v;
  v.high = std::ceil(v.high / step_v - 1e-9) * step_v;
  const auto x = [&](double time) { return number(kWidth * (time - t.low) / (t.high - t.low), 1); };
  const auto y = [&](double value) {
    return number(kHeight * (1 - (value - v.low) / (v.high - v.low)), 1);
  };

  std::string svg = "<svg class=\"chart\" role=\"img\" aria-label=\"" + escaped(chart.label) +
                    "\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-58 -24 " +
                    number(kWidth + 72, 0) + " " + number(kHeight + 68, 0) + "\">";
  svg += "<text x=\"-52\" y=\"-12\">" + escaped(chart.unit) + "</text>";
  const int rows = static_cast<int>(std::lround((v.high - v.low) / step_v));
  for (int i = 0; i <= rows; ++i) {
    const double value = v.low + i * step_v;
    svg += "<path class=\"grid\" d=\"M0," + y(value) + "H" + number(kWidth, 0) +
           "\"/><text x=\"-6\" y=\"" + y(value) + "\" dy=\"4\" text-anchor=\"end\">" +
           tick_text(value, step_v) + "</text>";
  }
  for (double time = std::ceil(t.low / step_t - 1e-9) * step_t; time <= t.high + 1e-9 * step_t;
       time += step_t)
    svg += "<text x=\"" + x(time) + "\" y=\"" + number(kHeight + 18, 0) +
           "\" text-anchor=\"middle\">" + tick_text(time, step_t) + "</text>";
  svg += "<text x=\"" + number(kWidth / 2, 0) + "\" y=\"" + number(kHeight + 38, 0) +
         "\" text-anchor=\"middle\">time since the first frame, s</text>";

  std::string keys;
  for (const ChartSeries& s : chart.series) {
    std::string band, back, line, dots;
    const double gap = gap_of(s);
    double before = std::numeric_limits<double>::infinity();
    for (const std::size_t i : thinned(s.line.size())) {
      const Eigen::Vector2d& p = s.line[i];
      line += (line.empty() || p.x() - before > gap ? "M" : "L") + x(p.x()) + "," + y(p.y());
      before = p.x();
      if (i >= s.sigma.size()) continue;
      band += (band.empty() ? "M" : "L") + x(p.x()) + "," + y(p.y() + s.sigma[i]);
      back.insert(0, "L" + x(p.x()) + "," + y(p.y() - s.sigma[i]));
    }
    for (const std::size_t i : thinned(s.dots.size()))
      dots.append("<circle cx=\"")
          .append(x(s.dots[i].x()))
          .append("\" cy=\"")
          .append(y(s.dots[i].y()))
          .append("\" r=\"1.9\"/>");
    svg += "<g class=\"" + s.look + "\">";
    if (!band.empty()) svg += "<path class=\"band\" d=\"" + band + back + "Z\"/>";
    svg += dots;
    if (!line.empty()) svg += "<path class=\"curve\" d=\"" + line + "\"/>";
    svg += "</g>";
    keys += "<span class=\"key\"><i class=\"swatch line " + s.look + "\"></i> " + escaped(s.name) +
            "</span>";
  }
  return "<figure>" + svg + "</svg></figure>" +
         (chart.series.size() > 1 ? "<p class=\"keys\">" + keys + "</p>" : std::string());
}

}  // namespace watersky::detail
