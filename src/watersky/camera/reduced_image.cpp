// SPDX-License-Identifier: MIT
#include "watersky/camera/reduced_image.hpp"

#include <opencv2/imgproc.hpp>

#include "watersky/base/contract.hpp"

namespace watersky {

cv::Mat reduced_by(const cv::Mat& image, int n) {
  WATERSKY_REQUIRE(n > 0);
  if (n == 1) return image.clone();
  const cv::Size size((image.cols + n - 1) / n, (image.rows + n - 1) / n);
  cv::Mat whole, reduced;
  cv::copyMakeBorder(image, whole, 0, size.height * n - image.rows, 0, size.width * n - image.cols,
                     cv::BORDER_REPLICATE);
  cv::resize(whole, reduced, size, 0, 0, cv::INTER_AREA);
  return reduced;
}

}  // namespace watersky
