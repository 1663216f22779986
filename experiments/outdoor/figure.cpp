// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "study.hpp"
#include "watersky/io/files.hpp"

namespace watersky::study {

namespace {

constexpr int kSide = 340, kGap = 24, kTitle = 40, kBelow = 34;
const cv::Scalar kInk(40, 40, 40), kFaint(214, 214, 214), kDots(170, 110, 0), kMean(0, 94, 213);

void write(cv::Mat& picture, const std::string& text, const cv::Point& at, double scale) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, kInk, 1, cv::LINE_AA);
}

}  // namespace

Status write_error_clouds(const std::filesystem::path& file,
                          const std::vector<ErrorCloud>& clouds) {
  const int columns = static_cast<int>(clouds.size());
  cv::Mat picture(2 * kGap + kTitle + kSide + kBelow, kGap + columns * (kSide + kGap), CV_8UC3,
                  cv::Scalar::all(255));
  int column = 0;
  for (const ErrorCloud& cloud : clouds) {
    const int left = kGap + column++ * (kSide + kGap), top = kGap + kTitle;
    cv::Mat panel = picture(cv::Rect(left, top, kSide, kSide));
    const Accuracy accuracy = judge(cloud.looks);
    char text[96];
    // Each panel by its own scale, with rings that say which: 2.5 times the error fills it.
    const double ring_m =
        std::pow(10.0, std::round(std::log10(std::max(1e-3, accuracy.absolute_m))));
    const double pixels_per_m = 0.5 * kSide / std::max(1e-3, 2.5 * accuracy.absolute_m);
    const cv::Point middle(kSide / 2, kSide / 2);
    const auto at = [&](const Eigen::Vector2d& north_east) {
      return middle + cv::Point(static_cast<int>(std::lround(pixels_per_m * north_east.y())),
                                -static_cast<int>(std::lround(pixels_per_m * north_east.x())));
    };
    const auto rings = {0.5 * ring_m, ring_m, 2.0 * ring_m, 5.0 * ring_m};
    const auto radius_px = [&](double radius_m) {
      return static_cast<int>(std::lround(radius_m * pixels_per_m));
    };
    for (const double radius_m : rings)
      if (radius_px(radius_m) > 24 && radius_px(radius_m) < kSide)
        cv::circle(panel, middle, radius_px(radius_m), kFaint, 1, cv::LINE_AA);
    cv::line(panel, {0, middle.y}, {kSide, middle.y}, kFaint, 1);
    cv::line(panel, {middle.x, 0}, {middle.x, kSide}, kFaint, 1);
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    const std::size_t step = std::max<std::size_t>(1, cloud.looks.looks.size() / 4000);
    for (std::size_t i = 0; i < cloud.looks.looks.size(); ++i) {
      mean += cloud.looks.looks[i].error_m / static_cast<double>(cloud.looks.looks.size());
      if (i % step == 0)
        cv::circle(panel, at(cloud.looks.looks[i].error_m), 1, kDots, cv::FILLED, cv::LINE_AA);
    }
    for (const double radius_m : rings) {
      const int radius = radius_px(radius_m);
      if (radius <= 24 || radius >= kSide / 2 - 14) continue;
      std::snprintf(text, sizeof text, "%g m", radius_m);
      const cv::Point place = middle + cv::Point(4, radius - 5);
      cv::putText(panel, text, place, cv::FONT_HERSHEY_SIMPLEX, 0.42, cv::Scalar::all(255), 4,
                  cv::LINE_AA);
      write(panel, text, place, 0.42);
    }
    cv::drawMarker(panel, at(mean), kMean, cv::MARKER_CROSS, 18, 2, cv::LINE_AA);
    cv::rectangle(panel, {0, 0, kSide, kSide}, kInk, 1);
    write(picture, cloud.title, {left, top - 12}, 0.55);
    std::snprintf(text, sizeof text, "absolute %.2f m, sharpness %.2f m", accuracy.absolute_m,
                  accuracy.sharpness_m);
    write(picture, text, {left, top + kSide + 22}, 0.48);
  }
  write(picture, "Errors of ground points, north up; the cross is their mean", {kGap, kGap + 2},
        0.55);
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", picture, bytes))
    return Error{ErrorCode::Io, file.string() + ": cannot be encoded as PNG"};
  return write_file(file, std::string(bytes.begin(), bytes.end()));
}

}  // namespace watersky::study
