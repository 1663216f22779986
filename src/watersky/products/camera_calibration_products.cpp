// SPDX-License-Identifier: MIT
#include "watersky/products/camera_calibration_products.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/io/files.hpp"
#include "watersky/products/detail/run_folder.hpp"
#include "watersky/products/detail/versions.hpp"
#include "watersky/products/palette.hpp"
#include "watersky/products/segmentation_pictures.hpp"

namespace watersky {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// JSON has no NaN: null.
json number(double value) { return std::isfinite(value) ? json(value) : json(); }

json view_json(const CalibrationView& view, double spacing) {
  json object{{"file", view.name},
              {"used", view.used},
              {"reason", view.reason.empty() ? json() : json(view.reason)},
              {"rms_px", number(view.rms_px)},
              {"tilt_deg", number(view.tilt_deg)},
              {"distance", number(view.distance * spacing)},
              {"camera_from_target", nullptr},
              {"points", json::array()}};
  if (!view.target) return object;
  const DetectedTarget& target = *view.target;
  object["size"] = to_string(target.size);
  object["edge_width_px"] = number(target.edge_width_px);
  object["contrast"] = number(target.contrast);
  if (target.kind != TargetKind::Chessboard) {
    object["circles_are"] = target.bright ? "brighter" : "darker";
    object["circle_radius"] = number(target.radius * spacing);
  }
  if (view.camera_from_target) {
    json rows = json::array();
    for (int i = 0; i < 3; ++i) {
      json row = json::array();
      for (int k = 0; k < 4; ++k)
        row.push_back((*view.camera_from_target)(i, k) * (k == 3 ? spacing : 1.0));
      rows.push_back(std::move(row));
    }
    object["camera_from_target"] = std::move(rows);
  }
  for (std::size_t i = 0; i < target.points.size(); ++i) {
    const TargetPoint& p = target.points[i];
    const bool posed = i < view.residuals.size();
    object["points"].push_back(
        {{"target", {p.on_target.x() * spacing, p.on_target.y() * spacing}},
         {"pixel", {p.seen.u, p.seen.v}},
         {"residual_px",
          posed ? json{number(view.residuals[i].x()), number(view.residuals[i].y())} : json()},
         {"used", view.used && !view.left_out[i]}});
  }
  return object;
}

}  // namespace

std::string view_jpeg(const cv::Mat& image, const CalibrationView& view) {
  constexpr double kWidth_px = 480;
  cv::Mat picture = displayed(image);
  double low = 0, high = 255;
  if (image.depth() == CV_8U) {  // a thermal picture of a few levels is stretched too
    cv::Mat gray;
    cv::cvtColor(picture, gray, cv::COLOR_BGR2GRAY);
    cv::minMaxLoc(gray, &low, &high);
    if (high > low && high - low < 128)
      picture.convertTo(picture, CV_8U, 255 / (high - low), -low * 255 / (high - low));
  }
  const double scale = std::min(1.0, kWidth_px / picture.cols);
  if (scale < 1) cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  constexpr int kShift = 4;
  const auto color = [](const Rgb& c) { return cv::Scalar(c.blue, c.green, c.red); };
  for (std::size_t i = 0; view.target && i < view.target->points.size(); ++i) {
    const Pixel& p = view.target->points[i].seen;
    const cv::Point at(static_cast<int>(std::lround(((p.u + 0.5) * scale - 0.5) * (1 << kShift))),
                       static_cast<int>(std::lround(((p.v + 0.5) * scale - 0.5) * (1 << kShift))));
    if (view.used && !view.left_out[i]) {
      cv::circle(picture, at, 3 << kShift, {255, 255, 255}, 2, cv::LINE_AA, kShift);
      cv::circle(picture, at, 3 << kShift, color(kFloeColor), 1, cv::LINE_AA, kShift);
    } else {
      const cv::Point a(4 << kShift, 4 << kShift), b(4 << kShift, -(4 << kShift));
      for (const cv::Point& arm : {a, b})
        cv::line(picture, at - arm, at + arm, color(kTrackColor), 2, cv::LINE_AA, kShift);
    }
  }
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 80})) return {};
  return {bytes.begin(), bytes.end()};
}

json camera_calibration_json(const CameraCalibrationRun& run) {
  const TargetCalibration& c = run.calibration;
  const detail::Versions versions = detail::versions();
  const double spacing = run.spacing_m.value_or(1.0);
  json matrix = json::array(), parameters = json::array(), covariance = json::array(),
       candidates = json::array(), views = json::array(), left_out = json::array(),
       settings = json::object();
  for (int i = 0; i < 9; ++i) matrix.push_back(c.camera.camera_matrix()(i / 3, i % 3));
  for (const EstimatedParameter& p : c.parameters)
    parameters.push_back({{"name", p.name},
                          {"value", p.value},
                          {"sigma", p.estimated ? number(p.sigma) : json()},
                          {"estimated", p.estimated}});
  for (Eigen::Index i = 0; i < c.covariance.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index k = 0; k < c.covariance.cols(); ++k)
      row.push_back(number(c.covariance(i, k)));
    covariance.push_back(std::move(row));
  }
  std::string name;
  for (const LensCandidate& l : c.candidates) {
    if (l.chosen) name = l.name;
    candidates.push_back({{"name", l.name},
                          {"parameters", l.parameters},
                          {"rms_px", number(l.rms_px)},
                          {"left_out_rms_px", number(l.left_out_rms_px)},
                          {"worse_by_sigmas", number(l.worse_by_sigmas)},
                          {"folds_unseen", l.folds_unseen},
                          {"fault", l.fault.empty() ? json() : json(l.fault)},
                          {"chosen", l.chosen}});
  }
  for (const CalibrationView& view : c.views) {
    views.push_back(view_json(view, spacing));
    if (!view.used) left_out.push_back({{"file", view.name}, {"reason", view.reason}});
  }
  CalibrationParameters::describe(run.parameters, [&](const auto& value, const auto& info) {
    settings[std::string(info.name)] = {{"value", value}, {"unit", info.unit}, {"help", info.help}};
  });
  return {{"watersky", versions.watersky},
          {"verb", "calibrate camera"},
          {"versions", {{"watersky", versions.watersky}, {"opencv", versions.opencv}}},
          {"target",
           {{"kind", name_of(c.kind)},
            {"size", to_string(c.size)},
            {"size_was_found", c.size_was_found},
            {"spacing_m", run.spacing_m ? json(*run.spacing_m) : json()}}},
          {"lengths_are_in", run.spacing_m ? "m" : "spacings of the target"},
          {"image_width", c.camera.width_px()},
          {"image_height", c.camera.height_px()},
          {"camera_model", c.camera.lens() == LensModel::Fisheye ? "fisheye" : "pinhole"},
          {"lens", name},
          {"camera_matrix", matrix},
          {"distortion_coefficients", c.camera.distortion()},
          {"intrinsics", parameters},
          {"covariance", covariance},
          {"rms_px", c.rms_px},
          {"sigma_px", c.sigma_px},
          {"points", c.points},
          {"pixel_sigma_px",
           {{"middle", number(c.middle_sigma_px)}, {"corners", number(c.corner_sigma_px)}}},
          {"coverage",
           {{"columns", c.coverage.columns},
            {"rows", c.coverage.rows},
            {"points", c.coverage.points},
            {"share", c.coverage.share},
            {"radius_share", c.coverage.radius_share}}},
          {"tilt_spread_deg", c.tilt_spread_deg},
          {"lens_models", candidates},
          {"frames", {{"total", c.views.size()}, {"used", c.used_views()}, {"left_out", left_out}}},
          {"views", views},
          {"notes", c.notes},
          {"parameters", settings}};
}

Status write_camera_calibration(const fs::path& folder, const CameraCalibrationRun& run) {
  WATERSKY_CHECK(write_file(folder / "camera.yaml", format_calibration(run.calibration.camera)));
  WATERSKY_CHECK(write_file(
      folder / "calibration.json",
      camera_calibration_json(run).dump(2, ' ', false, json::error_handler_t::replace) + "\n"));
  return write_file(folder / "report.html", camera_calibration_report_html(run));
}

Status check_calibration_output(const fs::path& out, bool overwrite) {
  return detail::check_run_folder(out, "calibration.json", "calibrate camera", overwrite);
}

}  // namespace watersky
