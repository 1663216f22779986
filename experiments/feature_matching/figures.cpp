// SPDX-License-Identifier: MIT
#include <algorithm>

#include "study.hpp"
#include "watersky/io/files.hpp"

namespace watersky::study {

namespace {

constexpr double kWidth = 420, kHeight = 200, kMargin = 48;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string rectangle(double x, double y, double width, double height, const char* fill) {
  return "<rect x=\"" + number(x) + "\" y=\"" + number(y) + "\" width=\"" + number(width) +
         "\" height=\"" + number(height) + "\" fill=\"" + fill + "\"/>";
}

std::string label(double x, double y, const std::string& words, const char* anchor = "middle") {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\">" +
         words + "</text>";
}

/// Axes around `inside`, which is drawn in kWidth x kHeight with y down.
std::string panel(double x, double y, const std::string& title, const std::string& unit,
                  double most_x, double most_y, const std::string& inside) {
  return "<g transform=\"translate(" + number(x) + " " + number(y) + ")\">" +
         label(kWidth / 2, -10, title) + inside + "<rect width=\"" + number(kWidth) +
         "\" height=\"" + number(kHeight) + "\" fill=\"none\" stroke=\"#555\"/>" +
         label(0, kHeight + 16, "0") + label(kWidth, kHeight + 16, number(most_x)) +
         label(kWidth / 2, kHeight + 16, unit) + label(-6, 10, number(most_y), "end") +
         label(-6, kHeight, "0", "end") + "</g>\n";
}

std::string svg(double width, double height, const std::string& inside) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width) + " " +
         number(height) + "\" font-family=\"sans-serif\" font-size=\"12\">" +
         rectangle(0, 0, width, height, "#fff") + "\n" + inside + "</svg>\n";
}

std::string histogram(double x, const std::string& title, const std::string& unit,
                      const std::vector<double>& values, std::optional<double> threshold) {
  constexpr std::size_t kBins = 60;
  const double most =
      values.empty() ? 1.0 : std::max(1e-9, *std::max_element(values.begin(), values.end()));
  std::vector<std::size_t> counts(kBins, 0);
  for (const double v : values)
    ++counts[std::min(kBins - 1, static_cast<std::size_t>(v / most * kBins))];
  const auto tallest = std::max<std::size_t>(1, *std::max_element(counts.begin(), counts.end()));
  std::string bars;
  for (std::size_t i = 0; i < kBins; ++i) {
    const double height = kHeight * static_cast<double>(counts[i]) / static_cast<double>(tallest);
    if (counts[i] > 0)
      bars += rectangle(kWidth * static_cast<double>(i) / kBins, kHeight - height,
                        kWidth / kBins - 0.5, height, "#3b6ea5");
  }
  if (threshold && *threshold <= most) {
    const std::string at = number(kWidth * *threshold / most);
    bars += "<line x1=\"" + at + "\" x2=\"" + at + "\" y1=\"0\" y2=\"" + number(kHeight) +
            "\" stroke=\"#c33\" stroke-dasharray=\"4 3\"/>";
  }
  return panel(x, 40, title, unit, most, static_cast<double>(tallest), bars);
}

}  // namespace

Status write_figure_4_6(const std::filesystem::path& file, const std::vector<double>& l2_norms,
                        const std::vector<double>& hellinger) {
  const double right = kMargin + kWidth + kMargin + 20;
  return write_file(
      file, svg(right + kWidth + kMargin, kHeight + 80,
                histogram(kMargin, "L2 norm of consecutive frames", "gray levels", l2_norms, {}) +
                    histogram(right, "Hellinger distance of their histograms",
                              "dashed: the thesis's 0.03", hellinger, 0.03)));
}

Status write_figure_4_7(const std::filesystem::path& file,
                        const std::vector<MethodCourse>& courses) {
  std::string inside;
  double y = 40;
  for (const MethodCourse& course : courses) {
    const std::size_t n = std::max<std::size_t>(1, course.matches.size());
    std::size_t most = 1;
    for (const std::size_t m : course.matches) most = std::max(most, m);
    const double step = kWidth / static_cast<double>(n);
    std::string bars, line;
    for (std::size_t i = 0; i < course.matches.size(); ++i) {
      const double x = step * static_cast<double>(i);
      if (course.registered[i]) bars += rectangle(x, 0, step, kHeight, "#d4d4d4");
      line += number(x + step / 2) + "," +
              number(kHeight *
                     (1.0 - static_cast<double>(course.matches[i]) / static_cast<double>(most))) +
              " ";
    }
    inside += panel(kMargin, y, course.name + ": matches; gray where registered", "frame",
                    static_cast<double>(course.matches.size()), static_cast<double>(most),
                    bars + "<polyline points=\"" + line +
                        "\" fill=\"none\" stroke=\"#1f4e79\" stroke-width=\"1\"/>");
    y += kHeight + 60;
  }
  return write_file(file, svg(kWidth + 2 * kMargin, y, inside));
}

}  // namespace watersky::study
