// SPDX-License-Identifier: MIT
#include "watersky/products/segmentation_products.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/io/files.hpp"
#include "watersky/products/detail/run_folder.hpp"
#include "watersky/products/detail/versions.hpp"
#include "watersky/products/segmentation_pictures.hpp"

namespace watersky {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kReportWidth_px = 640;

Status write_picture(const fs::path& file, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  const std::string ending = file.extension().string();
  const std::vector<int> how = ending == ".png" ? std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 3}
                                                : std::vector<int>{cv::IMWRITE_JPEG_QUALITY, 90};
  if (!cv::imencode(ending, picture, bytes, how))
    return Error{ErrorCode::Io, file.string() + ": OpenCV could not encode the picture"};
  return write_file(file,
                    std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

std::string report_jpeg(const cv::Mat& picture) {
  cv::Mat small = picture;
  if (picture.cols > kReportWidth_px) {
    const double scale = static_cast<double>(kReportWidth_px) / picture.cols;
    cv::resize(picture, small, cv::Size(), scale, scale, cv::INTER_AREA);
  }
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, 80})) return {};
  return {bytes.begin(), bytes.end()};
}

/// JSON has no NaN: null.
json number(double value) { return std::isfinite(value) ? json(value) : json(); }

json score_json(const SegmentationScore& s) {
  return {{"accuracy", s.accuracy},
          {"iou", s.iou},
          {"true_concentration", s.true_concentration},
          {"concentration_error", number(s.concentration_error())},
          {"brier", s.brier},
          {"expected_calibration_error", number(s.calibration_error())},
          {"p_ice_if_ice", number(s.p_ice_if_ice)},
          {"p_ice_if_water", number(s.p_ice_if_water)},
          {"pixels", s.pixels}};
}

json findings_json(const Findings& findings) {
  json object{{"notes", findings.notes}, {"polarity", nullptr}};
  if (findings.polarity)
    object["polarity"] = {{"ice", name_of(findings.polarity->polarity)},
                          {"confidence", findings.polarity->confidence}};
  return object;
}

json reliability_json(const Reliability& reliability) {
  json bins = json::array();
  for (const Reliability::Bin& bin : reliability.bins())
    if (bin.pixels > 0)
      bins.push_back({{"mean_p_ice", bin.mean_p()},
                      {"share_of_ice", bin.ice_share()},
                      {"pixels", bin.pixels}});
  return bins;
}

}  // namespace

std::vector<SegmentationScore> SegmentationRun::scores() const {
  std::vector<SegmentationScore> found;
  for (const SegmentedImage& image : images)
    if (image.score) found.push_back(*image.score);
  return found;
}

Status write_segmented(const fs::path& folder, const cv::Mat& image, const cv::Mat& p_ice,
                       const ImageTruth* truth, bool keep_pictures, SegmentedImage& segmented) {
  segmented.width_px = image.cols;
  segmented.height_px = image.rows;
  std::size_t known = 0, ice = 0;
  double sum = 0.0;
  for (int y = 0; y < p_ice.rows; ++y) {
    const float* p = p_ice.ptr<float>(y);
    for (int x = 0; x < p_ice.cols; ++x) {
      if (std::isnan(p[x])) continue;
      ++known;
      ice += p[x] > 0.5F ? 1 : 0;
      sum += static_cast<double>(p[x]);
    }
  }
  segmented.unknown_share = 1.0 - static_cast<double>(known) / static_cast<double>(p_ice.total());
  if (known > 0) {
    segmented.concentration = static_cast<double>(ice) / static_cast<double>(known);
    segmented.mean_p_ice = sum / static_cast<double>(known);
  }
  if (truth) {
    auto score = score_segmentation(p_ice, truth->ice, truth->judged);
    if (score)
      segmented.score = *score;
    else
      segmented.truth_fault = score.error().message;
  }

  const auto file = [&](const char* ending) { return folder / (segmented.stem + ending); };
  WATERSKY_CHECK(write_picture(file("_ice.png"), probability_picture(p_ice)));
  const cv::Mat overlay = overlay_picture(image, p_ice);
  WATERSKY_CHECK(write_picture(file("_overlay.jpg"), overlay));
  if (keep_pictures) segmented.overlay_jpeg = report_jpeg(overlay);
  if (const cv::Mat unknown = unknown_picture(p_ice); !unknown.empty())
    WATERSKY_CHECK(write_picture(file("_unknown.png"), unknown));
  if (segmented.score) {
    const cv::Mat errors = error_picture(image, p_ice, truth->ice, truth->judged);
    WATERSKY_CHECK(write_picture(file("_errors.jpg"), errors));
    if (keep_pictures) segmented.errors_jpeg = report_jpeg(errors);
  }
  return {};
}

json segment_json(const SegmentationRun& run) {
  const detail::Versions versions = detail::versions();
  json images = json::array(), left_out = json::array(), parameters = json::object();
  double concentration = 0.0;
  std::size_t with_concentration = 0;
  for (const SegmentedImage& image : run.images) {
    json object{{"file", image.file},
                {"stem", image.stem},
                {"width_px", image.width_px},
                {"height_px", image.height_px},
                {"concentration", number(image.concentration)},
                {"mean_p_ice", number(image.mean_p_ice)},
                {"unknown_share", image.unknown_share},
                {"segment_s", image.segment_s},
                {"score", image.score ? score_json(*image.score) : json()}};
    object.update(findings_json(image.findings));
    if (!image.truth_fault.empty()) object["truth_fault"] = image.truth_fault;
    images.push_back(std::move(object));
    if (std::isnan(image.concentration)) continue;
    concentration += image.concentration;
    ++with_concentration;
  }
  for (const LeftOut& l : run.left_out)
    left_out.push_back({{"file", l.file}, {"reason", l.reason}});
  SegmentationParameters::describe(run.parameters, [&](const auto& value, const auto& info) {
    parameters[std::string(info.name)] = {
        {"value", value}, {"unit", info.unit}, {"help", info.help}};
  });
  json figures{
      {"images", run.images.size()},
      {"mean_concentration", with_concentration == 0
                                 ? json()
                                 : json(concentration / static_cast<double>(with_concentration))}};
  json out{{"watersky", versions.watersky},
           {"verb", "segment"},
           {"versions", {{"watersky", versions.watersky}, {"opencv", versions.opencv}}},
           {"method", name_of(run.method)},
           {"model", run.model_name().empty() ? json() : json(run.model_name())},
           {"ice", name_of(run.ice)},
           {"pond_is", run.pond_is_ice ? "ice" : "water"},
           {"sequence", run.sequence},
           {"flight", run.flight ? findings_json(*run.flight) : json()},
           {"mask", run.mask.empty() ? json() : json(run.mask)},
           {"truth", run.truth.empty() ? json() : json(run.truth)},
           {"parameters", parameters},
           {"unknown_is", kUnknownProbability},
           {"images", images},
           {"left_out", left_out}};
  if (!run.truth.empty()) {
    const MeanSegmentationScore mean = mean_score(run.scores());
    figures["scored_images"] = mean.images;
    if (mean.images > 0) {
      figures["accuracy"] = mean.accuracy;
      figures["worst_accuracy"] = mean.worst_accuracy;
      figures["iou"] = mean.iou;
      figures["worst_iou"] = mean.worst_iou;
      figures["concentration_error"] = number(mean.concentration_error);
      figures["brier"] = mean.brier;
      figures["expected_calibration_error"] = number(mean.pooled_calibration_error);
      figures["mean_image_calibration_error"] = number(mean.calibration_error);
      figures["p_ice_if_ice"] = number(mean.p_ice_if_ice);
      figures["p_ice_if_water"] = number(mean.p_ice_if_water);
      out["reliability"] = reliability_json(mean.reliability);
    }
  }
  out["figures"] = figures;
  return out;
}

std::string segmentation_csv(const SegmentationRun& run) {
  const auto quoted = [](const std::string& text) {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + "\"";
  };
  const auto cell = [](double value) {
    if (!std::isfinite(value)) return std::string(",");
    char text[40];
    std::snprintf(text, sizeof text, ",%.6g", value);
    return std::string(text);
  };
  std::string csv =
      "file,stem,width_px,height_px,concentration,mean_p_ice,unknown_share,ice_is,"
      "polarity_confidence,accuracy,iou,true_concentration,concentration_error,brier,"
      "expected_calibration_error,p_ice_if_ice,p_ice_if_water\n";
  for (const SegmentedImage& image : run.images) {
    const auto& polarity = image.findings.polarity;
    csv += quoted(image.file) + "," + quoted(image.stem) + "," + std::to_string(image.width_px) +
           "," + std::to_string(image.height_px) + cell(image.concentration) +
           cell(image.mean_p_ice) + cell(image.unknown_share) + "," +
           (polarity ? std::string(name_of(polarity->polarity)) + cell(polarity->confidence)
                     : std::string(","));
    if (image.score) {
      const SegmentationScore& s = *image.score;
      for (const double value : {s.accuracy, s.iou, s.true_concentration, s.concentration_error(),
                                 s.brier, s.calibration_error(), s.p_ice_if_ice, s.p_ice_if_water})
        csv += cell(value);
    } else {
      csv += ",,,,,,,,";
    }
    csv += "\n";
  }
  return csv;
}

Status write_segmentation_summary(const fs::path& folder, const SegmentationRun& run) {
  WATERSKY_CHECK(write_file(folder / "segmentation.csv", segmentation_csv(run)));
  WATERSKY_CHECK(
      write_file(folder / "segment.json",
                 segment_json(run).dump(2, ' ', false, json::error_handler_t::replace) + "\n"));
  return write_file(folder / "report.html", segmentation_report_html(run));
}

Status check_segment_output(const fs::path& out, bool overwrite) {
  return detail::check_run_folder(out, "segment.json", "segment", overwrite);
}

}  // namespace watersky
