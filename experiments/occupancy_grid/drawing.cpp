// SPDX-License-Identifier: MIT
#include "drawing.hpp"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/io/files.hpp"
#include "watersky/sim/laboratory.hpp"

namespace watersky::study {

namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
/// Of a coordinate's fraction of a pixel, as OpenCV's drawing takes it.
constexpr int kShift = 4;

cv::Point fine(const Eigen::Vector2d& p) {
  return {static_cast<int>(std::lround(p.x() * (1 << kShift))),
          static_cast<int>(std::lround(p.y() * (1 << kShift)))};
}

}  // namespace

void write_text(cv::Mat& picture, const std::string& text, cv::Point at, double scale,
                const cv::Scalar& colour, Align align) {
  int below = 0;
  const cv::Size size = cv::getTextSize(text, kFont, scale, 1, &below);
  if (align == Align::Centre) at.x -= size.width / 2;
  if (align == Align::Right) at.x -= size.width;
  cv::putText(picture, text, at, kFont, scale, colour, 1, cv::LINE_AA);
}

void write_on_map(cv::Mat& picture, const std::string& text, cv::Point at, double scale,
                  const cv::Scalar& colour, Align align, int thickness) {
  int below = 0;
  const cv::Size size = cv::getTextSize(text, kFont, scale, thickness, &below);
  if (align == Align::Centre) at.x -= size.width / 2;
  if (align == Align::Right) at.x -= size.width;
  cv::putText(picture, text, at, kFont, scale, kPaper, thickness + 2, cv::LINE_AA);
  cv::putText(picture, text, at, kFont, scale, colour, thickness, cv::LINE_AA);
}

cv::Mat shaded(const cv::Mat& probability) {
  cv::Mat out(probability.size(), CV_8UC3);
  for (int v = 0; v < out.rows; ++v)
    for (int u = 0; u < out.cols; ++u) {
      const float p = probability.at<float>(v, u);
      const auto mix = [p](double water, double ice) {
        return cv::saturate_cast<unsigned char>(water + (ice - water) * static_cast<double>(p));
      };
      out.at<cv::Vec3b>(v, u) = std::isnan(p) ? cv::Vec3b(214, 211, 208)
                                              : cv::Vec3b(mix(92, 255), mix(62, 255), mix(34, 255));
    }
  return out;
}

void draw_truth(cv::Mat& picture, const sim::Simulation& recording, const RoomView& view) {
  const Datum& datum = recording.flight.datum;
  const auto& pieces = recording.truth.sea.pieces();
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    std::vector<cv::Point> line;
    for (const Eigen::Vector2d& corner : pieces[i]) {
      const Eigen::Vector2d p = room_from_scene(datum, corner);
      line.push_back(fine(view.pixel(p.x(), p.y())));
    }
    cv::polylines(picture, line, true, kTruth, 1, cv::LINE_AA, kShift);
    const sim::PaperPatch& patch = sim::kPaperPatches[i];
    const double reach_m = recording.truth.sea.objects()[i].max_length_m / 2;
    const Eigen::Vector2d beside = view.pixel(patch.x_m + reach_m, patch.y_m + reach_m);
    write_on_map(picture, std::to_string(patch.number),
                 {static_cast<int>(beside.x()) + 8, static_cast<int>(beside.y()) + 2}, 0.6, kTruth,
                 Align::Centre, 2);
  }
}

void draw_scale(cv::Mat& picture, const RoomView& view) {
  const cv::Size size = view.size();
  for (int x = static_cast<int>(std::ceil(view.x_from_m)); x < view.x_to_m; ++x) {
    const int u = static_cast<int>(std::lround(view.pixel(x, 0).x()));
    cv::line(picture, {u, size.height - 1}, {u, size.height - 9}, kInk, 1);
    write_on_map(picture, std::to_string(x) + " m", {u, size.height - 13}, 0.4, kInk,
                 Align::Centre);
  }
  for (int y = static_cast<int>(std::ceil(view.y_from_m + 0.1)); y < view.y_to_m; ++y) {
    const int v = static_cast<int>(std::lround(view.pixel(0, y).y()));
    cv::line(picture, {0, v}, {8, v}, kInk, 1);
    write_on_map(picture, std::to_string(y) + " m", {12, v + 4}, 0.4, kInk);
  }
  cv::rectangle(picture, {0, 0, picture.cols, picture.rows}, kInk, 1);
}

Status write_picture(const std::filesystem::path& file, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", picture, bytes))
    return Error{ErrorCode::Io, file.string() + ": cannot be encoded as PNG"};
  return write_file(file, std::string(bytes.begin(), bytes.end()));
}

}  // namespace watersky::study
