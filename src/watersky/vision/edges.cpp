// SPDX-License-Identifier: MIT
#include "watersky/vision/edges.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "watersky/vision/detail/image.hpp"
#include "watersky/vision/opencl.hpp"

namespace watersky {

namespace {
/// An edge goes on down to this part of the slope that begins it.
constexpr double kHysteresis = 0.4;
/// Sobel's 3x3 kernels give 8 times the slope; levels are taken times kScale, or the slopes of a
/// frame with little contrast would be rounded away.
constexpr double kSobel = 8.0;
constexpr double kScale = 16.0;
}  // namespace

EdgeSegmenter::EdgeSegmenter(const EdgeParameters& parameters, const TwoClassEvidence& evidence,
                             IcePolarity ice)
    : TwoClassSegmenter(evidence, ice), parameters_(parameters) {
  WATERSKY_REQUIRE(validate(parameters).ok());
}

cv::Mat EdgeSegmenter::bright(const Frame& frame) const {
  // In units of the contrast, so that a frame with twice the gain has the same edges.
  const double contrast = frame.bright - frame.dark;
  cv::Mat level, dx, dy, edges;
  frame.gray.convertTo(level, CV_32F, 1.0 / contrast, -frame.dark / contrast);
  if (!frame.valid.empty()) level.setTo(0.5, frame.valid == 0);
  // A hot pixel is no edge.
  level = cv::max(cv::min(level, 4.0), -3.0);
  constexpr double kUnit = kSobel * kScale * 16.0;
  smooth_and_derive(level, parameters_.sigma_px, kUnit / kSobel, dx, dy);
  dx.convertTo(dx, CV_16S);
  dy.convertTo(dy, CV_16S);
  const double high = parameters_.edge_contrast * kUnit;
  cv::Canny(dx, dy, edges, kHysteresis * high, high, true);
  if (parameters_.close_px > 1) {
    const int edge = parameters_.close_px | 1;
    cv::morphologyEx(edges, edges, cv::MORPH_CLOSE,
                     cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(edge, edge)));
  }
  cv::Mat between = edges == 0;
  if (!frame.valid.empty()) between.setTo(0, frame.valid == 0);

  // 4-connected: edges that touch by their corners hold.
  cv::Mat labels;
  const int count = cv::connectedComponents(between, labels, 4, CV_32S);
  struct Region {
    double sum = 0.0;
    int pixels = 0;
  };
  std::vector<Region> regions(static_cast<std::size_t>(count));
  for (int y = 0; y < labels.rows; ++y) {
    const int* label = labels.ptr<int>(y);
    const float* value = level.ptr<float>(y);
    for (int x = 0; x < labels.cols; ++x) {
      Region& region = regions[static_cast<std::size_t>(label[x])];
      region.sum += value[x];
      ++region.pixels;
    }
  }
  const double threshold =
      (frame.flight_threshold.value_or(frame.threshold) - frame.dark) / contrast;
  cv::Mat bright(level.size(), CV_8U);
  for (int y = 0; y < labels.rows; ++y) {
    const int* label = labels.ptr<int>(y);
    const float* value = level.ptr<float>(y);
    unsigned char* out = bright.ptr(y);
    for (int x = 0; x < labels.cols; ++x) {
      const Region& region = regions[static_cast<std::size_t>(label[x])];
      const bool own = label[x] == 0 || region.pixels < parameters_.least_region_px;
      out[x] = (own ? value[x] : region.sum / region.pixels) > threshold ? 255 : 0;
    }
  }
  return bright;
}

}  // namespace watersky
