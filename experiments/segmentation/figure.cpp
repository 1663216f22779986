// SPDX-License-Identifier: MIT
#include <cpl_string.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "study.hpp"
#include "watersky/io/files.hpp"
#include "watersky/vision/otsu.hpp"

namespace watersky::study {

namespace {

constexpr int kPanel = 300, kGap = 16, kTitle = 30;

std::string png_uri(const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", picture, bytes)) return {};
  char* base64 = CPLBase64Encode(static_cast<int>(bytes.size()), bytes.data());
  std::string uri = std::string("data:image/png;base64,") + base64;
  CPLFree(base64);
  return uri;
}

std::string panel(int column, int row, const std::string& title, const std::string& inside) {
  return "<g transform=\"translate(" + std::to_string(kGap + column * (kPanel + kGap)) + " " +
         std::to_string(kTitle + row * (kPanel + kTitle + kGap)) + ")\"><text y=\"-8\">" + title +
         "</text>" + inside + "<rect width=\"" + std::to_string(kPanel) + "\" height=\"" +
         std::to_string(kPanel) + "\" fill=\"none\" stroke=\"#999\"/></g>\n";
}

std::string picture(const cv::Mat& image) {
  return "<image width=\"" + std::to_string(kPanel) + "\" height=\"" + std::to_string(kPanel) +
         "\" preserveAspectRatio=\"none\" href=\"" + png_uri(image) + "\"/>";
}

/// Levels of the image, of its ice and of its water by the truth, and the threshold.
std::string histogram(const cv::Mat& image, const cv::Mat& ice, int threshold) {
  std::array<int, 256> all{}, of_ice{};
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const unsigned char level = image.ptr(y)[x];
      ++all[level];
      of_ice[level] += ice.ptr(y)[x] ? 1 : 0;
    }
  const double most = *std::max_element(all.begin(), all.end());
  const auto x = [](double level) { return std::to_string(level * kPanel / 256.0); };
  const auto height = [&](int count) { return 0.94 * kPanel * count / most; };
  std::string bars;
  for (int i = 0; i < 256; ++i) {
    const double h = height(all[static_cast<std::size_t>(i)]);
    bars += "<rect x=\"" + x(i) + "\" y=\"" + std::to_string(kPanel - h) + "\" width=\"" + x(1.05) +
            "\" height=\"" + std::to_string(h) + "\" fill=\"#bcc7d1\"/>";
    const double of_it = height(of_ice[static_cast<std::size_t>(i)]);
    bars += "<rect x=\"" + x(i) + "\" y=\"" + std::to_string(kPanel - of_it) + "\" width=\"" +
            x(1.05) + "\" height=\"" + std::to_string(of_it) + "\" fill=\"#0072b2\"/>";
  }
  const std::string at = x(threshold + 1.0);
  return bars + "<path d=\"M" + at + " 0V" + std::to_string(kPanel) +
         "\" stroke=\"#d55e00\" stroke-width=\"2\"/><text x=\"" + at +
         "\" dx=\"6\" y=\"16\" fill=\"#d55e00\">Otsu: " + std::to_string(threshold) +
         "</text><text x=\"6\" y=\"16\" fill=\"#0072b2\">true ice</text>";
}

}  // namespace

Status write_figure_2_1(const std::filesystem::path& file, const LabelledImage& image) {
  cv::Mat gray = image.image;
  if (gray.depth() == CV_16U) cv::normalize(image.image, gray, 0, 255, cv::NORM_MINMAX, CV_8U);
  WATERSKY_TRY(const OtsuThreshold otsu, otsu_threshold(gray));
  cv::Mat ice = gray > otsu.level, closed;
  if (image.truth == IcePolarity::Darker) cv::bitwise_not(ice, ice);
  cv::morphologyEx(ice, closed, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(5, 5)));
  const cv::Mat truth = image.ice(PondIs::Water);
  const auto right = [&](const cv::Mat& found) {
    char text[40];
    std::snprintf(text, sizeof text, " (accuracy %.3f)",
                  1.0 - cv::countNonZero(found ^ truth) / static_cast<double>(truth.total()));
    return std::string(text);
  };
  // Ponds grey, between ice and water.
  cv::Mat classes = truth.clone();
  classes.setTo(128, image.classes == 0);
  const int width = 3 * kPanel + 4 * kGap, height = 2 * (kPanel + kTitle + kGap);
  const std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + std::to_string(width) + " " +
      std::to_string(height) + "\" width=\"" + std::to_string(width) +
      "\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"#fff\"/>\n" +
      panel(0, 0, "Image " + image.name, picture(gray)) +
      panel(1, 0, "Histogram", histogram(gray, truth, otsu.level)) +
      panel(2, 0, "Truth: ice white, ponds grey", picture(classes)) +
      panel(0, 1, "Otsu" + right(ice), picture(ice)) +
      panel(1, 1, "Closed, 5 px" + right(closed), picture(closed)) +
      panel(2, 1, "Wrong after closing", picture(closed ^ truth)) + "</svg>\n";
  return write_file(file, svg);
}

}  // namespace watersky::study
