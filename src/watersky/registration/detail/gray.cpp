// SPDX-License-Identifier: MIT
#include "watersky/registration/detail/gray.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

namespace watersky::detail {

Status check_frame(const cv::Mat& image, const cv::Mat& valid) {
  if (image.empty()) return Error{ErrorCode::InvalidInput, "image is empty: nothing to register"};
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

cv::Mat gray_of(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

cv::Mat gray_8_bit(const cv::Mat& image) {
  const cv::Mat gray = gray_of(image);
  if (gray.depth() == CV_8U) return gray;
  double low = 0, high = 0;
  cv::minMaxLoc(gray, &low, &high);
  const double scale = high > low ? 255.0 / (high - low) : 1.0;
  cv::Mat out;
  gray.convertTo(out, CV_8U, scale, -scale * low);
  return out;
}

}  // namespace watersky::detail
