// SPDX-License-Identifier: MIT
#include "watersky/products/alignment_report.hpp"

#include <cmath>
#include <map>

#include "watersky/products/detail/alignment_pictures.hpp"
#include "watersky/products/detail/alignment_sections.hpp"
#include "watersky/products/detail/html.hpp"
#include "watersky/products/detail/picture.hpp"
#include "watersky/products/detail/report_style.hpp"
#include "watersky/products/detail/versions.hpp"
#include "watersky/products/palette.hpp"

namespace watersky {

namespace {

using namespace detail;

std::string card(const std::string& name, const std::string& value, const std::string& more) {
  return "<div class=\"card\"><dt>" + name + "</dt><dd>" + value + "<small>" + more +
         "</small></dd></div>";
}

std::string method_text(const Alignment& a) {
  switch (a.method) {
    case AlignMethod::AsGiven: return "nothing changed";
    case AlignMethod::ConstantDelay: return "the images' times alone";
    case AlignMethod::Full: return "times, mount and poses";
  }
  return "";
}

std::string delay_card(const AlignmentRun& run) {
  const DelayFigures delay = delay_figures(run.alignment);
  if (!delay.estimated)
    return card("Delay of the images",
                run.given.delay_s ? number(1e3 * *run.given.delay_s, 1) + " ms" : "–",
                run.given.delay_s ? "as given"
                                  : "none to estimate: captures are timed, or the "
                                    "images do not show it");
  return card("Delay of the images", with_sigma(1e3 * delay.mean_s, 1e3 * delay.sigma_s, "ms"),
              "mean; from " + number(1e3 * delay.least_s, 1) + " to " +
                  number(1e3 * delay.most_s, 1) + " ms in its slow course");
}

std::string cards(const AlignmentRun& run, const std::vector<LeftOut>& not_written) {
  const Alignment& a = run.alignment;
  const bool known = a.after.ties > 0;
  const Eigen::Matrix2d& shared = a.shared_covariance_m2;
  const std::size_t kept = run.corrected.frames.size() - not_written.size();
  const std::size_t out = run.corrected.left_out.size() + not_written.size();
  return "<dl class=\"cards\">" +
         card("Aligned", a.method == AlignMethod::AsGiven ? "no" : std::string(name_of(a.method)),
              method_text(a)) +
         delay_card(run) +
         card("Places disagree by", known ? metres(a.after.median_m) : "–",
              known ? "median; as given " + metres(a.as_given.median_m) + ", of " +
                          std::to_string(a.after.ties) + " places that took no part"
                    : "no place was seen by several frames") +
         card("Frames", std::to_string(kept),
              out == 0 ? "none left out" : std::to_string(out) + " left out, see below") +
         card("Places followed", std::to_string(a.sightings),
              "sightings, from " + std::to_string(a.keyframes) + " keyframes on") +
         card("Seen again on return", std::to_string(a.revisits),
              "pairs of frames tied by flying there again") +
         card("One sighting", a.pixel_sigma > 0 ? "± " + number(a.pixel_sigma, 2) + " px" : "–",
              "one sigma, from what is left over") +
         card("Offset of the whole",
              shared.trace() > 0 ? "± " + metres(std::sqrt(shared.trace() / 2)) : "–",
              shared.trace() > 0
                  ? std::string("one sigma along each axis, shared by all frames: ") +
                        (anchored(a) ? "what the anchors leave" : "images cannot see it")
                  : "not known: images cannot see it") +
         "</dl>";
}

Result<std::string> pair(const std::string& what, const cv::Mat& before, const cv::Mat& after,
                         const std::string& below_before, const std::string& below_after) {
  WATERSKY_TRY(const std::string a, jpeg_data_uri(before));
  WATERSKY_TRY(const std::string b, jpeg_data_uri(after));
  const auto figure = [&](const char* when, const std::string& uri, const std::string& below) {
    return "<figure><img alt=\"" + what + ", " + when + "\" src=\"" + uri + "\"><figcaption><b>" +
           when + "</b>" + below + "</figcaption></figure>";
  };
  return "<h3>" + what + "</h3><div class=\"pair\">" + figure("as given", a, below_before) +
         figure("corrected", b, below_after) + "</div>";
}

std::string gradient(Ramp ramp) {
  std::string stops;
  for (const RampStop& s : ramp)
    stops.append(",").append(hex(s.color)).append(" ").append(number(100 * s.at, 0)).append("%");
  return "linear-gradient(90deg" + stops + ")";
}

Result<std::string> pictures_section(const AlignmentRun& run) {
  if (run.alignment.method == AlignMethod::AsGiven) return std::string();
  const std::optional<BeforeAfter> pictures = before_after(run);
  if (!pictures)
    return std::string(
        "<section><h2>Before and after</h2><p>No place is shown by two frames that have a pose "
        "before and after.</p></section>");
  const auto levels = [](double x) { return "<span>" + number(x, 1) + " levels of 255</span>"; };
  WATERSKY_TRY(const std::string mean, pair("The frames' mean: sharp where they agree",
                                            pictures->before.mean, pictures->after.mean, "", ""));
  WATERSKY_TRY(const std::string mosaic,
               pair("Laid side by side, as in the map's mosaic: errors show at the seams",
                    pictures->before.mosaic, pictures->after.mosaic, "", ""));
  WATERSKY_TRY(const std::string spread,
               pair("How the frames' levels differ at one place, root mean square",
                    pictures->before.spread, pictures->after.spread,
                    levels(pictures->before.spread_levels), levels(pictures->after.spread_levels)));
  return "<section><h2>Before and after</h2><p>One place of the sea in " +
         std::to_string(pictures->frames) + " frames, laid there by their poses; " +
         metres(pictures->cell_m * pictures->before.mean.cols) + " wide, north up, cells of " +
         metres(pictures->cell_m) + ".</p>" + mean + mosaic + spread +
         "<p class=\"keys\"><span class=\"key\"><b>levels</b> 0 <span class=\"ramp\" "
         "style=\"background:" +
         gradient(kCountRamp) + "\"></span> " + number(pictures->most_spread_levels, 0) +
         "</span><span class=\"key\">Smooth differences of light are taken out; noise and "
         "waves stay.</span></p></section>";
}

std::string delay_section(const AlignmentRun& run) {
  const std::string chart = delay_chart(run);
  if (chart.empty()) return {};
  return "<section><h2>Delay of the images over time</h2>" + chart +
         "<p>What lies between the capture of an image and the time that it was stamped "
         "with.</p></section>";
}

std::string navigation_section(const AlignmentRun& run) {
  const std::string charts = corrections_charts(run);
  if (charts.empty()) return {};
  const PoseSigma& s = run.alignment.navigation_sigma;
  const Eigen::Vector3d &p = s.position_north_east_down_m,
                        a = s.roll_pitch_yaw_rad / Angle::degrees(1).radians();
  std::string html = "<section><h2>Errors of the navigation</h2>";
  if (p.norm() > 0)
    html += "<p>Of the recorded poses one sigma is, judged by what is left over, " +
            metres(std::sqrt(p.head<2>().squaredNorm() / 2)) + " across, " + metres(p.z()) +
            " in height, and " + number(a.x(), 2) + "°, " + number(a.y(), 2) + "° and " +
            number(a.z(), 2) + "° in attitude. The charts show corrected less recorded.</p>";
  return html + charts + "</section>";
}

std::string estimates_section(const AlignmentRun& run) {
  const std::string table = estimates_table(run.alignment);
  if (table.empty()) return {};
  return "<section><h2>Mount, focal length and the like</h2>" + table +
         "<p>What did not become at least twice as well known as before is not observed: it stays "
         "as it was given, for what would move it is what the model does not know.</p></section>";
}

std::string known_section(const AlignmentRun& run) {
  const Alignment& a = run.alignment;
  if (a.anchors.empty() && a.ranges.ranges == 0) return {};
  std::string rows;
  for (const AnchorOutcome& o : a.anchors)
    rows += "<tr><th>" + escaped(o.name) + "</th><td class=\"n\">" + std::to_string(o.used) +
            " of " + std::to_string(o.sightings) + "</td><td class=\"n\">" +
            (o.used > 0 ? metres(o.as_given_rms_m) : "–") + "</td><td class=\"n\">" +
            (o.used > 0 ? metres(o.after_rms_m) : "–") + "</td><td>" + escaped(o.left_out) +
            "</td></tr>";
  if (a.ranges.ranges > 0)
    rows += "<tr><th>height, by the range finder</th><td class=\"n\">" +
            std::to_string(a.ranges.used) + " of " + std::to_string(a.ranges.ranges) +
            "</td><td class=\"n\">" +
            (a.ranges.used > 0 ? metres(std::abs(a.ranges.as_given_m)) : "–") +
            "</td><td class=\"n\">" +
            (a.ranges.used > 0 ? metres(std::abs(a.ranges.after_m)) : "–") + "</td><td></td></tr>";
  return "<section><h2>Known points</h2><div class=\"scroll\"><table><thead><tr><th></th><th "
         "class=\"n\">used</th><th class=\"n\">off as given</th><th class=\"n\">off after</th>"
         "<th>left out</th></tr></thead><tbody>" +
         rows +
         "</tbody></table></div><p>How far the frames put an anchor from where it is: images "
         "cannot "
         "see the offset that all frames share, anchors do.</p></section>";
}

std::string left_out_section(const AlignmentRun& run, const std::vector<LeftOut>& not_written) {
  std::map<std::string, std::vector<std::string>> files_of_reason;
  for (const auto* some : {&run.corrected.left_out, &not_written})
    for (const LeftOut& l : *some) files_of_reason[l.reason].push_back(l.file);
  if (files_of_reason.empty()) return {};
  std::string html = "<section><h2>Frames left out</h2>";
  for (const auto& [reason, files] : files_of_reason) {
    std::string list;
    for (const std::string& file : files) list += "<li>" + escaped(file) + "</li>";
    html += std::string("<details") + (files.size() <= 12 ? " open" : "") + "><summary><b>" +
            std::to_string(files.size()) + "</b> " + escaped(reason) +
            "</summary><ul class=\"files\">" + list + "</ul></details>";
  }
  return html + "</section>";
}

std::string notes_section(const AlignmentRun& run) {
  std::string list;
  if (!run.alignment.method_reason.empty()) list += "<li>" + escaped(summary(run)) + "</li>";
  for (const std::string& note : run.corrected.notes) list += "<li>" + escaped(note) + "</li>";
  return list.empty() ? list : "<section><h2>Notes</h2><ul>" + list + "</ul></section>";
}

std::string making_section(const AlignmentRun& run) {
  const auto row = [](const std::string& name, const std::string& value) {
    return value.empty() ? "" : "<tr><th>" + name + "</th><td>" + escaped(value) + "</td></tr>";
  };
  const Alignment& a = run.alignment;
  const Versions versions = detail::versions();
  std::string html =
      "<section><h2>How it was made</h2><div class=\"scroll\"><table class=\"facts\"><tbody>" +
      row("Sea level", run.given.sea_level ? run.given.sea_level->description : "") +
      row("Calibration", run.given.calibration.description) +
      row("Time", number(run.wall_s, 1) + " s, of these " + number(a.tracking_s, 1) +
                      " s of tracking and " + number(a.solving_s, 1) + " s of adjusting, " +
                      std::to_string(run.threads) + (run.threads == 1 ? " thread" : " threads")) +
      row("Programs", "Watersky " + versions.watersky + ", OpenCV " + versions.opencv) +
      "</tbody></table></div><details><summary>Parameters</summary><div class=\"scroll\"><table "
      "class=\"facts\"><tbody>";
  AlignParameters::describe(run.parameters, [&](const auto& value, const ParameterInfo& info) {
    std::string text;
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, bool>)
      text = value ? "yes" : "no";
    else
      text = rounded(static_cast<double>(value)) +
             (info.unit == "1" ? "" : " " + std::string(info.unit));
    html += "<tr><th><code>" + std::string(info.name) + "</code></th><td class=\"n\">" + text +
            "</td><td>" + escaped(info.help) + "</td></tr>";
  });
  return html + "</tbody></table></div></details></section>";
}

constexpr const char* kCss =
    ".pair{display:grid;grid-template-columns:1fr 1fr;gap:.7rem}"
    ".pair img{width:100%;height:auto;display:block;border-radius:4px}"
    ".pair figcaption{margin:.3rem 0 0;gap:.2rem .6rem}.pair figcaption b{color:var(--ink)}"
    "@media print{.pair{break-inside:avoid}}";

}  // namespace

Result<std::string> alignment_report_html(const AlignmentRun& run,
                                          const std::vector<LeftOut>& not_written) {
  WATERSKY_TRY(const std::string pictures, pictures_section(run));
  const std::string name = escaped(run.given.name);
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
         "<meta name=\"color-scheme\" content=\"light dark\"><title>Alignment: " +
         name + "</title><style>" + report_css() + kCss +
         "</style></head><body><header><div><p class=\"kicker\">Watersky · alignment</p><h1>" +
         name + "</h1><p>" + escaped(summary(run)) + "</p></div></header><main>" +
         cards(run, not_written) + "<section><h2>Do the frames agree?</h2>" +
         disagreement_table(run.alignment) + "</section>" + pictures + delay_section(run) +
         known_section(run) + estimates_section(run) + navigation_section(run) +
         notes_section(run) + left_out_section(run, not_written) + making_section(run) +
         "</main><footer>This folder is the corrected flight; every figure, and each frame's, is "
         "in align.json beside this page.</footer></body></html>\n";
}

}  // namespace watersky
