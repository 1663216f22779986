// SPDX-License-Identifier: MIT
/// How long it takes to find the pieces of ice in a map.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "watersky/ice/objects.hpp"

int main() {
  using namespace watersky;
  cv::setNumThreads(1);
  // Floes of a power-law size distribution, and the speckle of an uncertain map.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(0, 1);
  cv::Mat p(4000, 4000, CV_32F, cv::Scalar(0.1));
  for (int i = 0; i < 8000; ++i)
    cv::circle(p, {static_cast<int>(4000 * u(random)), static_cast<int>(4000 * u(random))},
               static_cast<int>(3 / std::sqrt(1 - 0.999 * u(random))), cv::Scalar(0.9), cv::FILLED);
  cv::Mat noise(p.size(), CV_32F);
  cv::theRNG().state = 1;
  cv::randn(noise, 0, 0.15);
  cv::GaussianBlur(noise, noise, {3, 3}, 0);
  p += noise;
  cv::Mat looks(p.size(), CV_16U, cv::Scalar(3));
  cv::Mat seen(p.size(), CV_64F, cv::Scalar(1e9));
  double best_s = 1e9;
  std::size_t count = 0;
  for (int run = 0; run < 3; ++run) {
    const auto start = std::chrono::steady_clock::now();
    count = ice::find_objects({p, looks, seen}, 0.5).size();
    best_s = std::min(
        best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::printf("{\"name\":\"ice_objects.4000x4000.time\",\"value\":%.4f,\"unit\":\"s\"}\n", best_s);
  std::printf("{\"name\":\"ice_objects.4000x4000.objects\",\"value\":%zu,\"unit\":\"1\"}\n", count);
  return 0;
}
