// SPDX-License-Identifier: MIT
/// `watersky calibrate camera IMAGES -o OUT`: the intrinsics from views of a flat target.
#include <glob.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>
#include <thread>

#include "cli.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/products/camera_calibration_products.hpp"
#include "watersky/target_calibration/calibrate_images.hpp"

namespace watersky::cli {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> images;
  std::string out, target = "auto", size, lens = "auto";
  double spacing_m = 0.0;
  int threads = 0;
  bool overwrite = false;
  CalibrationParameters parameters;
};

/// Patterns that a shell has left as they are, as it does in quotes, become the files they match.
Result<std::vector<std::string>> expanded(const std::vector<std::string>& given) {
  std::vector<std::string> paths;
  for (const std::string& path : given) {
    std::error_code ignored;
    if (fs::exists(path, ignored) || path.find_first_of("*?[") == std::string::npos) {
      paths.push_back(path);
      continue;
    }
    glob_t found{};
    const int status = glob(path.c_str(), 0, nullptr, &found);
    for (std::size_t i = 0; status == 0 && i < found.gl_pathc; ++i)
      paths.emplace_back(found.gl_pathv[i]);
    globfree(&found);
    if (status != 0)
      return Error{ErrorCode::NotFound, path + ": matches no file; is the pattern right?"};
  }
  return paths;
}

/// As short as tells the images apart: their names, or where two are alike their paths.
std::vector<CalibrationImage> images_of(const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  for (const fs::path& file : files) names.push_back(file.filename().string());
  std::vector<std::string> sorted = names;
  std::sort(sorted.begin(), sorted.end());
  const bool alike = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
  std::vector<CalibrationImage> images;
  for (std::size_t i = 0; i < files.size(); ++i)
    images.push_back({alike ? files[i].string() : names[i], [file = files[i]] {
                        auto image = image_loader(file)({.color = false});
                        if (image) return image;
                        // The view has its name already.
                        Error error = image.error();
                        if (const std::string place = file.string() + ": ";
                            error.message.starts_with(place))
                          error.message = error.message.substr(place.size());
                        return Result<cv::Mat>(std::move(error));
                      }});
  return images;
}

void tell(const CameraCalibrationRun& run, const Options& o, const Common& common) {
  const TargetCalibration& c = run.calibration;
  char line[300];
  const auto lens = std::find_if(c.candidates.begin(), c.candidates.end(),
                                 [](const LensCandidate& l) { return l.chosen; });
  std::snprintf(line, sizeof line,
                "%s, from %zu of %zu views of %s %s%s: reprojection error %.3f px rms",
                lens == c.candidates.end() ? "lens" : lens->name.c_str(), c.used_views(),
                c.views.size(), std::string(name_of(c.kind)).c_str(), to_string(c.size).c_str(),
                c.size_was_found ? " (size found)" : "", c.rms_px);
  say(common, line);
  for (const EstimatedParameter& p : c.parameters) {
    if (!p.estimated) continue;
    const bool pixels = p.name[0] == 'f' || p.name[0] == 'c';
    std::snprintf(line, sizeof line, pixels ? "  %s %12.3f ± %.3f px" : "  %s %12.6f ± %.6f",
                  p.name.c_str(), p.value, p.sigma);
    say(common, line);
  }
  std::snprintf(line, sizeof line,
                "  the image is covered to %.0f %%; directions are known to %.2f px in its middle, "
                "%.2f px in its corners",
                100 * c.coverage.share, c.middle_sigma_px, c.corner_sigma_px);
  say(common, line);
  for (const CalibrationView& view : c.views) {
    std::snprintf(line, sizeof line, "  %s: %.3f px rms, tilt %.0f degrees", view.name.c_str(),
                  view.rms_px, view.tilt_deg);
    if (view.used) say_more(common, line);
  }
  for (const std::string& note : c.notes) say(common, "note: " + note);
  say(common, "Report: " + o.out + "/report.html");
  say(common, "Use it: watersky map FLIGHT -o OUT --camera " + o.out + "/camera.yaml");
}

VerbResult run(const Options& o, const Common& common) {
  WATERSKY_CHECK(validate(o.parameters));
  ImageCalibrationOptions options;
  options.target.kind = target_kind(o.target);  // none for auto
  if (!o.size.empty()) {
    WATERSKY_TRY(options.target.size, parse_target_size(o.size));
  }
  options.lens = o.lens == "pinhole"   ? LensChoice::Pinhole
                 : o.lens == "fisheye" ? LensChoice::Fisheye
                                       : LensChoice::Auto;
  options.parameters = o.parameters;
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  options.threads = o.threads > 0 ? o.threads : cores;
  cv::setNumThreads(std::min(options.threads, cores));
  WATERSKY_TRY(const auto given, expanded(o.images));
  WATERSKY_TRY(const auto files, list_inputs(given));
  WATERSKY_CHECK(check_calibration_output(o.out, o.overwrite));
  const std::vector<CalibrationImage> images = images_of(files);
  const Progress progress = progress_bar(common);
  WATERSKY_TRY(TargetCalibration calibration, calibrate_images(images, options, progress));

  CameraCalibrationRun result{.calibration = std::move(calibration),
                              .lens = options.lens,
                              .parameters = o.parameters,
                              .spacing_m = {},
                              .pictures = {}};
  if (o.spacing_m > 0) result.spacing_m = o.spacing_m;
  for (std::size_t i = 0; i < images.size(); ++i) {
    report(progress, "drawing", i, images.size());
    const auto image = images[i].load();
    result.pictures.push_back(image ? view_jpeg(*image, result.calibration.views[i]) : "");
  }
  report(progress, "drawing", images.size(), images.size());
  WATERSKY_TRY(PartialFolder partial, PartialFolder::beside(o.out));
  WATERSKY_CHECK(write_camera_calibration(partial.path(), result));
  WATERSKY_CHECK(partial.publish());
  for (const CalibrationView& view : result.calibration.views)
    if (!view.used) warn(common, "rejected: " + view.name + ": " + view.reason);
  tell(result, o, common);
  return camera_calibration_json(result);
}

}  // namespace

void add_calibrate(CLI::App& app) {
  CLI::App* calibrate = app.add_subcommand("calibrate", "Measure a camera");
  calibrate->require_subcommand(1);
  auto o = std::make_shared<Options>();
  CLI::App& verb = add_verb(*calibrate, "camera",
                            "Find focal length, centre and distortion from pictures of a flat "
                            "target: chessboard, circles, or a plate with holes",
                            [o](const Common& common) { return run(*o, common); });
  verb.add_option("IMAGES", o->images,
                  "images (JPEG, PNG or TIFF, 8 or 16 bit, gray or colour), folders of them, or "
                  "patterns such as 'board_*.png'")
      ->required();
  verb.add_option("-o,--out", o->out,
                  "folder to make, with camera.yaml, calibration.json and report.html")
      ->required();
  verb.add_option("--target", o->target,
                  "what the pictures show; holes: evenly spaced ones in a plate, for thermal "
                  "cameras, colder or hotter than it")
      ->check(CLI::IsMember({"auto", "chessboard", "circles", "asymmetric-circles", "holes"}))
      ->capture_default_str();
  verb.add_option("--size", o->size,
                  "COLUMNSxROWS of the target: a chessboard's inner corners, circles, or of an "
                  "asymmetric grid circles in a row and rows; not given: what most images show")
      ->check([](const std::string& text) {
        const auto size = parse_target_size(text);
        return size ? std::string() : size.error().message;
      });
  verb.add_option("--spacing-m", o->spacing_m,
                  "between neighbouring points, of an asymmetric grid between neighbouring rows "
                  "[m]; only distances in the report depend on it")
      ->check(CLI::Range(1e-6, 1000.0) & finite());
  verb.add_option("--lens", o->lens, "lens model; auto: the simplest that predicts as well as any")
      ->check(CLI::IsMember({"auto", "pinhole", "fisheye"}))
      ->capture_default_str();
  verb.add_option("--threads", o->threads,
                  "threads that look for the target; 0: as many as the machine has")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  verb.add_flag("--overwrite", o->overwrite, "replace OUT if it is a calibration of ours");
  add_parameters(verb, o->parameters);
}

}  // namespace watersky::cli
