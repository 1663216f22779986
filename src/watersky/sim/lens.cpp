// SPDX-License-Identifier: MIT
#include "watersky/sim/lens.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>

namespace watersky::sim {
namespace {

constexpr double kFarthestTangent = 20.0;  ///< 87° off axis: no pinhole image is wider

}  // namespace

Lens::Lens(const LensParameters& parameters)
    : p_(parameters),
      u0_(0.5 * (parameters.width_px - 1) + parameters.centre_right_px),
      v0_(0.5 * (parameters.height_px - 1) + parameters.centre_down_px),
      limit_(parameters.fisheye ? std::numbers::pi : kFarthestTangent) {
  // Walk outwards to where the radius no longer grows.
  constexpr int kSteps = 20000;
  const double farthest = limit_;
  for (int i = 1; i <= kSteps; ++i) {
    const double x = farthest * i / kSteps;
    double slope = 1.0;
    if (p_.fisheye) {
      (void)fisheye_radius(x, &slope);
    } else {
      const double r2 = x * x;
      const double top = 1 + r2 * (p_.k1 + r2 * (p_.k2 + r2 * p_.k3));
      const double bottom = 1 + r2 * (p_.k4 + r2 * (p_.k5 + r2 * p_.k6));
      const double top_slope = p_.k1 + r2 * (2 * p_.k2 + r2 * 3 * p_.k3);
      const double bottom_slope = p_.k4 + r2 * (2 * p_.k5 + r2 * 3 * p_.k6);
      slope = bottom > 0 ? top / bottom + 2 * r2 * (top_slope * bottom - top * bottom_slope) /
                                              (bottom * bottom)
                         : -1.0;
    }
    if (!(slope > 0.0)) {
      limit_ = farthest * (i - 1) / kSteps;
      break;
    }
  }
}

Eigen::Vector2d Lens::distorted(const Eigen::Vector2d& p, Eigen::Matrix2d* slope) const {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double top = 1 + r2 * (p_.k1 + r2 * (p_.k2 + r2 * p_.k3));
  const double bottom = 1 + r2 * (p_.k4 + r2 * (p_.k5 + r2 * p_.k6));
  const double g = top / bottom;
  if (slope) {
    const double dg = ((p_.k1 + r2 * (2 * p_.k2 + r2 * 3 * p_.k3)) -
                       g * (p_.k4 + r2 * (2 * p_.k5 + r2 * 3 * p_.k6))) /
                      bottom;  // by r²
    *slope << g + 2 * x * x * dg + 2 * p_.p1 * y + 6 * p_.p2 * x,
        2 * x * y * dg + 2 * p_.p1 * x + 2 * p_.p2 * y,
        2 * x * y * dg + 2 * p_.p1 * x + 2 * p_.p2 * y,
        g + 2 * y * y * dg + 6 * p_.p1 * y + 2 * p_.p2 * x;
  }
  return {x * g + 2 * p_.p1 * x * y + p_.p2 * (r2 + 2 * x * x),
          y * g + p_.p1 * (r2 + 2 * y * y) + 2 * p_.p2 * x * y};
}

double Lens::fisheye_radius(double angle, double* slope) const {
  const double a2 = angle * angle;
  if (slope) *slope = 1 + a2 * (3 * p_.k1 + a2 * (5 * p_.k2 + a2 * (7 * p_.k3 + a2 * 9 * p_.k4)));
  return angle * (1 + a2 * (p_.k1 + a2 * (p_.k2 + a2 * (p_.k3 + a2 * p_.k4))));
}

std::optional<Eigen::Vector2d> Lens::pixel(const Eigen::Vector3d& d) const {
  Eigen::Vector2d image;
  if (p_.fisheye) {
    const double aside = std::hypot(d.x(), d.y());
    const double angle = std::atan2(aside, d.z());
    if (!(angle <= limit_)) return std::nullopt;
    const double scale = aside > 0.0 ? fisheye_radius(angle, nullptr) / aside : 0.0;
    image = scale * d.head<2>();
  } else {
    if (!(d.z() > 0.0)) return std::nullopt;
    const Eigen::Vector2d p = d.head<2>() / d.z();
    if (!(p.norm() <= limit_)) return std::nullopt;
    image = distorted(p, nullptr);
  }
  return Eigen::Vector2d(p_.focal_px * image.x() + u0_, p_.focal_px * image.y() + v0_);
}

std::optional<Eigen::Vector3d> Lens::direction(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d image((pixel.x() - u0_) / p_.focal_px, (pixel.y() - v0_) / p_.focal_px);
  if (p_.fisheye) {
    const double radius = image.norm();
    if (radius == 0.0) return Eigen::Vector3d::UnitZ();
    if (radius > fisheye_radius(limit_, nullptr)) return std::nullopt;
    // The radius grows up to the limit, so the root is bracketed; bisection guards Newton.
    double low = 0.0, high = limit_, angle = std::min(radius, limit_);
    for (int i = 0; i < 100; ++i) {
      double slope = 1.0;
      const double error = fisheye_radius(angle, &slope) - radius;
      if (std::abs(error) < 1e-14) break;
      (error > 0 ? high : low) = angle;
      const double next = angle - error / slope;
      angle = next > low && next < high ? next : 0.5 * (low + high);
    }
    const Eigen::Vector2d side = std::sin(angle) / radius * image;
    return Eigen::Vector3d(side.x(), side.y(), std::cos(angle));
  }
  // Damped Newton: the step is halved until it stays within the fold and comes nearer.
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  if (image.norm() < limit_) p = image;
  Eigen::Matrix2d slope;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d error = distorted(p, &slope) - image;
    if (error.norm() < 1e-13) break;
    const Eigen::Vector2d step = slope.inverse() * error;
    double part = 1.0;
    while (part > 1e-6 && !((p - part * step).norm() <= limit_ &&
                            (distorted(p - part * step, nullptr) - image).norm() < error.norm()))
      part *= 0.5;
    if (part <= 1e-6) break;
    p -= part * step;
  }
  if (!((distorted(p, nullptr) - image).norm() < 1e-12)) return std::nullopt;
  return Eigen::Vector3d(p.x(), p.y(), 1.0).normalized();
}

}  // namespace watersky::sim
