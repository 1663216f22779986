// SPDX-License-Identifier: MIT
/// `watersky segment IMAGE… -o OUT`: P(ice) of images.
#include <atomic>
#include <chrono>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "cli.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/mask_file.hpp"
#include "watersky/products/segmentation_products.hpp"

namespace watersky::cli {

namespace {

namespace fs = std::filesystem;

/// More pictures than these are beside the report, not in it.
constexpr std::size_t kMostReportPictures = 60;

struct Options {
  std::vector<std::string> images, truth;
  std::string out, mask, truth_values = "auto";
  SegmentationChoice segmentation;
  bool sequence = false, overwrite = false;
  int threads = 0;
  SegmentationParameters parameters;
};

/// The images; Usage where two would be written to one file.
Result<std::vector<fs::path>> list_images_of(const std::vector<std::string>& given) {
  WATERSKY_TRY(auto files, list_inputs(given));
  std::map<std::string, fs::path> stems;
  for (const fs::path& file : files)
    if (const auto [first, is_new] = stems.emplace(file.stem().string(), file); !is_new)
      return Error{ErrorCode::Usage, first->second.string() + " and " + file.string() +
                                         " would both become " + file.stem().string() +
                                         "_ice.png; segment them apart, or rename one"};
  return files;
}

class Job {
 public:
  Job(const Options& options, Segmentation chosen, std::vector<fs::path> files)
      : options_(options), chosen_(std::move(chosen)), files_(std::move(files)) {}

  Result<SegmentationRun> run(const fs::path& folder, int threads, const Progress& progress);

 private:
  struct Outcome {
    SegmentedImage image;
    Status status;
  };
  [[nodiscard]] Result<cv::Mat> load(std::size_t i) const;
  [[nodiscard]] Result<cv::Mat> valid_for(const cv::Mat& image) const;
  [[nodiscard]] Result<ImageTruth> truth_of(std::size_t i, const cv::Mat& image,
                                            const cv::Mat& valid) const;
  Status process(std::size_t i, const fs::path& folder, SegmentedImage& image) const;

  const Options& options_;
  Segmentation chosen_;
  std::vector<fs::path> files_;
  std::unique_ptr<Segmenter> segmenter_;
  cv::Mat mask_;
};

Result<cv::Mat> Job::load(std::size_t i) const { return image_loader(files_[i])(ImageRequest{}); }

Result<cv::Mat> Job::valid_for(const cv::Mat& image) const {
  if (mask_.empty() || mask_.size() == image.size()) return mask_;
  return Error{ErrorCode::InvalidInput,
               "is " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
                   " pixels, but the mask " + options_.mask + " is " + std::to_string(mask_.cols) +
                   "x" + std::to_string(mask_.rows) + "; give a mask of the images' size"};
}

Result<ImageTruth> Job::truth_of(std::size_t i, const cv::Mat& image, const cv::Mat& valid) const {
  const std::vector<fs::path> masks(options_.truth.begin(), options_.truth.end());
  WATERSKY_TRY(const fs::path file, find_mask(files_[i], masks, files_.size() == 1));
  WATERSKY_TRY(const cv::Mat values, read_mask(file, {image.cols, image.rows}));
  const MaskValues meaning = options_.truth_values == "classes"  ? MaskValues::Classes
                             : options_.truth_values == "binary" ? MaskValues::Binary
                                                                 : MaskValues::Auto;
  auto ice = ice_in_mask(values, meaning, chosen_.ponds_are_ice ? PondIs::Ice : PondIs::Water);
  if (!ice) return ice.error().at(file.string());
  return ImageTruth{*ice, valid};
}

Status Job::process(std::size_t i, const fs::path& folder, SegmentedImage& image) const {
  WATERSKY_TRY(const cv::Mat pixels, load(i));
  const auto valid = valid_for(pixels);
  if (!valid) return valid.error().at(files_[i].string());
  const auto start = std::chrono::steady_clock::now();
  const auto p_ice = segmenter_->segment(pixels, *valid);
  image.segment_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!p_ice) return p_ice.error().at(files_[i].string());
  image.findings = segmenter_->findings_of(pixels, *valid);
  std::optional<ImageTruth> truth;
  if (!options_.truth.empty()) {
    auto found = truth_of(i, pixels, *valid);
    if (found)
      truth = *std::move(found);
    else
      image.truth_fault = found.error().message;
  }
  return write_segmented(folder, pixels, *p_ice, truth ? &*truth : nullptr, i < kMostReportPictures,
                         image);
}

Result<SegmentationRun> Job::run(const fs::path& folder, int threads, const Progress& progress) {
  SegmentationRun run;
  run.method = chosen_.method;
  run.ice = chosen_.ice;
  run.parameters = options_.parameters;
  run.parameters.model = chosen_.model;
  run.parameters.learned.ponds_are_ice = chosen_.ponds_are_ice;
  WATERSKY_TRY(segmenter_, make_segmenter(run.method, run.parameters, run.ice));
  run.sequence = options_.sequence;
  run.mask = options_.mask;
  run.pond_is_ice = chosen_.ponds_are_ice;
  for (const std::string& truth : options_.truth)
    run.truth += (run.truth.empty() ? "" : ", ") + truth;
  if (!options_.mask.empty()) {
    WATERSKY_TRY(const cv::Mat mask, image_loader(options_.mask)(ImageRequest{.color = false}));
    mask_ = mask != 0;
  }
  if (options_.sequence) {
    for (std::size_t i = 0; i < files_.size(); ++i) {
      report(progress, "looking", i, files_.size());
      const auto image = load(i);
      if (!image) continue;  // process() meets the same fault and reports it
      if (const auto valid = valid_for(*image)) segmenter_->observe(*image, *valid);
    }
    run.flight = segmenter_->findings();
  }

  std::vector<Outcome> outcomes(files_.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&](bool tells) {
    for (std::size_t i; (i = next++) < files_.size();) {
      if (tells) report(progress, "segmenting", i, files_.size());
      outcomes[i].image.file = files_[i].string();
      outcomes[i].image.stem = files_[i].stem().string();
      outcomes[i].status = process(i, folder, outcomes[i].image);
    }
  };
  {
    std::vector<std::jthread> others;
    for (int t = 1; t < std::min(threads, static_cast<int>(files_.size())); ++t)
      others.emplace_back([&] { work(false); });
    work(true);
  }
  report(progress, "segmenting", files_.size(), files_.size());
  for (Outcome& outcome : outcomes) {
    if (outcome.status) {
      run.images.push_back(std::move(outcome.image));
    } else if (outcome.status.error().code == ErrorCode::Io) {
      return outcome.status.error();  // a full disk is nobody's image's fault
    } else {
      run.left_out.push_back({outcome.image.file, outcome.status.error().message});
    }
  }
  return run;
}

/// The reason without the file's name in front, where both are shown.
std::string reason_of(const LeftOut& left_out) {
  const std::string place = left_out.file + ": ";
  return left_out.reason.starts_with(place) ? left_out.reason.substr(place.size())
                                            : left_out.reason;
}

void tell(const SegmentationRun& run, const Options& o, const Common& common) {
  for (const SegmentedImage& image : run.images) {
    char text[200];
    if (std::isnan(image.concentration)) {
      std::snprintf(text, sizeof text, "nothing known");
    } else if (image.score) {
      std::snprintf(text, sizeof text, "%.1f %% ice, truth %.1f %%, accuracy %.3f, IoU %.3f",
                    100 * image.concentration, 100 * image.score->true_concentration,
                    image.score->accuracy, image.score->iou);
    } else {
      std::snprintf(text, sizeof text, "%.1f %% ice", 100 * image.concentration);
    }
    say(common, image.file + ": " + text);
    for (const std::string& note : image.findings.notes) say_more(common, "  " + note);
  }
  if (run.flight)
    for (const std::string& note : run.flight->notes) say(common, note);
  if (const MeanSegmentationScore mean = mean_score(run.scores()); mean.images > 0) {
    char text[300];
    std::snprintf(text, sizeof text,
                  "Mean of %zu: accuracy %.3f (worst %.3f), IoU %.3f, concentration off by %.1f "
                  "points, Brier score %.3f, calibration error %.3f.",
                  mean.images, mean.accuracy, mean.worst_accuracy, mean.iou,
                  100 * mean.concentration_error, mean.brier, mean.pooled_calibration_error);
    say(common, text);
  }
  say(common, "Report: " + o.out + "/report.html");
}

VerbResult run(const Options& o, const Common& common) {
  if (o.images.empty())
    return Error{ErrorCode::Usage, "give images, or folders of them (see watersky segment --help)"};
  if (o.out.empty())
    return Error{ErrorCode::Usage,
                 "say with -o which folder to make (see watersky segment --help)"};
  WATERSKY_CHECK(validate(o.parameters));
  WATERSKY_TRY(Segmentation chosen, resolve(o.segmentation));
  WATERSKY_TRY(std::vector<fs::path> files, list_images_of(o.images));
  for (const std::string& truth : o.truth) {
    std::error_code ignored;
    if (!fs::exists(truth, ignored))
      return Error{ErrorCode::NotFound, truth + ": there is no such file or folder of masks"};
  }
  WATERSKY_CHECK(check_segment_output(o.out, o.overwrite));
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int threads = o.threads > 0 ? o.threads : cores;
  cv::setNumThreads(std::min(threads, cores));
  WATERSKY_TRY(PartialFolder partial, PartialFolder::beside(o.out));
  auto result = Job(o, std::move(chosen), std::move(files))
                    .run(partial.path(), threads, progress_bar(common));
  if (!result) return result.error();
  const SegmentationRun& run = *result;
  if (run.images.empty()) {
    Error e{ErrorCode::InvalidInput, run.left_out.front().file + ": " + reason_of(run.left_out[0])};
    if (run.left_out.size() > 1)
      e.message = "none of " + std::to_string(run.left_out.size()) +
                  " images could be segmented; " + e.message;
    return e;
  }
  WATERSKY_CHECK(write_segmentation_summary(partial.path(), run));
  WATERSKY_CHECK(partial.publish());
  for (const LeftOut& l : run.left_out) warn(common, "left out: " + l.file + ": " + reason_of(l));
  for (const SegmentedImage& image : run.images)
    if (!image.truth_fault.empty()) warn(common, "not scored: " + image.truth_fault);
  tell(run, o, common);
  const bool all_scored = std::all_of(run.images.begin(), run.images.end(),
                                      [](const auto& i) { return i.truth_fault.empty(); });
  if (!run.left_out.empty() || !all_scored) fail_in_part();
  return segment_json(run);
}

}  // namespace

void add_segment(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App& verb = add_verb(app, "segment", "Say of every pixel of images how likely it is ice",
                            [o](const Common& common) { return run(*o, common); });
  // Not ->required(): a verb below this one has its own.
  verb.add_option("IMAGE", o->images,
                  "images (JPEG, PNG or TIFF, 8 or 16 bit, gray or colour), or folders of them");
  verb.add_option("-o,--out", o->out,
                  "folder to make, with STEM_ice.png (8 bit, 255 is certainly ice, 128 also where "
                  "it is not known: STEM_unknown.png then shows where), STEM_overlay.jpg, "
                  "segmentation.csv, segment.json and report.html");
  add_segmentation(verb, o->segmentation);
  verb.add_flag("--sequence", o->sequence,
                "the images are one flight: all are looked at before the first is segmented (else "
                "each image's result depends on it alone)");
  verb.add_option("--mask", o->mask,
                  "image of the images' size, 0 where they show no sea: not segmented, not scored");
  verb.add_option("--truth", o->truth,
                  "folder of masks with the images' names, or a mask (repeat for several): adds "
                  "accuracy, IoU, concentration error, Brier score and reliability")
      ->expected(1)
      ->take_all();
  verb.add_option("--truth-values", o->truth_values,
                  "what masks hold: classes (0 melt pond, 1 sea ice, 2 ocean) or binary (0 water, "
                  "else ice); auto: binary where 255 occurs")
      ->check(CLI::IsMember({"auto", "classes", "binary"}))
      ->capture_default_str();
  verb.add_option("--threads", o->threads,
                  "threads that decode and segment; 0: as many as the machine has")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  verb.add_flag("--overwrite", o->overwrite, "replace OUT if it is a run of ours");
  add_parameters(verb, o->parameters);
  add_segment_train(verb);
}

}  // namespace watersky::cli
