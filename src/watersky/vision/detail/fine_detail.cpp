// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/fine_detail.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "watersky/vision/detail/dispatch.hpp"
#include "watersky/vision/detail/enlarge.hpp"

namespace watersky::detail {
namespace {

/// Noise, in units of the picture's spread over four, at which half of a difference counts.
constexpr double kNoise = 0.25;
/// Every that many rows and columns are enough for a median.
constexpr int kNoiseRows = 16, kNoiseColumns = 3;

/// The camera's noise: from second differences along rows, whose median edges do not reach.
template <class Level>
double noise_sigma(const cv::Mat& gray) {
  std::vector<float> differences;
  for (int y = 0; y < gray.rows; y += kNoiseRows) {
    const Level* row = gray.ptr<Level>(y);
    for (int x = 1; x + 1 < gray.cols; x += kNoiseColumns)
      differences.push_back(std::abs(static_cast<float>(row[x - 1]) +
                                     static_cast<float>(row[x + 1]) -
                                     2.0F * static_cast<float>(row[x])));
  }
  if (differences.empty()) return 0.0;
  const auto middle = differences.begin() + static_cast<long>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return static_cast<double>(*middle) / (0.6745 * std::sqrt(6.0));
}

WATERSKY_MULTIVERSION void differences(const float* __restrict level, const float* __restrict half,
                                       float scale, int n, float* __restrict out) {
  for (int i = 0; i < n; ++i) out[i] = (level[i] - half[i]) * scale;
}

/// P times odds of exp(weight * detail), the exponential as (1 + x / 16)^16.
WATERSKY_MULTIVERSION void move_odds(const float* __restrict p, const float* __restrict detail,
                                     float weight, int n, float* __restrict out) {
  for (int i = 0; i < n; ++i) {
    float x = weight * detail[i];
    x = x > -5.0F ? x : -5.0F;
    x = x < 5.0F ? x : 5.0F;
    float e = 1.0F + x * (1.0F / 16.0F);
    e *= e;
    e *= e;
    e *= e;
    e *= e;
    const float ice = p[i] * e;
    out[i] = ice / (1.0F - p[i] + ice);
  }
}

WATERSKY_MULTIVERSION void widened(const unsigned char* __restrict in, int n,
                                   float* __restrict out) {
  for (int i = 0; i < n; ++i) out[i] = static_cast<float>(in[i]);
}
WATERSKY_MULTIVERSION void widened(const unsigned short* __restrict in, int n,
                                   float* __restrict out) {
  for (int i = 0; i < n; ++i) out[i] = static_cast<float>(in[i]);
}

}  // namespace

FineDetail::FineDetail(const cv::Mat& gray, const IceScene& scene, const LevelStatistics& levels)
    : half_(scene.half) {
  cv::GaussianBlur(gray, smooth_, {3, 3}, 0);
  const double sigma = gray.depth() == CV_8U    ? noise_sigma<unsigned char>(gray)
                       : gray.depth() == CV_16U ? noise_sigma<unsigned short>(gray)
                                                : noise_sigma<float>(gray);
  const double noise = sigma * static_cast<double>(levels.inverse_spread) / kNoise;
  scale_ = levels.sign * levels.inverse_spread / static_cast<float>(1.0 + noise * noise);
}

void FineDetail::row(const cv::Mat& p_half, int y, std::vector<float>& p,
                     std::vector<float>& detail) const {
  const auto width = 2 * static_cast<std::size_t>(half_.cols);
  const int cols = smooth_.cols;
  std::vector<float> between(width / 2), level(width), half(width);
  p.resize(width);
  detail.resize(width);
  enlarged_row(p_half, y, between.data(), p.data());
  enlarged_row(half_, y, between.data(), half.data());
  if (smooth_.depth() == CV_8U)
    widened(smooth_.ptr<unsigned char>(y), cols, level.data());
  else if (smooth_.depth() == CV_16U)
    widened(smooth_.ptr<unsigned short>(y), cols, level.data());
  else
    std::copy_n(smooth_.ptr<float>(y), cols, level.data());
  differences(level.data(), half.data(), scale_, cols, detail.data());
}

cv::Mat FineDetail::applied_to(const cv::Mat& p_half, float weight) const {
  cv::Mat p_ice(smooth_.size(), CV_32F);
  std::vector<float> p, detail;
  for (int y = 0; y < p_ice.rows; ++y) {
    row(p_half, y, p, detail);
    move_odds(p.data(), detail.data(), weight, p_ice.cols, p_ice.ptr<float>(y));
  }
  return p_ice;
}

float fit_detail_weight(std::span<const DetailSample> samples) {
  double w = 0.0;
  for (int step = 0; step < 20; ++step) {
    double gradient = 0.0, curvature = 1e-9;
    for (const DetailSample& s : samples) {
      const double offset = std::log(static_cast<double>(s.p) / (1.0 - static_cast<double>(s.p)));
      const auto x = static_cast<double>(s.detail);
      const double p = 1.0 / (1.0 + std::exp(-(offset + w * x)));
      gradient += (static_cast<double>(s.ice) - p) * x;
      curvature += p * (1.0 - p) * x * x;
    }
    w += std::clamp(gradient / curvature, -1.0, 1.0);
  }
  return static_cast<float>(std::max(0.0, w));
}

}  // namespace watersky::detail
