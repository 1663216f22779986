// SPDX-License-Identifier: MIT
#include "watersky/sim/outline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

bool segments_cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                    const Eigen::Vector2d& d) {
  const double ab_c = cross(b - a, c - a), ab_d = cross(b - a, d - a);
  const double cd_a = cross(d - c, a - c), cd_b = cross(d - c, b - c);
  return (ab_c > 0) != (ab_d > 0) && (cd_a > 0) != (cd_b > 0);
}

double point_to_segment_m(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                          const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double along = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (a + along * ab - p).norm();
}

/// Chaikin's corner cutting: each pass replaces a corner by two on its sides. New corners lie
/// between neighbours, so the order around an inner point is kept.
Outline cut_corners(const Outline& in, double keep) {
  Outline out;
  out.reserve(2 * in.size());
  for (std::size_t i = 0; i < in.size(); ++i) {
    const Eigen::Vector2d& a = in[i];
    const Eigen::Vector2d& b = in[(i + 1) % in.size()];
    out.push_back(a + (1.0 - keep) * (b - a));
    out.push_back(a + keep * (b - a));
  }
  return out;
}

Outline with_corners_every(const Outline& in, double spacing_m) {
  Outline out;
  for (std::size_t i = 0; i < in.size(); ++i) {
    const Eigen::Vector2d& a = in[i];
    const Eigen::Vector2d& b = in[(i + 1) % in.size()];
    const int parts = std::max(1, static_cast<int>(std::ceil((b - a).norm() / spacing_m)));
    for (int k = 0; k < parts; ++k) out.push_back(a + (b - a) * (static_cast<double>(k) / parts));
  }
  return out;
}

}  // namespace

double signed_area_m2(const Outline& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i)
    twice += cross(outline[i] - outline[0], outline[(i + 1) % outline.size()] - outline[0]);
  return 0.5 * twice;
}

Eigen::Vector2d centroid(const Outline& outline) {
  double twice = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d a = outline[i] - outline[0];
    const Eigen::Vector2d b = outline[(i + 1) % outline.size()] - outline[0];
    twice += cross(a, b);
    sum += cross(a, b) * (a + b);
  }
  return outline[0] + sum / (3.0 * twice);
}

double max_length_m(const Outline& outline) {
  double longest2 = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i)
    for (std::size_t j = i + 1; j < outline.size(); ++j)
      longest2 = std::max(longest2, (outline[i] - outline[j]).squaredNorm());
  return std::sqrt(longest2);
}

bool contains(const Outline& outline, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[j];
    if ((a.x() > p.x()) != (b.x() > p.x()) &&
        p.y() < a.y() + (b.y() - a.y()) * (p.x() - a.x()) / (b.x() - a.x()))
      inside = !inside;
  }
  return inside;
}

double distance_m(const Outline& a, const Outline& b) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector2d& a0 = a[i];
    const Eigen::Vector2d& a1 = a[(i + 1) % a.size()];
    for (std::size_t j = 0; j < b.size(); ++j) {
      const Eigen::Vector2d& b0 = b[j];
      const Eigen::Vector2d& b1 = b[(j + 1) % b.size()];
      if (segments_cross(a0, a1, b0, b1)) return 0.0;
      nearest = std::min({nearest, point_to_segment_m(a0, b0, b1), point_to_segment_m(b0, a0, a1)});
    }
  }
  return nearest;
}

bool is_simple(const Outline& outline) {
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;  // neighbours share a corner
      if (segments_cross(outline[i], outline[i + 1], outline[j], outline[(j + 1) % n]))
        return false;
    }
  return n >= 3;
}

Outline random_outline(Random& random, double diameter_m, const OutlineShape& shape) {
  const std::size_t corners = 5 + random.index(6);
  const double first = random.uniform(0.0, kTurn);
  Outline outline;
  for (std::size_t i = 0; i < corners; ++i) {
    const double step = kTurn / static_cast<double>(corners);
    const double angle = first + step * (static_cast<double>(i) + random.uniform(-0.33, 0.33));
    const double radius = std::clamp(1.0 + shape.angularity * random.normal(), 0.5, 1.6);
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  const double keep = random.uniform(0.72, 0.88);
  outline = cut_corners(cut_corners(outline, keep), 0.75);
  outline = with_corners_every(outline, std::max(2.0 * shape.corner_m / diameter_m, 0.02));

  double phase[3], amplitude[3], waves[3];
  for (int k = 0; k < 3; ++k) {
    phase[k] = random.uniform(0.0, kTurn);
    waves[k] = std::floor(random.uniform(5.0, 9.0) * std::pow(2.1, k));
    amplitude[k] = shape.roughness * random.uniform(0.5, 1.5) * std::pow(0.6, k);
  }
  for (Eigen::Vector2d& p : outline) {
    const double angle = std::atan2(p.y(), p.x());
    double factor = 1.0;
    for (int k = 0; k < 3; ++k) factor += amplitude[k] * std::sin(waves[k] * angle + phase[k]);
    p *= std::max(factor, 0.3);
  }

  // A stretch along a random axis is linear: it keeps the order around the middle.
  const double axis = random.uniform(0.0, kTurn);
  const double stretch = std::exp(std::clamp(shape.elongation * random.normal(), -0.4, 0.4));
  Eigen::Matrix2d turn;
  turn << std::cos(axis), -std::sin(axis), std::sin(axis), std::cos(axis);
  const Eigen::Matrix2d linear =
      turn * Eigen::Vector2d(stretch, 1.0 / stretch).asDiagonal() * turn.transpose();
  for (Eigen::Vector2d& p : outline) p = linear * p;

  const double area = std::abs(signed_area_m2(outline));
  const double scale = diameter_m * std::sqrt(0.25 * std::numbers::pi / area);
  const Eigen::Vector2d middle = centroid(outline);
  for (Eigen::Vector2d& p : outline) p = scale * (p - middle);
  return outline;
}

}  // namespace watersky::sim
