// SPDX-License-Identifier: MIT
#include "watersky/products/detail/alignment_sections.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "watersky/products/detail/chart.hpp"
#include "watersky/products/detail/html.hpp"

namespace watersky::detail {

namespace {

std::string cell(const std::string& text) { return "<td class=\"n\">" + text + "</td>"; }

std::string unit_text(const std::string& unit) {
  return unit == "1" ? "" : unit == "deg" ? "°" : "\u2009" + unit;
}

/// Seconds since the first of the flight's aligned frames.
double since_first_s(const AlignmentRun& run, Time time) {
  return run.alignment.frames.empty() ? 0.0
                                      : to_seconds(time - run.alignment.frames.front().captured);
}

}  // namespace

std::string with_sigma(double value, double sigma, const std::string& unit) {
  std::string text = to_its_sigma(value, sigma);
  if (sigma > 0) text += " ± " + to_its_sigma(sigma, sigma);
  return text + unit_text(unit);
}

std::string disagreement_table(const Alignment& alignment) {
  const auto row = [](const char* name, const TieStatistics& s) {
    if (s.ties == 0) return std::string();
    return "<tr><th>" + std::string(name) + "</th>" + cell(metres(s.median_m)) +
           cell(metres(s.p90_m)) + cell(number(s.median_px, 2) + " px") +
           cell(std::to_string(s.ties)) + "</tr>";
  };
  const std::string rows =
      row("As given", alignment.as_given) +
      (alignment.delay_estimated ? row("With a constant delay", alignment.constant_delay) : "") +
      row("After alignment", alignment.after);
  if (rows.empty())
    return "<p>No place was seen by several frames, so nothing can be compared.</p>";
  return "<p>How far apart frames put one and the same place of the sea, of places that took no "
         "part in the adjustment:</p><div class=\"scroll\"><table class=\"facts\"><thead><tr>"
         "<th></th><th class=\"n\">median</th><th class=\"n\">nine in ten below</th>"
         "<th class=\"n\">median, in the image</th><th "
         "class=\"n\">places</th></tr></thead><tbody>" +
         rows + "</tbody></table></div>";
}

std::string estimates_table(const Alignment& alignment) {
  if (alignment.estimates.empty()) return {};
  std::string html =
      "<div class=\"scroll\"><table><thead><tr><th>quantity</th><th class=\"n\">given</th>"
      "<th class=\"n\">found</th><th class=\"n\">one sigma before</th>"
      "<th class=\"n\">and after</th><th></th></tr></thead><tbody>";
  for (const Estimate& e : alignment.estimates) {
    const std::string unit = unit_text(e.unit);
    const double fine = e.observed ? e.sigma : e.sigma_before;
    html += "<tr><th>" + escaped(spoken_name(e)) + "</th>" +
            cell(to_its_sigma(e.given, fine) + unit) +
            cell(e.observed ? to_its_sigma(e.value, fine) + unit : "–") +
            cell(to_its_sigma(e.sigma_before, e.sigma_before) + unit) +
            cell(e.observed ? to_its_sigma(e.sigma, e.sigma) + unit : "–") + "<td>" +
            (e.observed ? "observed" : "not observed, stays as given") + "</td></tr>";
  }
  return html + "</tbody></table></div>";
}

std::string delay_chart(const AlignmentRun& run) {
  const Alignment& a = run.alignment;
  if (!a.delay_estimated || a.delay.empty()) return {};
  ChartSeries mean{"its slow course, with one sigma", "tone-a"};
  ChartSeries frames{"each frame's own", "tone-b"};
  const double mean_s = delay_figures(a).mean_s;
  for (const DelaySample& sample : a.delay) {
    // Samples are told at arrival; frames stand at capture.
    mean.line.emplace_back(since_first_s(run, sample.received) - mean_s, 1e3 * sample.delay_s);
    mean.sigma.push_back(1e3 * sample.sigma_s);
  }
  // A single sample holds for the whole flight.
  if (mean.line.size() == 1) {
    mean.line.front().x() = 0.0;
    mean.line.emplace_back(since_first_s(run, a.frames.back().captured), mean.line.front().y());
    mean.sigma.push_back(mean.sigma.front());
  }
  for (const AlignedFrame& f : a.frames) {
    const ImageFrame& frame = run.given.frames[f.index];
    if (frame.captured_at || frame.own_pose) continue;
    frames.dots.emplace_back(since_first_s(run, f.captured), 1e3 * f.delay_s);
  }
  Chart chart{"Delay of the images over time", "ms", {}};
  if (!frames.dots.empty()) chart.series.push_back(std::move(frames));
  chart.series.push_back(std::move(mean));
  return time_chart(chart);
}

std::string corrections_charts(const AlignmentRun& run) {
  const auto corrections = pose_corrections(run);
  const bool any = std::any_of(corrections.begin(), corrections.end(), [](const auto& c) {
    return c.position_m.norm() > 1e-9 || c.turn_rad.norm() > 1e-9;
  });
  if (!any) return {};
  static constexpr std::array<const char*, 3> kLooks{"tone-a", "tone-b", "tone-c"};
  static constexpr std::array<const char*, 3> kAlong{"north", "east", "down"};
  static constexpr std::array<const char*, 3> kAbout{"about north", "about east",
                                                     "about down (heading)"};
  Chart position{"Correction of the position over time", "m", {}};
  Chart attitude{"Correction of the attitude over time", "°", {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ChartSeries along{kAlong[axis], kLooks[axis]}, about{kAbout[axis], kLooks[axis]};
    for (const PoseCorrection& c : corrections) {
      const double t_s = since_first_s(run, run.alignment.frames[c.frame].captured);
      const auto k = static_cast<Eigen::Index>(axis);
      along.line.emplace_back(t_s, c.position_m[k]);
      about.line.emplace_back(t_s, c.turn_rad[k] * 180 / std::numbers::pi);
    }
    position.series.push_back(std::move(along));
    attitude.series.push_back(std::move(about));
  }
  return "<h3>Position</h3>" + time_chart(position) + "<h3>" +
         (run.given.gimbal_reference == GimbalReference::NorthEastDown ? "Attitude of the gimbal"
                                                                       : "Attitude") +
         "</h3>" + time_chart(attitude);
}

std::string alignment_section(const AlignmentRun& run) {
  const Alignment& a = run.alignment;
  std::string html =
      "<section><h2>Alignment</h2><p>" + escaped(summary(run)) + "</p>" + disagreement_table(a);
  if (a.method == AlignMethod::AsGiven) return html + "</section>";
  if (const std::string chart = delay_chart(run); !chart.empty())
    html += "<h3>Delay of the images</h3>" + chart;
  if (const std::string table = estimates_table(a); !table.empty())
    html += "<details><summary>Mount, focal length and the like</summary>" + table + "</details>";
  return html + "<p>It took " + number(run.wall_s, 1) +
         " s. watersky align writes all of it, and pictures before and after.</p></section>";
}

}  // namespace watersky::detail
