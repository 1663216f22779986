// SPDX-License-Identifier: MIT
#include "watersky/camera/camera_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace watersky {

namespace {

constexpr double kWidestRadius = 20.0;  // 87° off axis

/// Radial factor of the pinhole model and the derivative of r·factor by r, at r².
struct Radial {
  double factor;
  double slope;  ///< d(r·factor)/dr
};

Radial pinhole_radial(const std::vector<double>& k, double r2) {
  const double num = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double den = 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  const double dnum = k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]);  // by r²
  const double dden = k[5] + r2 * (2 * k[6] + r2 * 3 * k[7]);
  const double f = num / den;
  return {f, f + 2 * r2 * (dnum * den - num * dden) / (den * den)};
}

double fisheye_angle(const std::vector<double>& k, double theta) {
  const double t2 = theta * theta;
  return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}
double fisheye_slope(const std::vector<double>& k, double theta) {
  const double t2 = theta * theta;
  return 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
}

/// The first r in (0, limit] where `grows(r)` is false, to 1e-9 of r; infinity if none.
template <class Grows>
double first_fold(double limit, const Grows& grows) {
  constexpr int kSteps = 4000;
  double before = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = limit * i / kSteps;
    if (!grows(r)) {
      double low = before, high = r;
      while (high - low > 1e-9 * high) {
        const double middle = 0.5 * (low + high);
        (grows(middle) ? low : high) = middle;
      }
      return low;
    }
    before = r;
  }
  return std::numeric_limits<double>::infinity();
}

/// Where a function that grows on [0, high], from below `wanted` to above it, takes the value
/// `wanted`: bisection brackets the place and Newton polishes it.
template <class Value, class Slope>
double solve_growing(double high, double wanted, const Value& value, const Slope& slope) {
  double low = 0;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (value(middle) < wanted ? low : high) = middle;
  }
  double x = 0.5 * (low + high);
  for (int i = 0; i < 20; ++i) {
    const double next = x - (value(x) - wanted) / slope(x);
    if (!(next >= low && next <= high)) {  // a flat slope near the fold: halve instead
      (value(x) < wanted ? low : high) = x;
      x = 0.5 * (low + high);
      continue;
    }
    const double step = std::abs(next - x);
    x = next;
    if (step < 1e-14) break;
  }
  return x;
}

struct Distorted {
  Eigen::Vector2d xy;
  Eigen::Matrix2d jacobian;
};

Distorted distort_pinhole(const std::vector<double>& k, const Eigen::Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  const Radial radial = pinhole_radial(k, r2);
  const double p1 = k[2], p2 = k[3];
  Distorted d;
  d.xy = radial.factor * p + Eigen::Vector2d(2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                                             p1 * (r2 + 2 * y * y) + 2 * p2 * x * y);
  // d(factor)/d(r²) = (slope - factor) / (2 r²); its limit at 0 is k1 - k4 (OpenCV's
  // order puts k4 sixth).
  const double df = r2 > 1e-16 ? (radial.slope - radial.factor) / (2 * r2) : k[0] - k[5];
  d.jacobian = radial.factor * Eigen::Matrix2d::Identity() + 2 * df * p * p.transpose();
  d.jacobian(0, 0) += 2 * p1 * y + 6 * p2 * x;
  d.jacobian(0, 1) += 2 * p1 * x + 2 * p2 * y;
  d.jacobian(1, 0) += 2 * p1 * x + 2 * p2 * y;
  d.jacobian(1, 1) += 6 * p1 * y + 2 * p2 * x;
  return d;
}

}  // namespace

Result<CameraModel> CameraModel::make(LensModel lens, int width_px, int height_px,
                                      const Eigen::Matrix3d& camera_matrix,
                                      std::vector<double> distortion) {
  const auto bad = [](std::string message) {
    return Error{ErrorCode::InvalidInput, std::move(message)};
  };
  if (width_px <= 0 || height_px <= 0 || width_px > 100000 || height_px > 100000)
    return bad("an image of " + std::to_string(width_px) + "x" + std::to_string(height_px) +
               " pixels (image_width, image_height) is not possible");
  if (!camera_matrix.allFinite() || camera_matrix(0, 0) <= 0 || camera_matrix(1, 1) <= 0)
    return bad("camera_matrix needs two positive focal lengths");
  if (camera_matrix(0, 1) != 0 || camera_matrix(1, 0) != 0 || camera_matrix(2, 0) != 0 ||
      camera_matrix(2, 1) != 0 || camera_matrix(2, 2) != 1)
    return bad("camera_matrix must have the form [fx 0 cx; 0 fy cy; 0 0 1]");
  for (const double k : distortion)
    if (!std::isfinite(k))
      return bad("distortion_coefficients holds something that is not a number");
  const std::size_t n = distortion.size();
  if (lens == LensModel::Pinhole && n != 0 && n != 4 && n != 5 && n != 8)
    return bad("distortion_coefficients holds " + std::to_string(n) +
               " numbers; the pinhole model takes 4, 5 or 8");
  if (lens == LensModel::Fisheye && n != 0 && n != 4)
    return bad("distortion_coefficients holds " + std::to_string(n) +
               " numbers; the fisheye model takes 4");

  CameraModel model;
  model.lens_ = lens;
  model.width_px_ = width_px;
  model.height_px_ = height_px;
  model.camera_matrix_ = camera_matrix;
  model.distortion_ = std::move(distortion);
  model.distortion_.resize(lens == LensModel::Pinhole ? 8 : 4, 0.0);
  model.distorts_ = lens == LensModel::Fisheye;
  for (const double k : model.distortion_) model.distorts_ |= k != 0.0;

  const auto& k = model.distortion_;
  if (lens == LensModel::Fisheye) {
    model.max_radius_ =
        std::min(std::numbers::pi,
                 first_fold(std::numbers::pi, [&](double t) { return fisheye_slope(k, t) > 0; }));
  } else if (model.distorts_) {
    // Also a lens that folds nowhere up to here is cut: what a polynomial says so close to a
    // right angle is not about the lens, and farther out it may still come back as a ghost.
    model.max_radius_ = std::min(kWidestRadius, first_fold(kWidestRadius, [&](double r) {
                                   const Radial radial = pinhole_radial(k, r * r);
                                   return radial.slope > 0 && radial.factor > 0;
                                 }));
  } else {
    model.max_radius_ = std::numeric_limits<double>::infinity();
  }
  return model;
}

std::optional<Pixel> CameraModel::project(const Vector<Camera>& direction) const {
  const Eigen::Vector3d& d = direction.v;
  if (!d.allFinite() || d.isZero(0)) return std::nullopt;
  Eigen::Vector2d xy;
  if (lens_ == LensModel::Fisheye) {
    const double across = std::hypot(d.x(), d.y());
    const double theta = std::atan2(across, d.z());
    if (!(theta < max_radius_)) return std::nullopt;
    xy = across > 0 ? Eigen::Vector2d(d.head<2>() * (fisheye_angle(distortion_, theta) / across))
                    : Eigen::Vector2d::Zero();
  } else {
    if (!(d.z() > 0)) return std::nullopt;
    xy = d.head<2>() / d.z();
    if (distorts_) {
      if (!(xy.squaredNorm() < max_radius_ * max_radius_)) return std::nullopt;
      xy = distort_pinhole(distortion_, xy).xy;
    }
  }
  return Pixel{camera_matrix_(0, 0) * xy.x() + camera_matrix_(0, 2),
               camera_matrix_(1, 1) * xy.y() + camera_matrix_(1, 2)};
}

std::optional<Vector<Camera>> CameraModel::direction(const Pixel& pixel) const {
  const Eigen::Vector2d target((pixel.u - camera_matrix_(0, 2)) / camera_matrix_(0, 0),
                               (pixel.v - camera_matrix_(1, 2)) / camera_matrix_(1, 1));
  if (!target.allFinite()) return std::nullopt;
  if (lens_ == LensModel::Fisheye) {
    const double wanted = target.norm();
    if (wanted == 0) return Vector<Camera>{Eigen::Vector3d::UnitZ()};
    if (!(wanted < fisheye_angle(distortion_, max_radius_))) return std::nullopt;
    const double theta = solve_growing(
        max_radius_, wanted, [&](double t) { return fisheye_angle(distortion_, t); },
        [&](double t) { return fisheye_slope(distortion_, t); });
    const Eigen::Vector2d across = target / wanted * std::sin(theta);
    return Vector<Camera>{{across.x(), across.y(), std::cos(theta)}};
  }

  Eigen::Vector2d p = target;
  if (distorts_) {
    // The radial part alone brings us close; the tangential one is small.
    const auto distorted = [&](double r) { return r * pinhole_radial(distortion_, r * r).factor; };
    const double wanted = target.norm(), limit = 0.999 * max_radius_;
    const double r =
        wanted < distorted(limit)
            ? solve_growing(limit, wanted, distorted,
                            [&](double x) { return pinhole_radial(distortion_, x * x).slope; })
            : limit;
    if (wanted > 0) p *= r / wanted;
    double error = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 60; ++i) {
      const Distorted d = distort_pinhole(distortion_, p);
      const Eigen::Vector2d residual = d.xy - target;
      error = residual.norm();
      if (error < 1e-15 * (1 + wanted)) break;
      Eigen::Vector2d step = d.jacobian.inverse() * residual;
      if (!step.allFinite()) return std::nullopt;
      // Halve until the residual shrinks, so that a wide lens cannot throw the iteration out.
      double damping = 1.0;
      Eigen::Vector2d next = p - step;
      while (damping > 1e-6 &&
             (!(next.norm() < max_radius_) ||
              !((distort_pinhole(distortion_, next).xy - target).norm() < error))) {
        damping *= 0.5;
        next = p - damping * step;
      }
      if (damping <= 1e-6) break;
      p = next;
    }
    if (!(error < 1e-12 * (1 + wanted))) return std::nullopt;
  }
  return Vector<Camera>{Eigen::Vector3d(p.x(), p.y(), 1.0).normalized()};
}

CameraModel CameraModel::scaled_to(int width_px, int height_px) const {
  return scaled(static_cast<double>(width_px) / width_px_,
                static_cast<double>(height_px) / height_px_, width_px, height_px);
}

CameraModel CameraModel::reduced_by(int n) const {
  WATERSKY_REQUIRE(n > 0);
  return scaled(1.0 / n, 1.0 / n, (width_px_ + n - 1) / n, (height_px_ + n - 1) / n);
}

CameraModel CameraModel::scaled(double su, double sv, int width_px, int height_px) const {
  CameraModel scaled = *this;
  scaled.width_px_ = width_px;
  scaled.height_px_ = height_px;
  scaled.camera_matrix_(0, 0) *= su;
  scaled.camera_matrix_(1, 1) *= sv;
  scaled.camera_matrix_(0, 2) = (camera_matrix_(0, 2) + 0.5) * su - 0.5;
  scaled.camera_matrix_(1, 2) = (camera_matrix_(1, 2) + 0.5) * sv - 0.5;
  return scaled;
}

CameraModel CameraModel::without_distortion() const {
  CameraModel plain = *this;
  plain.lens_ = LensModel::Pinhole;
  plain.distortion_.assign(8, 0.0);
  plain.distorts_ = false;
  plain.max_radius_ = std::numeric_limits<double>::infinity();
  return plain;
}

Undistorter::Undistorter(const CameraModel& camera) : undistorted_(camera.without_distortion()) {
  const int rows = camera.height_px(), cols = camera.width_px();
  map_u_.create(rows, cols, CV_32F);
  map_v_.create(rows, cols, CV_32F);
  valid_.create(rows, cols, CV_8U);
  const Eigen::Matrix3d& a = camera.camera_matrix();
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < cols; ++u) {
      const auto pixel =
          camera.project(Vector<Camera>{{(u - a(0, 2)) / a(0, 0), (v - a(1, 2)) / a(1, 1), 1.0}});
      // The slack forgives rounding: a straight lens must not lose its outermost pixels.
      constexpr double kSlack = 1e-6;
      const bool inside = pixel && pixel->u >= -kSlack && pixel->v >= -kSlack &&
                          pixel->u <= cols - 1 + kSlack && pixel->v <= rows - 1 + kSlack;
      map_u_.at<float>(v, u) =
          inside ? static_cast<float>(std::clamp(pixel->u, 0.0, cols - 1.0)) : -2.0F;
      map_v_.at<float>(v, u) =
          inside ? static_cast<float>(std::clamp(pixel->v, 0.0, rows - 1.0)) : -2.0F;
      valid_.at<uchar>(v, u) = inside ? 255 : 0;
    }
  }
}

void Undistorter::undistort(const cv::Mat& image, cv::Mat& undistorted, cv::Mat& valid) const {
  WATERSKY_REQUIRE(image.size() == map_u_.size());
  cv::remap(image, undistorted, map_u_, map_v_, cv::INTER_LINEAR, cv::BORDER_CONSTANT, 0);
  valid_.copyTo(valid);
}

}  // namespace watersky
