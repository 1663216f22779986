// SPDX-License-Identifier: MIT
#include "watersky/vision/watershed.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "watersky/vision/opencl.hpp"

namespace watersky {

void flood_from_markers(const cv::Mat& relief, const cv::Mat& valid, cv::Mat& markers) {
  WATERSKY_REQUIRE(relief.type() == CV_8UC1 && markers.type() == CV_32SC1 &&
                   markers.size() == relief.size() && markers.isContinuous());
  // One first-in-first-out queue for each height: a pixel enters one of them once.
  std::array<std::vector<int>, 256> queues;
  std::array<std::size_t, 256> heads{};
  const int cols = relief.cols, rows = relief.rows;
  int* label = markers.ptr<int>();
  const auto height = [&](int at) { return relief.ptr(at / cols)[at % cols]; };
  const auto flooded = [&](int at) { return valid.empty() || valid.ptr(at / cols)[at % cols]; };
  for (int at = 0; at < rows * cols; ++at) {
    if (label[at] == 0) continue;
    if (!flooded(at)) {
      label[at] = 0;
      continue;
    }
    queues[height(at)].push_back(at);
  }
  std::size_t lowest = 0;
  while (lowest < queues.size()) {
    if (heads[lowest] == queues[lowest].size()) {
      ++lowest;
      continue;
    }
    const int at = queues[lowest][heads[lowest]++];
    const int x = at % cols, y = at / cols;
    const auto enter = [&](int next) {
      if (label[next] != 0 || !flooded(next)) return;
      label[next] = label[at];
      const std::size_t h = height(next);
      queues[h].push_back(next);
      lowest = std::min(lowest, h);
    };
    if (y > 0) enter(at - cols);
    if (x > 0) enter(at - 1);
    if (x + 1 < cols) enter(at + 1);
    if (y + 1 < rows) enter(at + cols);
  }
}

WatershedSegmenter::WatershedSegmenter(const WatershedParameters& parameters,
                                       const TwoClassEvidence& evidence, IcePolarity ice)
    : TwoClassSegmenter(evidence, ice), parameters_(parameters) {
  WATERSKY_REQUIRE(validate(parameters).ok());
}

cv::Mat WatershedSegmenter::bright(const Frame& frame) const {
  const double contrast = frame.bright - frame.dark;
  cv::Mat level, dx, dy, relief;
  frame.gray.convertTo(level, CV_32F, 1.0 / contrast, -frame.dark / contrast);
  if (!frame.valid.empty()) level.setTo(0.5, frame.valid == 0);
  level = cv::max(cv::min(level, 2.0), -1.0);
  smooth_and_derive(level, parameters_.sigma_px, 0.125, dx, dy);
  cv::magnitude(dx, dy, relief);
  // Half the contrast within a pixel is as steep as edges get.
  relief.convertTo(relief, CV_8U, 2.0 * 255.0);

  constexpr int kDark = 1, kBright = 2;
  cv::Mat markers(level.size(), CV_32S, cv::Scalar(0));
  markers.setTo(kDark, level < parameters_.marker_share);
  markers.setTo(kBright, level > 1.0 - parameters_.marker_share);
  flood_from_markers(relief, frame.valid, markers);
  return markers == kBright;
}

}  // namespace watersky
