// SPDX-License-Identifier: MIT
/// The study of the thesis's section 2.4.1 with truth: every segmentation method on every
/// labelled image.
///
///   segmentation [DATA] [OUT]
///
/// DATA is a folder with images/ and masks/ (0 melt pond, 1 sea ice, 2 ocean), or one that holds
/// tir_sea_ice/ and, for the polarity of ice and for points labelled by eye, hotrax_pack_ice/ and
/// glacier_bay/. OUT (segmentation_study) gets figure_2_1.svg and table.txt. Figures are printed
/// one JSON object a line, the tables on standard error as well.
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

#include <chrono>
#include <cmath>
#include <string_view>

#include "study.hpp"
#include "support/real_data.hpp"
#include "support/tell.hpp"
#include "watersky/io/files.hpp"

namespace fs = std::filesystem;
using namespace watersky;
using namespace watersky::study;

namespace {

struct Outcome {
  std::vector<SegmentationScore> scores;  ///< an image each
  double seconds = 0.0;                   ///< a frame
};

std::vector<const LabelledImage*> all_but(const std::vector<LabelledImage>& images, std::size_t i) {
  std::vector<const LabelledImage*> others;
  for (std::size_t k = 0; k < images.size(); ++k)
    if (k != i) others.push_back(&images[k]);
  return others;
}

/// One image left out at a time. `seen`: how the images look when judged; training is on the
/// images as they are.
Result<Outcome> judge(const Contender& contender, const std::vector<LabelledImage>& images,
                      const std::vector<cv::Mat>& seen, PondIs pond) {
  Outcome outcome;
  for (std::size_t i = 0; i < images.size(); ++i) {
    WATERSKY_TRY(const auto segmenter, contender.make(all_but(images, i), images[i], pond));
    const auto start = std::chrono::steady_clock::now();
    WATERSKY_TRY(const cv::Mat p_ice, segmenter->segment(seen[i], {}));
    outcome.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
        static_cast<double>(images.size());
    WATERSKY_TRY(SegmentationScore score, score_segmentation(p_ice, images[i].ice(pond)));
    outcome.scores.push_back(std::move(score));
  }
  return outcome;
}

void tell_header(const std::vector<LabelledImage>& images) {
  tell("%-22s %8s %6s %6s %6s %6s %6s %6s %6s %8s |", "method", "accuracy", "worst", "IoU", "conc",
       "Brier", "ECE", "P1", "P2", "ms");
  for (const LabelledImage& image : images)
    tell(" %4.4s", image.name.substr(image.name.size() < 2 ? 0 : image.name.size() - 2).c_str());
  tell("\n");
}

void report(const std::string& prefix, const std::string& name, const Outcome& outcome,
            const std::string& what) {
  const MeanSegmentationScore mean = mean_score(outcome.scores);
  const std::string figure = prefix + name;
  print_figure(figure + ".accuracy", mean.accuracy);
  print_figure(figure + ".worst_accuracy", mean.worst_accuracy);
  print_figure(figure + ".iou", mean.iou);
  print_figure(figure + ".concentration_error", mean.concentration_error);
  print_figure(figure + ".brier", mean.brier);
  print_figure(figure + ".ece", mean.pooled_calibration_error);
  print_figure(figure + ".mean_image_ece", mean.calibration_error);
  print_figure(figure + ".p_ice_if_ice", mean.p_ice_if_ice);
  print_figure(figure + ".p_ice_if_water", mean.p_ice_if_water);
  print_figure(figure + ".unknown_share", mean.unknown_share);
  if (outcome.seconds > 0) print_figure(figure + ".ms", 1e3 * outcome.seconds, "ms");
  tell("%-22s %8.3f %6.3f %6.3f %6.3f %6.3f %6.3f %6.3f %6.3f %8.2f |", what.c_str(), mean.accuracy,
       mean.worst_accuracy, mean.iou, mean.concentration_error, mean.brier,
       mean.pooled_calibration_error, mean.p_ice_if_ice, mean.p_ice_if_water,
       1e3 * outcome.seconds);
  for (const SegmentationScore& score : outcome.scores) tell(" %.2f", score.accuracy);
  tell("\n");
}

/// What the masks' own resolution allows: they against themselves, one pixel to the right and down
/// by turns.
Result<Outcome> shifted_masks(const std::vector<LabelledImage>& images, PondIs pond) {
  Outcome outcome;
  for (const LabelledImage& image : images) {
    const cv::Mat ice = image.ice(pond);
    const bool right = outcome.scores.size() % 2 == 0;
    cv::Mat shifted = ice.clone();
    if (right)
      ice.colRange(0, ice.cols - 1).copyTo(shifted.colRange(1, ice.cols));
    else
      ice.rowRange(0, ice.rows - 1).copyTo(shifted.rowRange(1, ice.rows));
    cv::Mat p_ice;
    shifted.convertTo(p_ice, CV_32F, 1.0 / 255.0);
    WATERSKY_TRY(SegmentationScore score, score_segmentation(p_ice, ice));
    outcome.scores.push_back(std::move(score));
  }
  return outcome;
}

/// The one level a picture, chosen with its truth, that no threshold can beat.
Result<Outcome> best_thresholds(const std::vector<LabelledImage>& images, PondIs pond) {
  Outcome outcome;
  for (const LabelledImage& image : images) {
    const cv::Mat ice = image.ice(pond);
    double best = -1.0;
    cv::Mat best_p;
    for (int level = 0; level < 255; ++level) {
      const cv::Mat bright = image.image > level;
      for (const cv::Mat& found : {bright, cv::Mat(~bright)}) {
        const double right = static_cast<double>(ice.total()) - cv::countNonZero(found ^ ice);
        if (right <= best) continue;
        best = right;
        found.convertTo(best_p, CV_32F, 1.0 / 255.0);
      }
    }
    WATERSKY_TRY(SegmentationScore score, score_segmentation(best_p, ice));
    outcome.scores.push_back(std::move(score));
  }
  return outcome;
}

/// Through fog of a transmission: contrast shrinks towards the mean, the camera's noise does not.
cv::Mat fogged(const cv::Mat& image, double transmission, double noise_sigma, std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat level, noise(image.size(), CV_32F), out;
  image.convertTo(level, CV_32F);
  const double mean = cv::mean(level)[0];
  rng.fill(noise, cv::RNG::NORMAL, 0.0, noise_sigma);
  level = (level - mean) * transmission + mean + noise;
  level.convertTo(out, image.type());
  return out;
}

Status study_fog(const std::vector<LabelledImage>& images) {
  constexpr double kNoise = 4.0;
  tell("\nThrough fog: contrast times T, noise of %.0f levels. |P - 1/2| is 0 where not known.\n",
       kNoise);
  for (const Contender& contender : contenders()) {
    tell("%-22s %5s %9s %8s %8s %6s %6s %6s\n", contender.what.c_str(), "T", "not known",
         "accuracy", "|P-1/2|", "Brier", "P1", "P2");
    for (const double transmission : {1.0, 0.5, 0.25, 0.12, 0.06, 0.03, 0.015, 0.0}) {
      std::vector<cv::Mat> seen;
      for (std::size_t i = 0; i < images.size(); ++i)
        seen.push_back(fogged(images[i].image, transmission, kNoise, 100 + i));
      WATERSKY_TRY(const Outcome outcome, judge(contender, images, seen, PondIs::Water));
      const MeanSegmentationScore mean = mean_score(outcome.scores);
      double from_half = 0.0;
      for (const Reliability::Bin& bin : mean.reliability.bins())
        if (bin.pixels > 0)
          from_half += std::abs(bin.mean_p() - 0.5) * static_cast<double>(bin.pixels) /
                       static_cast<double>(mean.reliability.pixels());
      // Of what was answered.
      const double answered = 1.0 - mean.unknown_share;
      const double accuracy = answered > 0 ? mean.accuracy / answered : std::nan("");
      char fog[80];
      std::snprintf(fog, sizeof fog, "segmentation.tir_sea_ice.fog_%g.", transmission);
      const std::string figure = fog + contender.name;
      print_figure(figure + ".unknown_share", mean.unknown_share);
      print_figure(figure + ".accuracy_of_known", accuracy);
      print_figure(figure + ".mean_distance_from_half", from_half);
      print_figure(figure + ".brier", mean.brier);
      print_figure(figure + ".p_ice_if_ice", mean.p_ice_if_ice);
      print_figure(figure + ".p_ice_if_water", mean.p_ice_if_water);
      tell("%-22s %5g %9.2f %8.3f %8.3f %6.3f %6.3f %6.3f\n", "", transmission, mean.unknown_share,
           accuracy, from_half, mean.brier, mean.p_ice_if_ice, mean.p_ice_if_water);
    }
  }
  return {};
}

Status run(const fs::path& data, const fs::path& out) {
  const bool one_set = fs::is_directory(data / "masks");
  WATERSKY_TRY(const auto images, read_labelled(one_set ? data : data / "tir_sea_ice"));
  std::error_code error;
  fs::create_directories(out, error);
  if (error) return Error{ErrorCode::Io, out.string() + ": cannot be made: " + error.message()};
  WATERSKY_CHECK(write_figure_2_1(out / "figure_2_1.svg", images[images.size() / 2]));

  std::vector<cv::Mat> seen;
  for (const LabelledImage& image : images) seen.push_back(image.image);
  for (const PondIs pond : {PondIs::Water, PondIs::Ice}) {
    const std::string prefix =
        std::string("segmentation.tir_sea_ice.") + (pond == PondIs::Ice ? "pond_is_ice." : "");
    tell(
        "\n%zu images, melt ponds count as %s; one image left out at a time for what is trained. "
        "Unknown pixels count as wrong.\n",
        images.size(), pond == PondIs::Ice ? "ice" : "water");
    tell_header(images);
    for (const Contender& contender : contenders()) {
      WATERSKY_TRY(const Outcome outcome, judge(contender, images, seen, pond));
      report(prefix, contender.name, outcome, contender.what);
    }
    WATERSKY_TRY(const Outcome best, best_thresholds(images, pond));
    report(prefix, "best_threshold", best, "best threshold");
    WATERSKY_TRY(const Outcome ceiling, shifted_masks(images, pond));
    report(prefix, "ceiling_shifted_masks", ceiling, "masks shifted by 1 px");
  }
  WATERSKY_CHECK(study_fog(images));
  study_polarity(one_set ? fs::path() : data, images);
  if (!one_set)
    WATERSKY_CHECK(study_points(data / "glacier_bay/tiles",
                                WATERSKY_SOURCE_DIR "/tests/data/glacier_bay_points.csv"));
  return write_file(out / "table.txt", told());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 3 || (argc > 1 && std::string_view(argv[1]).starts_with("-"))) {
    std::fprintf(stderr, "usage: segmentation [DATA] [OUT]\n");
    return argc == 2 && std::string_view(argv[1]) == "--help" ? 0 : 2;
  }
  const auto data = argc > 1 ? fs::path(argv[1]) : test::real_data("").value_or("");
  if (data.empty()) {
    std::fprintf(stderr, "segmentation: the labelled images are not here; name their folder\n");
    return 1;
  }
  cv::setNumThreads(1);
  const Status done = run(data, argc > 2 ? argv[2] : "segmentation_study");
  if (done) return 0;
  std::fprintf(stderr, "segmentation: %s\n", done.error().message.c_str());
  return 1;
}
