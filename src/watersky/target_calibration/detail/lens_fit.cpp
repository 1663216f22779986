// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/detail/lens_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

namespace watersky::detail {

namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle < 1e-15) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

TargetPose moved(const TargetPose& pose, const Vector6d& step) {
  return {rotation_of(step.head<3>()) * pose.rotation, pose.translation + step.tail<3>()};
}

Eigen::Vector3d point_of(const TargetPose& pose, const Eigen::Vector2d& on_target) {
  return pose.rotation.leftCols<2>() * on_target + pose.translation;
}

double cost_of(const FitView& view, const Lens& lens, const TargetPose& pose) {
  Projection projection;
  double sum = 0;
  for (const FitPoint& p : view) {
    if (!project(lens, point_of(pose, p.on_target), false, projection)) return kInfinity;
    sum += p.weight * (p.seen - projection.pixel).squaredNorm();
  }
  return std::isfinite(sum) ? sum : kInfinity;
}

double cost_of(std::span<const FitView> views, const Lens& lens,
               std::span<const TargetPose> poses) {
  double sum = 0;
  for (std::size_t v = 0; v < views.size(); ++v) sum += cost_of(views[v], lens, poses[v]);
  return sum;
}

/// The normal equations of one view, its pose's and the lens's.
struct ViewNormal {
  Eigen::MatrixXd lens_lens, pose_lens;
  Matrix6d pose_pose = Matrix6d::Zero();
  Eigen::VectorXd lens_right;
  Vector6d pose_right = Vector6d::Zero();
};

ViewNormal normal_of(const FitView& view, const Lens& lens, const TargetPose& pose,
                     const std::vector<int>& free) {
  const int n = static_cast<int>(free.size()), all = n + 6;
  // Plain sums: a few hundred thousand of them make one step.
  constexpr int kMost = kLensParameters + 6;
  double sums[kMost][kMost] = {}, right[kMost] = {};
  Projection at;
  for (const FitPoint& p : view) {
    const Eigen::Vector3d arm = pose.rotation.leftCols<2>() * p.on_target;
    if (!project(lens, arm + pose.translation, true, at)) continue;  // the cost was finite
    const Eigen::Vector2d off = p.seen - at.pixel;
    for (int axis = 0; axis < 2; ++axis) {
      double row[kMost];
      for (int i = 0; i < n; ++i) row[i] = at.by_lens(axis, free[static_cast<std::size_t>(i)]);
      const Eigen::Vector3d g = at.by_point.row(axis).transpose(), turn = arm.cross(g);
      for (int i = 0; i < 3; ++i) row[n + i] = turn[i], row[n + 3 + i] = g[i];
      for (int i = 0; i < all; ++i) {
        const double w = p.weight * row[i];
        for (int k = i; k < all; ++k) sums[i][k] += w * row[k];
        right[i] += w * off[axis];
      }
    }
  }
  ViewNormal normal;
  normal.lens_lens.resize(n, n);
  normal.pose_lens.resize(6, n);
  normal.lens_right.resize(n);
  for (int i = 0; i < all; ++i)
    for (int k = i; k < all; ++k) {
      if (k < n) normal.lens_lens(i, k) = normal.lens_lens(k, i) = sums[i][k];
      if (i < n && k >= n) normal.pose_lens(k - n, i) = sums[i][k];
      if (i >= n) normal.pose_pose(i - n, k - n) = normal.pose_pose(k - n, i - n) = sums[i][k];
    }
  for (int i = 0; i < n; ++i) normal.lens_right[i] = right[i];
  for (int i = 0; i < 6; ++i) normal.pose_right[i] = right[n + i];
  return normal;
}

/// Solves a symmetric positive system whose unknowns have units far apart; not finite if it cannot.
Eigen::MatrixXd solve_scaled(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::VectorXd scale = a.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(scale.asDiagonal() * a * scale.asDiagonal());
  if (ldlt.info() != Eigen::Success || !ldlt.isPositive() || ldlt.rcond() < 1e-14)
    return Eigen::MatrixXd::Constant(b.rows(), b.cols(), kInfinity);
  return scale.asDiagonal() * ldlt.solve(scale.asDiagonal() * b).eval();
}

/// The normal equations with the poses eliminated.
struct Reduced {
  std::vector<ViewNormal> views;
  std::vector<Matrix6d> pose_inverse;
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

Reduced reduced(std::span<const FitView> views, const LensFit& at, double damping) {
  const auto n = static_cast<Eigen::Index>(at.free.size());
  Reduced r;
  r.matrix = Eigen::MatrixXd::Zero(n, n);
  r.right = Eigen::VectorXd::Zero(n);
  for (std::size_t v = 0; v < views.size(); ++v) {
    ViewNormal normal = normal_of(views[v], at.lens, at.poses[v], at.free);
    normal.pose_pose.diagonal() *= 1 + damping;
    const Matrix6d inverse = solve_scaled(normal.pose_pose, Matrix6d::Identity());
    r.matrix += normal.lens_lens - normal.pose_lens.transpose() * inverse * normal.pose_lens;
    r.matrix.diagonal() += damping * normal.lens_lens.diagonal();
    r.right += normal.lens_right - normal.pose_lens.transpose() * inverse * normal.pose_right;
    r.views.push_back(std::move(normal));
    r.pose_inverse.push_back(inverse);
  }
  return r;
}

/// The pose of a plane from its homography to the undistorted image plane, z = 1.
std::optional<TargetPose> pose_of(const Eigen::Matrix3d& h) {
  const double scale = 2 / (h.col(0).norm() + h.col(1).norm());
  if (!std::isfinite(scale)) return std::nullopt;
  const double sign = h(2, 2) < 0 ? -scale : scale;
  Eigen::Matrix3d r;
  r.col(0) = sign * h.col(0);
  r.col(1) = sign * h.col(1);
  r.col(2) = r.col(0).cross(r.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
  if (turn.determinant() < 0) return std::nullopt;
  return TargetPose{turn, sign * h.col(2)};
}

/// The pose from a homography to where z = 1 would be seen without distortion. The distortion's
/// coefficients are turned back by a few fixed-point steps: enough for a start.
std::optional<TargetPose> start_pose(const FitView& view, const Lens& lens) {
  std::vector<cv::Point2d> target, plane;
  for (const FitPoint& p : view) {
    Eigen::Vector2d d((p.seen.x() - lens.parameters[2]) / lens.parameters[0],
                      (p.seen.y() - lens.parameters[3]) / lens.parameters[1]);
    double factor = 1;
    if (lens.model == LensModel::Fisheye) {
      const double bent = d.norm();
      double theta = bent;
      for (int i = 0; i < 8; ++i) {
        const double t2 = theta * theta;
        theta = bent / (1 + t2 * (lens.parameters[4] +
                                  t2 * (lens.parameters[5] +
                                        t2 * (lens.parameters[6] + t2 * lens.parameters[7]))));
      }
      if (!(theta > 0)) theta = bent;
      if (theta > 1.4) continue;  // 80°: farther out tan says little
      if (bent > 1e-9) factor = std::tan(theta) / bent;
    } else {
      Lens unit = lens;
      unit.parameters[0] = unit.parameters[1] = 1;
      unit.parameters[2] = unit.parameters[3] = 0;
      const Eigen::Vector2d seen = d;
      Projection at;
      for (int i = 0; i < 8; ++i) {
        if (!project(unit, {d.x(), d.y(), 1}, false, at)) break;
        const Eigen::Vector2d next = d + (seen - at.pixel);
        if (!next.allFinite() || next.norm() > 10) break;
        d = next;
      }
    }
    target.emplace_back(p.on_target.x(), p.on_target.y());
    plane.emplace_back(factor * d.x(), factor * d.y());
  }
  if (target.size() < 6 || 2 * target.size() < view.size()) return std::nullopt;
  const cv::Mat found = cv::findHomography(target, plane, 0);
  if (found.empty()) return std::nullopt;
  Eigen::Matrix3d h;
  cv::cv2eigen(found, h);
  return pose_of(h);
}

}  // namespace

std::optional<TargetPose> pose_under(const FitView& view, const Lens& lens) {
  return start_pose(view, lens);
}

std::optional<Eigen::Vector2d> residual(const Lens& lens, const TargetPose& pose,
                                        const FitPoint& point) {
  Projection at;
  if (!project(lens, point_of(pose, point.on_target), false, at)) return std::nullopt;
  return point.seen - at.pixel;
}

std::optional<LensFit> fit_lens(std::span<const FitView> views, const Lens& start,
                                std::span<const TargetPose> poses, const std::vector<int>& free,
                                bool with_covariance, int most_iterations) {
  LensFit fit;
  fit.lens = start;
  fit.free = free;
  fit.poses.assign(poses.begin(), poses.end());
  fit.cost = cost_of(views, fit.lens, fit.poses);
  if (!std::isfinite(fit.cost)) return std::nullopt;
  double damping = 1e-4;
  for (int i = 0; i < most_iterations; ++i) {
    const Reduced r = reduced(views, fit, damping);
    const Eigen::VectorXd lens_step = solve_scaled(r.matrix, r.right);
    LensFit next = fit;
    if (lens_step.allFinite()) {
      for (std::size_t k = 0; k < free.size(); ++k)
        next.lens.parameters[static_cast<std::size_t>(free[k])] +=
            lens_step[static_cast<Eigen::Index>(k)];
      for (std::size_t v = 0; v < views.size(); ++v) {
        const Vector6d step =
            r.pose_inverse[v] * (r.views[v].pose_right - r.views[v].pose_lens * lens_step);
        next.poses[v] = moved(fit.poses[v], step);
      }
      next.cost = next.lens.parameters[0] > 0 && next.lens.parameters[1] > 0
                      ? cost_of(views, next.lens, next.poses)
                      : kInfinity;
    } else {
      next.cost = kInfinity;
    }
    if (next.cost <= fit.cost) {
      const bool done = fit.cost - next.cost <= 1e-9 * fit.cost;
      fit = std::move(next);
      if (done) break;
      damping = std::max(1e-12, damping * 0.2);
    } else {
      damping *= 8;
      if (damping > 1e10) break;
    }
  }
  if (!with_covariance) return fit;
  const auto n = static_cast<Eigen::Index>(free.size());
  const Reduced r = reduced(views, fit, 0.0);
  fit.unit_covariance = solve_scaled(r.matrix, Eigen::MatrixXd::Identity(n, n));
  fit.clustered = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Eigen::VectorXd g = r.views[v].lens_right - r.views[v].pose_lens.transpose() *
                                                          r.pose_inverse[v] * r.views[v].pose_right;
    fit.clustered += g * g.transpose();
  }
  return fit;
}

std::optional<LensStart> start_lens(std::span<const FitView> views, LensModel model, int width_px,
                                    int height_px) {
  constexpr int kTries = 24;
  constexpr double kShortest = 0.2, kLongest = 8.0;  // of the longer side
  std::optional<LensStart> best;
  double best_score = kInfinity;
  for (int i = 0; i < kTries; ++i) {
    const double focal = std::max(width_px, height_px) * kShortest *
                         std::pow(kLongest / kShortest, i / (kTries - 1.0));
    LensStart now;
    now.lens.model = model;
    now.lens.parameters = {focal, focal, 0.5 * (width_px - 1), 0.5 * (height_px - 1)};
    std::vector<double> costs;
    for (const FitView& view : views) {
      now.poses.push_back(start_pose(view, now.lens));
      const double cost = now.poses.back() ? cost_of(view, now.lens, *now.poses.back()) : kInfinity;
      if (!std::isfinite(cost)) now.poses.back().reset();
      costs.push_back(cost / static_cast<double>(view.size()));
    }
    // Judged by the better half: views that are badly detected must not choose.
    std::sort(costs.begin(), costs.end());
    double score = 0;
    for (std::size_t k = 0; k < (costs.size() + 1) / 2; ++k) score += costs[k];
    if (score < best_score) best_score = score, best = std::move(now);
  }
  return best;
}

Eigen::Vector2d disc_offset(const Lens& lens, const TargetPose& pose, const Eigen::Vector2d& centre,
                            double radius) {
  constexpr int kSides = 24;
  Projection middle, rim;
  if (!(radius > 0) || !project(lens, point_of(pose, centre), false, middle))
    return Eigen::Vector2d::Zero();
  // The centroid of a polygon, about the middle.
  std::array<Eigen::Vector2d, kSides> corners;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    const Eigen::Vector2d on_rim =
        centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    if (!project(lens, point_of(pose, on_rim), false, rim)) return Eigen::Vector2d::Zero();
    corners[static_cast<std::size_t>(i)] = rim.pixel - middle.pixel;
  }
  double twice_area = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < kSides; ++i) {
    const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % kSides];
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice_area += cross;
    sum += cross * (a + b);
  }
  return std::abs(twice_area) > 0 ? Eigen::Vector2d(sum / (3 * twice_area))
                                  : Eigen::Vector2d::Zero();
}

}  // namespace watersky::detail
