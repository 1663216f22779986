// SPDX-License-Identifier: MIT
#pragma once
/// What comes out of segmenting images, as files: for each STEM_ice.png, STEM_overlay.jpg,
/// STEM_unknown.png where something is not known and STEM_errors.jpg where the truth is;
/// segmentation.csv, segment.json and report.html for all. Names and contents are a contract.
#include <filesystem>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "watersky/evaluation/segmentation_score.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky {

/// One image and what came of it.
struct SegmentedImage {
  std::string file;  ///< as it was given
  std::string stem;
  int width_px = 0, height_px = 0;
  /// Share of the known pixels that are more likely ice than not; NaN: none is known.
  double concentration = std::numeric_limits<double>::quiet_NaN();
  /// Mean P(ice) of the known pixels; NaN: none is known.
  double mean_p_ice = std::numeric_limits<double>::quiet_NaN();
  double unknown_share = 0.0;
  double segment_s = 0.0;  ///< without reading and writing
  Findings findings;
  std::optional<SegmentationScore> score;
  std::string truth_fault;                ///< why there is no score although truth was given
  std::string overlay_jpeg, errors_jpeg;  ///< for the report, at most 640 px wide; may be empty
};

struct SegmentationRun {
  SegmentationMethod method = kDefaultSegmentationMethod;
  SegmentationParameters parameters;
  IcePolarity ice = IcePolarity::Auto;
  bool sequence = false;  ///< the images were one flight, known as a whole
  std::optional<Findings> flight;
  std::string mask;          ///< of what is not sea; empty: none
  std::string truth;         ///< where the masks are; empty: none
  bool pond_is_ice = false;  ///< in the truth and by learned methods
  std::vector<SegmentedImage> images;
  std::vector<LeftOut> left_out;

  [[nodiscard]] std::vector<SegmentationScore> scores() const;
  [[nodiscard]] std::string model_name() const { return watersky::model_name(method, parameters); }
};

/// What is compared with.
struct ImageTruth {
  cv::Mat ice;     ///< CV_8U, not 0 where ice
  cv::Mat judged;  ///< CV_8U; empty: all
};

/// Writes one image's pictures into `folder` and fills in its figures. `keep_pictures`: also for
/// the report. May be called from several threads for different images.
Status write_segmented(const std::filesystem::path& folder, const cv::Mat& image,
                       const cv::Mat& p_ice, const ImageTruth* truth, bool keep_pictures,
                       SegmentedImage& segmented);

[[nodiscard]] nlohmann::json segment_json(const SegmentationRun& run);
[[nodiscard]] std::string segmentation_csv(const SegmentationRun& run);
[[nodiscard]] std::string segmentation_report_html(const SegmentationRun& run);

/// The three files about all images.
Status write_segmentation_summary(const std::filesystem::path& folder, const SegmentationRun& run);

/// Whether OUT may be made: as check_output(), with segment.json as the mark of an earlier run. An
/// empty folder may stand there.
Status check_segment_output(const std::filesystem::path& out, bool overwrite);

}  // namespace watersky
