// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>

#include "watersky/products/camera_calibration_products.hpp"
#include "watersky/products/detail/calibration_figures.hpp"
#include "watersky/products/detail/html.hpp"
#include "watersky/products/detail/picture.hpp"
#include "watersky/products/detail/report_style.hpp"
#include "watersky/products/detail/versions.hpp"

namespace watersky {

namespace {

using namespace detail;

std::string card(const std::string& name, const std::string& value, const std::string& more) {
  return "<div class=\"card\"><dt>" + name + "</dt><dd>" + value + "<small>" + more +
         "</small></dd></div>";
}

/// As many decimals as the sigma has meaning: two of its digits.
int decimals_of(double sigma) {
  if (!(sigma > 0) || !std::isfinite(sigma)) return 4;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9);
}

std::string cell(const std::string& text) { return "<td class=\"n\">" + text + "</td>"; }

/// Angle between the rays of two pixels; NaN where the lens shows one of them nothing.
double angle_deg(const CameraModel& camera, const Pixel& a, const Pixel& b) {
  const auto p = camera.direction(a), q = camera.direction(b);
  if (!p || !q) return std::numeric_limits<double>::quiet_NaN();
  return 180 / std::numbers::pi * std::acos(std::clamp(p->v.dot(q->v), -1.0, 1.0));
}

const LensCandidate* chosen_of(const TargetCalibration& c) {
  for (const LensCandidate& l : c.candidates)
    if (l.chosen) return &l;
  return nullptr;
}

std::string cards(const TargetCalibration& c) {
  const CameraModel& camera = c.camera;
  const double right = camera.width_px() - 1.0, bottom = camera.height_px() - 1.0;
  const double u0 = right / 2, v0 = bottom / 2;
  const auto degrees = [](double a) { return std::isfinite(a) ? number(a, 1) + "°" : "beyond"; };
  const std::size_t rejected = c.views.size() - c.used_views();
  const double relative = c.parameters[0].sigma / c.parameters[0].value;
  return "<dl class=\"cards\">" +
         card("Views", std::to_string(c.used_views()),
              rejected == 0 ? "none rejected" : std::to_string(rejected) + " rejected, see below") +
         card("Reprojection error", number(c.rms_px, 3) + " px",
              "rms over " + std::to_string(c.points) + " points") +
         card(
             "Focal length", number(camera.focal_px(), 2) + " px",
             "± " + number(c.parameters[0].sigma, 2) + " px, " + number(100 * relative, 3) + " %") +
         card("Field of view", degrees(angle_deg(camera, {0, v0}, {right, v0})),
              "across; " + degrees(angle_deg(camera, {u0, 0}, {u0, bottom})) + " down") +
         card("Image covered", percent(c.coverage.share),
              "points out to " + percent(c.coverage.radius_share) + " of the way to the corner") +
         card("Directions known to", number(c.middle_sigma_px, 2) + " px",
              "in the middle; " +
                  (std::isfinite(c.corner_sigma_px) ? number(c.corner_sigma_px, 2) + " px"
                                                    : std::string("not")) +
                  " in the corners") +
         "</dl>";
}

std::string notes_section(const TargetCalibration& c) {
  if (c.notes.empty()) return {};
  std::string html = "<section><h2>What to know</h2><ul>";
  for (const std::string& note : c.notes) html += "<li>" + escaped(note) + "</li>";
  return html + "</ul></section>";
}

std::string figure(const std::string& svg, const std::string& caption) {
  return svg.empty() ? svg : "<figure>" + svg + "<figcaption>" + caption + "</figcaption></figure>";
}

std::string figures_section(const TargetCalibration& c) {
  return "<section><h2>Residuals</h2><div class=\"pair\">" +
         figure(residual_svg(c),
                "From where the lens shows a point to where it was seen. Arrows that "
                "point alike in one part of the image mean that the lens model is too simple, or "
                "the target not flat.") +
         figure(residual_cloud_svg(c), "All residuals, from one middle; a round cloud is noise.") +
         "</div></section><section><h2>Where the target was seen</h2><div class=\"pair\">" +
         figure(coverage_svg(c),
                "Points in each part of the image. Hatched parts have none: there the distortion "
                "is a continuation of what was seen elsewhere.") +
         figure(tilt_svg(c),
                "How the target was tilted: a disc for each view lies to the side to which the "
                "target faces. All sides, and 20° to 45°, tell the focal length best.") +
         "</div></section><section><h2>Distortion</h2><div class=\"pair even\">" +
         figure(distortion_svg(c),
                "A straight grid as the lens shows it; dashed, as a lens without distortion "
                "would. The disc is the principal point, the cross the image's middle.") +
         figure(radial_svg(c),
                "How far pixels are moved outwards, against a lens without distortion of the same "
                "focal length. Shaded: farther out than any point was seen.") +
         "</div></section>";
}

std::string parameters_section(const TargetCalibration& c) {
  std::string html =
      "<section><h2>Parameters</h2><div class=\"scroll\"><table><thead><tr><th>parameter</th>"
      "<th class=\"n\">value</th><th class=\"n\">sigma</th><th class=\"n\">value / sigma</th>"
      "<th>what</th></tr></thead><tbody>";
  for (const EstimatedParameter& p : c.parameters) {
    if (!p.estimated) continue;
    const bool pixels = p.name[0] == 'f' || p.name[0] == 'c';
    const std::string what = p.name == "fx"     ? "focal length along columns"
                             : p.name == "fy"   ? "focal length along rows"
                             : p.name == "cx"   ? "principal point from the left"
                             : p.name == "cy"   ? "principal point from the top"
                             : p.name[0] == 'p' ? "tangential distortion"
                                                : "radial distortion";
    const int decimals = decimals_of(p.sigma);
    const std::string unit = pixels ? " px" : "";
    html += "<tr><td><code>" + p.name + "</code></td>" + cell(number(p.value, decimals) + unit) +
            cell(number(p.sigma, decimals) + unit) +
            cell(pixels ? "" : number(p.value / p.sigma, 1)) + "<td>" + what + "</td></tr>";
  }
  return html +
         "</tbody></table></div><p class=\"small\">One sigma, poses of the target being unknown; "
         "residuals of one view may err together. They do not know of what all views share, such "
         "as a target that is not spaced as it should be.</p></section>";
}

std::string lenses_section(const TargetCalibration& c) {
  std::string html =
      "<section><h2>Lens models</h2><div class=\"scroll\"><table><thead><tr><th>model</th>"
      "<th class=\"n\">parameters</th><th class=\"n\">rms, px</th><th class=\"n\">rms in views "
      "left out, px</th><th class=\"n\">worse than the best by</th><th></th></tr></thead><tbody>";
  for (const LensCandidate& l : c.candidates) {
    const bool bad = !std::isfinite(l.worse_by_sigmas);
    std::string remark = l.chosen ? "taken" : "";
    const auto add = [&](const std::string& text) {
      remark += (remark.empty() ? "" : "; ") + text;
    };
    if (!l.fault.empty()) add(escaped(l.fault));
    if (l.folds_unseen) add("folds back before the image's corners");
    html += std::string(l.chosen ? "<tr class=\"chosen\">" : "<tr>") + "<td>" + escaped(l.name) +
            "</td>" + cell(std::to_string(l.parameters)) + cell(number(l.rms_px, 4)) +
            cell(number(l.left_out_rms_px, 4)) +
            cell(bad ? "–" : number(l.worse_by_sigmas, 1) + " σ") + "<td class=\"wrap\">" + remark +
            "</td></tr>";
  }
  return html +
         "</tbody></table></div><p class=\"small\">The simplest model is taken that predicts views "
         "it was not fitted to as well as the best does.</p></section>";
}

std::string views_section(const CameraCalibrationRun& run) {
  const TargetCalibration& c = run.calibration;
  std::string html =
      "<section><h2>Views</h2><div class=\"scroll\"><table><thead><tr><th>image</th>"
      "<th class=\"n\">points</th><th class=\"n\">rms, px</th><th class=\"n\">tilt</th>"
      "<th class=\"n\">distance</th><th class=\"n\">edges, px</th><th></th></tr></thead><tbody>";
  for (const CalibrationView& v : c.views) {
    const auto left_out = std::count(v.left_out.begin(), v.left_out.end(), true);
    std::string remark = v.used ? "" : escaped(v.reason);
    if (v.used && left_out > 0) remark = std::to_string(left_out) + " points left out";
    const std::string distance = !std::isfinite(v.distance) ? "–"
                                 : run.spacing_m            ? metres(v.distance * *run.spacing_m)
                                                            : number(v.distance, 1) + " spacings";
    html += std::string(v.used ? "<tr>" : "<tr class=\"rejected\">") + "<td>" + escaped(v.name) +
            "</td>" + cell(v.target ? std::to_string(v.target->points.size()) : "–") +
            cell(number(v.rms_px, 3)) +
            cell(std::isfinite(v.tilt_deg) ? number(v.tilt_deg, 0) + "°" : "–") + cell(distance) +
            cell(v.target ? number(v.target->edge_width_px, 1) : "–") + "<td class=\"wrap\">" +
            remark + "</td></tr>";
  }
  html += "</tbody></table></div><div class=\"shots\">";
  for (std::size_t i = 0; i < c.views.size() && i < run.pictures.size(); ++i) {
    if (run.pictures[i].empty()) continue;
    const CalibrationView& v = c.views[i];
    html += "<figure class=\"shot\"><img loading=\"lazy\" src=\"" + jpeg_data_uri(run.pictures[i]) +
            "\" alt=\"points in " + escaped(v.name) + "\"><figcaption><b>" + escaped(v.name) +
            "</b><span>" +
            (v.used ? number(v.rms_px, 3) + " px rms" : "rejected: " + escaped(v.reason)) +
            "</span></figcaption></figure>";
  }
  return html + "</div></section>";
}

std::string making_section(const CameraCalibrationRun& run) {
  const TargetCalibration& c = run.calibration;
  const auto row = [](const std::string& name, const std::string& value) {
    return "<tr><th>" + name + "</th><td>" + escaped(value) + "</td></tr>";
  };
  const Versions versions = detail::versions();
  const auto polarity = [&]() -> std::string {
    std::size_t bright = 0, dark = 0;
    for (const CalibrationView& v : c.views)
      if (v.used) ++(v.target->bright ? bright : dark);
    if (bright > 0 && dark > 0) return "brighter in some views, darker in others";
    return bright > 0 ? "brighter (hotter) than their surroundings"
                      : "darker (colder) than their surroundings";
  };
  std::string html =
      "<section><h2>How it was made</h2><div class=\"scroll\"><table class=\"facts\"><tbody>" +
      row("Target", std::string(name_of(c.kind)) + ", " + to_string(c.size) +
                        (c.size_was_found ? ", size found from the images" : ", size as given")) +
      (c.kind == TargetKind::Chessboard ? "" : row("Circles are", polarity())) +
      row("Spacing", run.spacing_m ? metres(*run.spacing_m)
                                   : "not given: lengths are in spacings; the intrinsics do not "
                                     "depend on it") +
      row("Lens asked for", run.lens == LensChoice::Auto      ? "auto"
                            : run.lens == LensChoice::Pinhole ? "pinhole"
                                                              : "fisheye") +
      row("Tilt between views", "up to " + number(c.tilt_spread_deg, 0) + "°") +
      row("Programs", "Watersky " + versions.watersky + ", OpenCV " + versions.opencv) +
      "</tbody></table></div><details><summary>Parameters</summary><div class=\"scroll\">"
      "<table class=\"facts\"><tbody>";
  CalibrationParameters::describe(run.parameters, [&](const auto& value, const auto& info) {
    html += "<tr><th><code>" + std::string(info.name) + "</code></th><td class=\"n\">" +
            rounded(static_cast<double>(value)) +
            (info.unit == "1" ? "" : " " + std::string(info.unit)) + "</td><td>" +
            escaped(info.help) + "</td></tr>";
  });
  return html + "</tbody></table></div></details></section>";
}

constexpr const char* kCss =
    ".cards{grid-template-columns:repeat(3,minmax(0,1fr))}"
    ".pair{display:grid;grid-template-columns:minmax(0,5fr) minmax(0,3fr);gap:1.6rem;"
    "align-items:start}.pair.even{grid-template-columns:1fr 1fr}"
    ".counts text{fill:var(--ink);font-size:10px;opacity:.75}"
    ".small{font-size:.84rem;color:var(--soft);margin:.7rem 0 0}"
    "tr.chosen td{font-weight:620}tr.rejected td{color:var(--soft)}td.wrap{white-space:normal;"
    "min-width:14rem}"
    ".shots{display:grid;grid-template-columns:repeat(auto-fill,minmax(230px,1fr));gap:1.1rem;"
    "margin-top:1.2rem}.shot img{width:100%;height:auto;border-radius:4px;display:block}"
    ".shot figcaption{display:block;margin:.35rem 0 0}.shot figcaption>*{display:block;"
    "overflow-wrap:anywhere}"
    "@media(max-width:760px){.cards{grid-template-columns:1fr "
    "1fr}.pair,.pair.even{grid-template-columns:1fr}}"
    "@media print{.shot{break-inside:avoid}}";

}  // namespace

std::string camera_calibration_report_html(const CameraCalibrationRun& run) {
  const TargetCalibration& c = run.calibration;
  const LensCandidate* lens = chosen_of(c);
  const std::string size =
      std::to_string(c.camera.width_px()) + " × " + std::to_string(c.camera.height_px()) + " px";
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
         "<meta name=\"color-scheme\" content=\"light dark\"><title>Camera calibration</title>"
         "<style>" +
         report_css() + kCss +
         "</style></head><body><header><div><p class=\"kicker\">Watersky · camera calibration</p>"
         "<h1>" +
         escaped(lens ? lens->name : std::string("lens")) + "</h1><p>" + size + ", from " +
         std::to_string(c.used_views()) + " views of " +
         (c.kind == TargetKind::Chessboard ? "a chessboard of " : "a grid of ") +
         to_string(c.size) +
         (c.kind == TargetKind::Chessboard ? " inner corners"
          : c.kind == TargetKind::Holes    ? " holes"
                                           : " circles") +
         "</p></div></header><main>" + cards(c) + notes_section(c) + figures_section(c) +
         parameters_section(c) + lenses_section(c) + views_section(run) + making_section(run) +
         "</main><footer>The camera is in camera.yaml, as OpenCV and <code>watersky map "
         "--camera</code> read it; all figures are in calibration.json beside this page.</footer>"
         "</body></html>\n";
}

}  // namespace watersky
