// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/polarity_cues.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "watersky/vision/polarity.hpp"

namespace watersky::detail {
namespace {

/// Fewer pixels of a class's inside say nothing about its surface.
constexpr int kLeastInside_px = 24;
/// Deviations below this part of the picture's spread are those of its gray levels.
constexpr double kLeastDeviation = 0.02;
constexpr float kMost = 3.0F;
constexpr double kMostBySurfaces = 1.0;

/// A class's surface, away from its edges.
struct Surface {
  bool known = false;
  double roughness = 0.0;  ///< mean deviation within 3x3
  double relief = 0.0;     ///< mean distance from the mean of 9x9
  double spread = 0.0;     ///< deviation of all its levels
};

Surface surface_of(const cv::Mat& members, const cv::Mat& n, const cv::Mat& rough,
                   const cv::Mat& relief) {
  Surface surface;
  cv::Mat inside;
  cv::erode(members, inside, cv::Mat::ones(3, 3, CV_8U));
  surface.known = cv::countNonZero(inside) >= kLeastInside_px;
  if (!surface.known) return surface;
  surface.roughness = cv::mean(rough, inside)[0];
  surface.relief = cv::mean(relief, inside)[0];
  cv::Scalar mean, deviation;
  cv::meanStdDev(n, mean, deviation, inside);
  surface.spread = deviation[0];
  return surface;
}

float log_ratio(double a, double b) {
  return static_cast<float>(std::log((a + kLeastDeviation) / (b + kLeastDeviation)));
}

}  // namespace

PolarityCues polarity_cues(const cv::Mat& level, const cv::Mat& valid,
                           const LevelStatistics& levels) {
  cv::Mat bright = level > levels.threshold, dark;
  cv::bitwise_not(bright, dark);
  if (!valid.empty()) {
    bright &= valid;
    dark &= valid;
  }
  PolarityCues cues{};
  if (cv::countNonZero(bright) == 0 || cv::countNonZero(dark) == 0) return cues;
  const ShapeEvidence shapes = shape_evidence(bright, valid);
  cues[0] = std::clamp(static_cast<float>(shapes.score / 0.03), -kMost, kMost);
  cues[1] = static_cast<float>(shapes.bright_solidity - shapes.dark_solidity);

  cv::Mat mean3, square3, relief;
  const cv::Mat n = (level - levels.mode) * levels.inverse_spread;
  cv::blur(n, mean3, {3, 3});
  cv::blur(n.mul(n), square3, {3, 3});
  cv::Mat rough = square3 - mean3.mul(mean3);
  cv::max(rough, 0.0, rough);
  cv::sqrt(rough, rough);
  cv::blur(n, relief, {9, 9});
  relief = cv::abs(n - relief);
  const Surface b = surface_of(bright, n, rough, relief), d = surface_of(dark, n, rough, relief);
  if (b.known && d.known) {
    cues[2] = log_ratio(b.roughness, d.roughness);
    cues[3] = log_ratio(b.relief, d.relief);
    cues[4] = log_ratio(b.spread, d.spread);
  }
  return cues;
}

PolarityLogOdds polarity_log_odds(const PolarityCues& cues, std::span<const float> weights) {
  PolarityLogOdds odds;
  const std::size_t n = std::min(cues.size(), weights.size());
  for (std::size_t i = 0; i < n; ++i)
    (i < kShapeCues ? odds.by_shapes : odds.by_surfaces) +=
        static_cast<double>(cues[i]) * static_cast<double>(weights[i]);
  odds.by_surfaces = std::clamp(odds.by_surfaces, -kMostBySurfaces, kMostBySurfaces);
  return odds;
}

std::array<float, kPolarityCues> fit_polarity(std::span<const PolarityExample> examples) {
  using Vector = Eigen::Matrix<double, kPolarityCues, 1>;
  using Matrix = Eigen::Matrix<double, kPolarityCues, kPolarityCues>;
  constexpr double kRidge = 1e-3;
  double total = 0.0;
  for (const auto& e : examples) total += e.weight;
  Vector w = Vector::Zero();
  for (const auto& [first, count] : {std::pair<Eigen::Index, Eigen::Index>{0, kShapeCues},
                                     {kShapeCues, kPolarityCues - kShapeCues}}) {
    // Newton's method; the problem is convex and settles in a few steps.
    for (int step = 0; step < 30 && total > 0.0; ++step) {
      Vector gradient = -kRidge * w;
      Matrix hessian = kRidge * Matrix::Identity();
      for (const auto& e : examples) {
        Vector x;
        for (std::size_t i = 0; i < kPolarityCues; ++i)
          x[static_cast<Eigen::Index>(i)] =
              (e.ice_brighter ? 1.0 : -1.0) * static_cast<double>(e.cues[i]);
        const double p = 1.0 / (1.0 + std::exp(-w.dot(x)));
        gradient += (e.weight / total) * (1.0 - p) * x;
        hessian += (e.weight / total) * p * (1.0 - p) * x * x.transpose();
      }
      w.segment(first, count) +=
          hessian.block(first, first, count, count).ldlt().solve(gradient.segment(first, count));
    }
  }
  std::array<float, kPolarityCues> weights{};
  for (std::size_t i = 0; i < kPolarityCues; ++i)
    weights[i] = static_cast<float>(w[static_cast<Eigen::Index>(i)]);
  return weights;
}

}  // namespace watersky::detail
