// SPDX-License-Identifier: MIT
#include "watersky/align/detail/patch.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace watersky::align {

namespace {

float bilinear(const cv::Mat& picture, double u, double v) {
  const int iu = static_cast<int>(u), iv = static_cast<int>(v);
  const auto fu = static_cast<float>(u - iu), fv = static_cast<float>(v - iv);
  const float* a = picture.ptr<float>(iv) + iu;
  const float* b = picture.ptr<float>(iv + 1) + iu;
  const float top = a[0] + fu * (a[1] - a[0]), bottom = b[0] + fu * (b[1] - b[0]);
  return top + fv * (bottom - top);
}

bool inside(const cv::Mat& picture, const Eigen::Vector2d& at, double margin) {
  return at.x() >= margin && at.y() >= margin && at.x() < picture.cols - 1 - margin &&
         at.y() < picture.rows - 1 - margin;
}

}  // namespace

std::optional<Patch> Patch::cut(const cv::Mat& picture, const Eigen::Vector2d& at, double noise) {
  if (!inside(picture, at, kHalf + 2)) return std::nullopt;
  constexpr std::size_t kPixels = static_cast<std::size_t>(kSide) * kSide;
  Patch patch;
  patch.values_.resize(kPixels);
  patch.gradient_u_.resize(kPixels);
  patch.gradient_v_.resize(kPixels);
  std::size_t i = 0;
  double sum = 0.0, sum_u = 0.0, sum_v = 0.0;
  for (int y = -kHalf; y <= kHalf; ++y)
    for (int x = -kHalf; x <= kHalf; ++x, ++i) {
      const double u = at.x() + x, v = at.y() + y;
      patch.values_[i] = bilinear(picture, u, v);
      patch.gradient_u_[i] = 0.5F * (bilinear(picture, u + 1, v) - bilinear(picture, u - 1, v));
      patch.gradient_v_[i] = 0.5F * (bilinear(picture, u, v + 1) - bilinear(picture, u, v - 1));
      sum += patch.values_[i];
      sum_u += patch.gradient_u_[i];
      sum_v += patch.gradient_v_[i];
    }
  const auto mean = static_cast<float>(sum / kPixels), mean_u = static_cast<float>(sum_u / kPixels),
             mean_v = static_cast<float>(sum_v / kPixels);
  double along_u = 0.0, along_v = 0.0;
  for (i = 0; i < kPixels; ++i) {
    patch.values_[i] -= mean;
    patch.energy_ += patch.values_[i] * patch.values_[i];
    along_u += patch.values_[i] * (patch.gradient_u_[i] - mean_u);
    along_v += patch.values_[i] * (patch.gradient_v_[i] - mean_v);
  }
  if (!(patch.energy_ > 0)) return std::nullopt;
  Eigen::Matrix2d products = Eigen::Matrix2d::Zero();
  for (i = 0; i < kPixels; ++i) {
    float& gu = patch.gradient_u_[i];
    float& gv = patch.gradient_v_[i];
    gu -= mean_u + static_cast<float>(along_u / patch.energy_) * patch.values_[i];
    gv -= mean_v + static_cast<float>(along_v / patch.energy_) * patch.values_[i];
    products(0, 0) += gu * gu;
    products(0, 1) += gu * gv;
    products(1, 1) += gv * gv;
  }
  products(1, 0) = products(0, 1);
  const double trace = products.trace(), determinant = products.determinant();
  const double least = 0.5 * (trace - std::sqrt(std::max(0.0, trace * trace - 4 * determinant)));
  // Known to a fifth of a pixel along its worse direction. A window of blurred noise alone has a
  // few times its variance.
  if (!(least > 30.0 * noise * noise)) return std::nullopt;
  patch.unit_covariance_ = products.inverse();
  return patch;
}

std::optional<Patch::Found> Patch::find(const cv::Mat& picture, const Eigen::Vector2d& start,
                                        const Eigen::Matrix2d& a, double most_px) const {
  constexpr int kMostSteps = 12;
  constexpr double kSettled_px = 0.01;
  const double reach =
      kHalf * (std::abs(a(0, 0)) + std::abs(a(0, 1)) + std::abs(a(1, 0)) + std::abs(a(1, 1))) + 1.0;
  Eigen::Vector2d at = start;
  std::array<float, static_cast<std::size_t>(kSide) * kSide> seen;
  Found found;
  for (int step = 0; step < kMostSteps; ++step) {
    if (!inside(picture, at, reach)) return std::nullopt;
    double sum = 0.0;
    std::size_t i = 0;
    for (int y = -kHalf; y <= kHalf; ++y)
      for (int x = -kHalf; x <= kHalf; ++x, ++i) {
        seen[i] = bilinear(picture, at.x() + a(0, 0) * x + a(0, 1) * y,
                           at.y() + a(1, 0) * x + a(1, 1) * y);
        sum += seen[i];
      }
    const auto mean = static_cast<float>(sum / static_cast<double>(seen.size()));
    double cross = 0.0, energy = 0.0, by_u = 0.0, by_v = 0.0;
    for (i = 0; i < seen.size(); ++i) {
      const float value = seen[i] - mean;
      cross += value * values_[i];
      energy += value * value;
      by_u += value * gradient_u_[i];
      by_v += value * gradient_v_[i];
    }
    const double gain = cross / energy_;
    if (!(gain > 0.05) || !(energy > 0)) return std::nullopt;
    found.correlation = cross / std::sqrt(energy * energy_);
    // The gradients are free of the values and of 1, so gain and offset drop out.
    const Eigen::Vector2d host_step = unit_covariance_ * Eigen::Vector2d(by_u, by_v) / gain;
    Eigen::Vector2d move = -(a * host_step);
    if (move.norm() > 1.5) move *= 1.5 / move.norm();
    at += move;
    if (!at.allFinite() || (at - start).norm() > most_px) return std::nullopt;
    if (move.norm() < kSettled_px) {
      found.at = at;
      return found;
    }
  }
  // Swinging by a few hundredths is as good as settled; more is lost.
  return std::nullopt;
}

double pixel_noise(const cv::Mat& picture) {
  // A second difference of white noise has sqrt(6) times its sigma; over an edge it is large, and
  // the median does not see it.
  std::vector<float> differences;
  const int step = std::max(1, picture.rows / 64);
  for (int v = 0; v < picture.rows; v += step) {
    const float* p = picture.ptr<float>(v);
    for (int u = 1; u + 1 < picture.cols; u += 3)
      differences.push_back(std::abs(p[u - 1] - 2 * p[u] + p[u + 1]));
  }
  if (differences.empty()) return 0.0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return 1.4826 * static_cast<double>(*middle) / std::sqrt(6.0);
}

}  // namespace watersky::align
