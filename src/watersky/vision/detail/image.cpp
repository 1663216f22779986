// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/image.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>

namespace watersky::detail {

namespace {
/// Mean difference between the highest and the lowest channel, of full scale, that is colour.
constexpr double kColourful = 0.015;
}  // namespace

Status check_image(const cv::Mat& image, const cv::Mat& valid) {
  if (image.empty()) return Error{ErrorCode::InvalidInput, "image is empty: nothing to segment"};
  if ((image.depth() != CV_8U && image.depth() != CV_16U) ||
      (image.channels() != 1 && image.channels() != 3))
    return Error{ErrorCode::Unsupported, "image is of type " + cv::typeToString(image.type()) +
                                             "; give 8 or 16 bit with 1 or 3 channels"};
  if (!valid.empty() && (valid.type() != CV_8UC1 || valid.size() != image.size()))
    return Error{ErrorCode::InvalidInput,
                 "validity mask is " + std::to_string(valid.cols) + "x" +
                     std::to_string(valid.rows) + " " + cv::typeToString(valid.type()) +
                     " for an image of " + std::to_string(image.cols) + "x" +
                     std::to_string(image.rows) + "; give CV_8UC1 of the same size"};
  return {};
}

cv::Mat luminance(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

bool colourful(const cv::Mat& image) {
  if (image.channels() != 3) return false;
  const double full_scale = image.depth() == CV_8U ? 255.0 : 65535.0;
  cv::Mat small;
  cv::resize(image, small, cv::Size(64, 64), 0, 0, cv::INTER_NEAREST);
  small.convertTo(small, CV_32FC3);
  double sum = 0.0;
  for (const auto& p : cv::Mat_<cv::Vec3f>(small))
    sum += std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]});
  return sum / (64.0 * 64.0) > kColourful * full_scale;
}

cv::Mat to_8_bit(const cv::Mat& gray, double low, double high) {
  if (gray.depth() == CV_8U) return gray;
  const double scale = high > low ? 255.0 / (high - low) : 1.0;
  cv::Mat out;
  gray.convertTo(out, CV_8U, scale, -scale * low);
  return out;
}

}  // namespace watersky::detail
