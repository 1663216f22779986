// SPDX-License-Identifier: MIT
/// `watersky align FLIGHT -o OUT`: the flight as its own images correct it.
#include <cmath>

#include "cli.hpp"
#include "flight_options.hpp"
#include "watersky/products/alignment_products.hpp"
#include "watersky/products/alignment_report.hpp"

namespace watersky::cli {

namespace {

struct Options {
  FlightOptions flight;
  std::string out, images = "keep";
  bool overwrite = false;
  AlignParameters parameters;
};

StoredImages stored_images(const std::string& name) {
  if (name == "png") return StoredImages::Png;
  return name == "jpeg" ? StoredImages::Jpeg : StoredImages::Keep;
}

/// "  focal scale          1.0021 ± 0.0008 (given 1.0000 ± 0.0030)"
std::string line_of(const Estimate& e) {
  const std::string unit = e.unit == "1" ? "" : e.unit == "deg" ? "°" : " " + e.unit;
  char text[200];
  if (!e.observed) {
    std::snprintf(text, sizeof text, "  %-26s not observed, stays %s ± %s%s",
                  spoken_name(e).c_str(), to_its_sigma(e.given, e.sigma_before).c_str(),
                  to_its_sigma(e.sigma_before, e.sigma_before).c_str(), unit.c_str());
    return text;
  }
  std::snprintf(text, sizeof text, "  %-26s %s ± %s%s (given %s ± %s)", spoken_name(e).c_str(),
                to_its_sigma(e.value, e.sigma).c_str(), to_its_sigma(e.sigma, e.sigma).c_str(),
                unit.c_str(), to_its_sigma(e.given, e.sigma_before).c_str(),
                to_its_sigma(e.sigma_before, e.sigma_before).c_str());
  return text;
}

std::string delay_line(const AlignmentRun& run) {
  const DelayFigures delay = delay_figures(run.alignment);
  char text[200];
  if (!delay.estimated) {
    if (!run.given.delay_s) return {};
    std::snprintf(text, sizeof text, "  %-26s not observed, stays %.1f ms", "delay",
                  1e3 * *run.given.delay_s);
    return text;
  }
  std::string value = to_its_sigma(1e3 * delay.mean_s, 1e3 * delay.sigma_s);
  if (delay.sigma_s > 0) value += " ± " + to_its_sigma(1e3 * delay.sigma_s, 1e3 * delay.sigma_s);
  std::snprintf(text, sizeof text, "  %-26s %s ms, from %.1f to %.1f in its slow course", "delay",
                value.c_str(), 1e3 * delay.least_s, 1e3 * delay.most_s);
  return text;
}

void print(const AlignmentRun& run, const std::vector<LeftOut>& not_written, const Options& o,
           const Common& common) {
  const Alignment& a = run.alignment;
  for (const auto* some : {&run.corrected.left_out, &not_written})
    for (const LeftOut& l : *some) warn(common, "left out: " + l.file + ": " + l.reason);
  for (const std::string& note : run.corrected.notes) say(common, note);
  say(common, summary(run));
  if (const std::string line = delay_line(run); !line.empty()) say(common, line);
  for (const Estimate& e : a.estimates) say(common, line_of(e));
  const auto agreement = [&](const char* name, const TieStatistics& s) {
    if (s.ties == 0) return;
    char text[200];
    std::snprintf(text, sizeof text,
                  "  places disagree, %-17s %.3f m, nine in ten below %.3f m (%.2f px; %zu places)",
                  name, s.median_m, s.p90_m, s.median_px, s.ties);
    say(common, text);
  };
  agreement("as given", a.as_given);
  if (a.delay_estimated) agreement("constant delay", a.constant_delay);
  if (a.method != AlignMethod::AsGiven) agreement("after", a.after);
  const Eigen::Matrix2d& shared = a.shared_covariance_m2;
  if (shared.trace() > 0) {
    char text[200];
    std::snprintf(text, sizeof text, "  %s: an offset of the whole, ± %.2f m north, ± %.2f m east",
                  anchored(a) ? "what anchors leave" : "what images cannot see",
                  std::sqrt(shared(0, 0)), std::sqrt(shared(1, 1)));
    say(common, text);
  }
  say(common, "Wrote " + std::to_string(run.corrected.frames.size() - not_written.size()) + " of " +
                  std::to_string(run.given.frames.size() + run.given.left_out.size()) +
                  " frames of " + run.given.name + ".");
  say(common, "Report: " + o.out + "/report.html");
  say(common, "Map it with: watersky map " + o.out + " --no-align -o MAP");
}

VerbResult run(const Options& o, const Common& common) {
  WATERSKY_CHECK(validate(o.parameters));
  const WriteAlignmentOptions write{.overwrite = o.overwrite, .images = stored_images(o.images)};
  WATERSKY_CHECK(check_alignment_output(o.out, o.flight.flight, write));
  AlignOptions options{.parameters = o.parameters, .threads = use_threads(o.flight.threads)};
  WATERSKY_TRY(const Masks masks, read_masks(o.flight.masks));
  if (!masks.excluded.empty())
    return Error{ErrorCode::Usage,
                 "--mask: align takes images of the camera's size; polygons of the world are for "
                 "watersky map"};
  options.camera_mask = masks.camera;
  const Progress progress = progress_bar(common);
  WATERSKY_TRY(const Flight flight, read_flight_over_sea(o.flight, progress));
  const auto run = run_alignment(flight, options, progress);
  if (!run) return run.error().at(o.flight.flight);
  const auto not_written = write_alignment(*run, o.out, write, progress);
  if (!not_written) return not_written.error().at(o.flight.flight);
  print(*run, *not_written, o, common);
  return alignment_json(*run, *not_written);
}

}  // namespace

void add_align(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App& verb =
      add_verb(app, "align", "Correct a flight's times, mount and poses by what its images show",
               [o](const Common& common) { return run(*o, common); });
  verb.add_option("-o,--out", o->out, "flight folder to make, with align.json and report.html")
      ->required();
  add_flight_options(verb, o->flight);
  add_mask_option(verb, o->flight,
                  "images of the camera's size, 0 where its picture is not to be used (aircraft, "
                  "bow)");
  verb.add_option("--images", o->images,
                  "keep copies image files as they are (frames of a video become JPEG); png and "
                  "jpeg write all anew")
      ->check(CLI::IsMember({"keep", "png", "jpeg"}))
      ->capture_default_str();
  add_threads_option(verb, o->flight);
  verb.add_flag("--overwrite", o->overwrite, "replace OUT if it is an alignment of ours");
  add_parameters(verb, o->parameters);
}

}  // namespace watersky::cli
