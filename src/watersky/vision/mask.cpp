// SPDX-License-Identifier: MIT
#include "watersky/vision/mask.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace watersky {

Result<cv::Mat> valid_from_mask(const cv::Mat& mask, cv::Size size) {
  const auto dimensions = [](cv::Size s) {
    return std::to_string(s.width) + "x" + std::to_string(s.height);
  };
  if (mask.empty() || size.empty()) return Error{ErrorCode::InvalidInput, "mask or image is empty"};
  if (mask.dims != 2 || mask.channels() > 4)
    return Error{ErrorCode::InvalidInput, "mask has " + std::to_string(mask.channels()) +
                                              " channels; give an image of one to four"};
  std::vector<cv::Mat> channels;
  cv::split(mask, channels);
  cv::Mat used = channels[0] != 0;
  for (std::size_t i = 1; i < channels.size(); ++i) used |= channels[i] != 0;

  const int reduction =
      std::max(1, std::max(cvRound(static_cast<double>(mask.cols) / size.width),
                           cvRound(static_cast<double>(mask.rows) / size.height)));
  const auto fits = [reduction](int full, int reduced) {
    return std::abs(reduced * reduction - full) < reduction;
  };
  if (!fits(mask.cols, size.width) || !fits(mask.rows, size.height))
    return Error{ErrorCode::InvalidInput, "mask is " + dimensions(mask.size()) +
                                              " pixels, the images are " + dimensions(size) +
                                              "; give it in the camera's full size"};
  cv::Mat valid = used;
  if (reduction > 1) {
    // Least of each block, then one of each block.
    cv::erode(used, used, cv::Mat::ones(reduction, reduction, CV_8U), {0, 0}, 1,
              cv::BORDER_CONSTANT, cv::Scalar(255));
    valid.create(size, CV_8U);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        valid.at<uchar>(y, x) = used.at<uchar>(std::min(y * reduction, mask.rows - 1),
                                               std::min(x * reduction, mask.cols - 1));
  }
  if (cv::countNonZero(valid) == 0)
    return Error{ErrorCode::InvalidInput,
                 "mask leaves nothing of the picture; 0 is what is not to be used"};
  return valid;
}

cv::Mat both_valid(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  cv::Mat both;
  cv::bitwise_and(a, b, both);
  return both;
}

}  // namespace watersky
