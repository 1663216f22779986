// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "watersky/io/files.hpp"
#include "watersky/products/detail/html.hpp"
#include "watersky/products/detail/picture.hpp"
#include "watersky/products/detail/report_style.hpp"
#include "watersky/products/detail/versions.hpp"
#include "watersky/products/segmentation_pictures.hpp"
#include "watersky/products/segmentation_products.hpp"

namespace watersky {

namespace {

using namespace detail;

std::string card(const std::string& name, const std::string& value, const std::string& more) {
  return "<div class=\"card\"><dt>" + name + "</dt><dd>" + value + "<small>" + more +
         "</small></dd></div>";
}

std::string points(double fraction) {
  return std::isfinite(fraction) ? number(100 * fraction, 1) + " points" : "–";
}

std::string key(const Rgb& color, const std::string& text, const char* kind = "") {
  return "<span class=\"key\"><span class=\"swatch" + std::string(kind) +
         "\" style=\"background:" + hex(color) + "\"></span>" + text + "</span>";
}

std::string stripes_key(const Rgb& color, const std::string& text) {
  return "<span class=\"key\"><span class=\"swatch\" style=\"background:repeating-linear-gradient("
         "135deg," +
         hex(color) + " 0 2px,#8888 2px 6px)\"></span>" + text + "</span>";
}

std::string cards(const SegmentationRun& run, const MeanSegmentationScore& mean) {
  double concentration = 0.0, unknown = 0.0;
  std::size_t known = 0;
  for (const SegmentedImage& image : run.images) {
    unknown += image.unknown_share / static_cast<double>(run.images.size());
    if (std::isnan(image.concentration)) continue;
    concentration += image.concentration;
    ++known;
  }
  std::string html =
      "<dl class=\"cards\">" +
      card("Images", std::to_string(run.images.size()),
           run.left_out.empty() ? "none left out"
                                : std::to_string(run.left_out.size()) + " left out, see below") +
      card("Ice concentration",
           known == 0 ? "–" : percent(concentration / static_cast<double>(known)),
           "mean over the images; of what is known") +
      card("Not known", percent(unknown), "of the pixels: the method gives no answer");
  if (mean.images > 0)
    html +=
        card("Accuracy", percent(mean.accuracy), "worst image " + percent(mean.worst_accuracy)) +
        card("IoU of ice", number(mean.iou, 3), "worst image " + number(mean.worst_iou, 3)) +
        card("Concentration error", points(mean.concentration_error), "mean over the images") +
        card("Brier score", number(mean.brier, 3), "0 is perfect; 0.25 is always saying one half") +
        card("Calibration error", number(mean.pooled_calibration_error, 3),
             "expected, of all pixels; mean over the images " + number(mean.calibration_error, 3));
  return html + "</dl>";
}

/// Said against seen; the discs' areas are shares of the pixels.
std::string reliability_section(const MeanSegmentationScore& mean) {
  if (mean.images == 0) return {};
  constexpr double kSide = 320, kLeft = 62, kTop = 14;
  const auto x = [&](double p) { return number(kLeft + kSide * p, 1); };
  const auto y = [&](double p) { return number(kTop + kSide * (1 - p), 1); };
  std::string svg =
      "<svg class=\"chart\" viewBox=\"0 0 400 390\" style=\"max-width:440px\" role=\"img\" "
      "aria-label=\"Reliability diagram\">";
  for (int i = 0; i <= 5; ++i) {
    const double p = i / 5.0;
    const std::string label = number(p, 1);
    const std::string across = x(p), up = y(p);
    svg += "<path class=\"grid\" d=\"M" + x(0) + " " + up + "H" + x(1);
    svg += "M" + across + " " + y(0) + "V" + y(1) + "\"/>";
    svg += "<text x=\"" + number(kLeft - 8, 0) + "\" y=\"" + number(kTop + kSide * (1 - p) + 4, 1) +
           "\" text-anchor=\"end\">" + label + "</text>";
    svg += "<text x=\"" + across + "\" y=\"" + number(kTop + kSide + 18, 0) +
           "\" text-anchor=\"middle\">" + label + "</text>";
  }
  svg += "<path d=\"M" + x(0) + " " + y(0) + "L" + x(1) + " " + y(1) +
         "\" stroke=\"var(--soft)\" stroke-dasharray=\"5 4\" fill=\"none\"/>";
  std::string line, discs, rows;
  const auto total = static_cast<double>(mean.reliability.pixels());
  for (const Reliability::Bin& bin : mean.reliability.bins()) {
    if (bin.pixels == 0) continue;
    const double share = static_cast<double>(bin.pixels) / total;
    line += (line.empty() ? "M" : "L") + x(bin.mean_p()) + " " + y(bin.ice_share());
    discs += "<circle class=\"by-count\" fill-opacity=\".55\" cx=\"" + x(bin.mean_p()) +
             "\" cy=\"" + y(bin.ice_share()) + "\" r=\"" +
             number(std::max(2.5, 26 * std::sqrt(share)), 1) + "\"/>";
    rows += "<tr><td class=\"n\">" + number(bin.mean_p(), 3) + "</td><td class=\"n\">" +
            number(bin.ice_share(), 3) + "</td><td class=\"n\">" + percent(share) + "</td></tr>";
  }
  svg += "<path d=\"" + line + "\" stroke=\"var(--count)\" stroke-width=\"2\" fill=\"none\"/>" +
         discs + "<text x=\"" + x(0.5) + "\" y=\"" + number(kTop + kSide + 40, 0) +
         "\" text-anchor=\"middle\">P(ice) that was said</text><text transform=\"translate(16 " +
         number(kTop + kSide / 2, 0) +
         ")rotate(-90)\" text-anchor=\"middle\">share that was ice</text></svg>";
  return "<section><h2>Do the probabilities mean what they say?</h2><figure>" + svg +
         "</figure><div class=\"keys\"><span class=\"key\">On the dashed line they do. Discs are "
         "as large as the share of pixels of which so much was said.</span></div>"
         "<details><summary>Table</summary><div class=\"scroll\"><table><thead><tr>"
         "<th class=\"n\">mean P(ice) said</th><th class=\"n\">share that was ice</th>"
         "<th class=\"n\">of the pixels</th></tr></thead><tbody>" +
         rows + "</tbody></table></div></details><p>Of the pixels classed ice " +
         percent(mean.p_ice_if_ice) + " were ice (P1 of (2.31)); of those classed water " +
         percent(mean.p_ice_if_water) + " (P2).</p></section>";
}

std::string figure(const std::string& jpeg, const std::string& file, const std::string& alt) {
  const std::string source = jpeg.empty() ? escaped(file) : jpeg_data_uri(jpeg);
  return "<img loading=\"lazy\" src=\"" + source + "\" alt=\"" + escaped(alt) + "\">";
}

std::string image_figure(const SegmentedImage& image) {
  std::string text = "<b>" + escaped(image.stem) + "</b>";
  if (std::isnan(image.concentration)) {
    text += "<span>nothing known</span>";
  } else {
    text += "<span>" + percent(image.concentration) + " ice";
    if (image.unknown_share > 0) text += ", " + percent(image.unknown_share) + " not known";
    text += "</span>";
  }
  if (image.score)
    text += "<span>accuracy " + percent(image.score->accuracy) + ", IoU " +
            number(image.score->iou, 3) + ", truth " + percent(image.score->true_concentration) +
            "</span>";
  if (!image.truth_fault.empty()) text += "<span>" + escaped(image.truth_fault) + "</span>";
  for (const std::string& note : image.findings.notes)
    text += "<span class=\"note\">" + escaped(note) + "</span>";
  return "<figure class=\"shot\"><div>" +
         figure(image.overlay_jpeg, image.stem + "_overlay.jpg", "overlay of " + image.file) +
         (image.score
              ? figure(image.errors_jpeg, image.stem + "_errors.jpg", "errors in " + image.file)
              : "") +
         "</div><figcaption>" + text + "</figcaption></figure>";
}

std::string images_section(const SegmentationRun& run, bool scored) {
  std::string html = "<section><h2>Images</h2><div class=\"keys\">" +
                     key(kIceOutline, "edge of the ice, P(ice) = 1/2", " line") +
                     key(kWaterTint, "water, deeper where surer") +
                     stripes_key(kUnsureStripes, "unsure, P(ice) 0.4 to 0.6") +
                     stripes_key(kUnknownStripes, "not known");
  if (scored) html += key(kFalseIce, "water called ice") + key(kMissedIce, "ice called water");
  html += "</div><div class=\"shots" + std::string(scored ? " wide" : "") + "\">";
  for (const SegmentedImage& image : run.images) html += image_figure(image);
  return html + "</div></section>";
}

std::string table_section(const SegmentationRun& run, bool scored) {
  std::string html =
      "<section><h2>Figures</h2><div class=\"scroll\"><table><thead><tr><th>image</th>"
      "<th class=\"n\">ice</th><th class=\"n\">mean P(ice)</th><th class=\"n\">not known</th>"
      "<th>ice is</th>";
  if (scored)
    html +=
        "<th class=\"n\">accuracy</th><th class=\"n\">IoU</th><th class=\"n\">true ice</th>"
        "<th class=\"n\">error, points</th><th class=\"n\">Brier</th><th class=\"n\">ECE</th>";
  html += "</tr></thead><tbody>";
  const auto cell = [](const std::string& text) { return "<td class=\"n\">" + text + "</td>"; };
  for (const SegmentedImage& image : run.images) {
    const auto& polarity = image.findings.polarity;
    html += "<tr><td>" + escaped(image.stem) + "</td>" + cell(percent(image.concentration)) +
            cell(number(image.mean_p_ice, 3)) + cell(percent(image.unknown_share)) + "<td>" +
            (polarity ? std::string(name_of(polarity->polarity)) +
                            (polarity->confidence < kSureOfPolarity ? ", unsure" : "")
                      : "") +
            "</td>";
    if (scored && image.score) {
      const SegmentationScore& s = *image.score;
      html += cell(percent(s.accuracy)) + cell(number(s.iou, 3)) +
              cell(percent(s.true_concentration)) + cell(number(100 * s.concentration_error(), 1)) +
              cell(number(s.brier, 3)) + cell(number(s.calibration_error(), 3));
    } else if (scored) {
      html += "<td colspan=\"6\">" + escaped(image.truth_fault) + "</td>";
    }
    html += "</tr>";
  }
  return html + "</tbody></table></div></section>";
}

std::string left_out_section(const SegmentationRun& run) {
  if (run.left_out.empty()) return {};
  std::string html = "<section><h2>Left out</h2><div class=\"scroll\"><table><tbody>";
  for (const LeftOut& l : run.left_out)
    html += "<tr><th>" + escaped(l.file) + "</th><td>" + escaped(l.reason) + "</td></tr>";
  return html + "</tbody></table></div></section>";
}

std::string making_section(const SegmentationRun& run) {
  const auto row = [](const std::string& name, const std::string& value) {
    return value.empty() ? "" : "<tr><th>" + name + "</th><td>" + escaped(value) + "</td></tr>";
  };
  std::string html =
      "<section><h2>How it was made</h2><div class=\"scroll\"><table class=\"facts\"><tbody>" +
      row("Method", std::string(name_of(run.method))) + row("Model", run.model_name()) +
      row("Ice is", std::string(name_of(run.ice))) +
      row("Images are",
          run.sequence ? "one flight, looked at as a whole first" : "each judged by itself") +
      row("Mask", run.mask) + row("Truth", run.truth);
  html += row("Melt ponds count as", run.pond_is_ice ? "ice" : "water");
  if (run.flight)
    for (const std::string& note : run.flight->notes) html += row("Note", note);
  const Versions versions = detail::versions();
  html += row("Programs", "Watersky " + versions.watersky + ", OpenCV " + versions.opencv) +
          "</tbody></table></div><details><summary>Parameters</summary><div class=\"scroll\">"
          "<table class=\"facts\"><tbody>";
  SegmentationParameters::describe(run.parameters, [&](const auto& value, const auto& info) {
    html += "<tr><th><code>" + std::string(info.name) + "</code></th><td class=\"n\">" +
            rounded(static_cast<double>(value)) +
            (info.unit == "1" ? "" : " " + std::string(info.unit)) + "</td><td>" +
            escaped(info.help) + "</td></tr>";
  });
  return html + "</tbody></table></div></details></section>";
}

constexpr const char* kCss =
    ".shots{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:1.1rem;"
    "margin-top:.9rem}"
    ".shots.wide{grid-template-columns:repeat(auto-fill,minmax(460px,1fr))}"
    ".shot>div{display:flex;gap:4px}.shot img{flex:1 1 0;min-width:0;width:100%;height:auto;"
    "border-radius:4px;display:block}"
    ".shot figcaption{display:block;margin:.35rem 0 0}.shot figcaption>*{display:block}"
    ".shot .note{font-size:.78rem}"
    "@media(max-width:640px){.shots,.shots.wide{grid-template-columns:1fr}}"
    "@media print{.shot{break-inside:avoid}}";

}  // namespace

std::string segmentation_report_html(const SegmentationRun& run) {
  const MeanSegmentationScore mean = mean_score(run.scores());
  const bool scored = mean.images > 0;
  const std::string title =
      run.images.size() == 1 ? run.images[0].stem : std::to_string(run.images.size()) + " images";
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
         "<meta name=\"color-scheme\" content=\"light dark\"><title>Ice in " +
         escaped(title) + "</title><style>" + report_css() + kCss +
         "</style></head><body><header><div><p class=\"kicker\">Watersky · ice in images</p><h1>" +
         escaped(title) + "</h1><p>method " + std::string(name_of(run.method)) +
         "</p></div></header><main>" + cards(run, mean) + images_section(run, scored) +
         reliability_section(mean) + table_section(run, scored) + left_out_section(run) +
         making_section(run) +
         "</main><footer>P(ice) of each image as STEM_ice.png (255 is certainly ice, 128 also "
         "where it is not known, which STEM_unknown.png then shows); all figures in segment.json "
         "and segmentation.csv beside this page.</footer></body></html>\n";
}

}  // namespace watersky
