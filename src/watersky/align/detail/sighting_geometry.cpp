// SPDX-License-Identifier: MIT
#include "watersky/align/detail/sighting_geometry.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace watersky::align {

std::optional<Eigen::Matrix3d> plane_homography(const ModelCamera& from, const ModelCamera& to) {
  const Eigen::Matrix3d rf = from.rotation.toRotationMatrix(), rt = to.rotation.toRotationMatrix();
  Eigen::Matrix3d middle = -from.position_m.z() * Eigen::Matrix3d::Identity();
  middle.col(2) += from.position_m - to.position_m;
  Eigen::Matrix3d h = rt.transpose() * middle * rf;
  if (!h.allFinite() || std::abs(h.determinant()) < 1e-12 * std::pow(h.norm(), 3))
    return std::nullopt;
  if (h(2, 2) < 0) h = -h;
  return h;
}

std::optional<Eigen::Matrix3d> SightingGeometry::expected(const ModelCamera& from,
                                                          const ModelCamera& to) const {
  const auto h = plane_homography(from, to);
  if (!h) return std::nullopt;
  return matrix_ * *h * matrix_inverse_;
}

std::optional<Tie> SightingGeometry::tie(const Eigen::Vector2d& host_px, const Eigen::Vector2d& px,
                                         const Eigen::Matrix2d& covariance_px2) const {
  const auto h = camera_.direction({host_px.x(), host_px.y()});
  const auto f = camera_.direction({px.x(), px.y()});
  if (!h || !f || !(h->v.z() > 0.05) || !(f->v.z() > 0.05)) return std::nullopt;
  Tie t;
  t.host = h->v.hnormalized();
  t.frame = f->v.hnormalized();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance_px2);
  t.whiten = axes.eigenvectors() *
             axes.eigenvalues().cwiseMax(1e-6).cwiseSqrt().cwiseInverse().asDiagonal() *
             axes.eigenvectors().transpose();
  const double rows = camera_.height_px();
  t.host_row = (host_px.y() + 0.5) / rows - 0.5;
  t.frame_row = (px.y() + 0.5) / rows - 0.5;
  return t;
}

Eigen::Matrix2d SightingGeometry::step_between(const Eigen::Matrix3d& plane,
                                               const Eigen::Vector2d& host_px) const {
  const auto d = camera_.direction({host_px.x(), host_px.y()});
  if (!d || !(d->v.z() > 0.05)) return Eigen::Matrix2d::Identity();
  const auto slope = [&](const Eigen::Vector2d& m) {
    constexpr double kStep = 1e-4;
    Eigen::Matrix2d j = matrix_.topLeftCorner<2, 2>();
    for (int k = 0; k < 2; ++k) {
      Eigen::Vector2d a = m, b = m;
      a[k] -= kStep;
      b[k] += kStep;
      const auto p = camera_.project(Vector<Camera>{a.homogeneous()});
      const auto q = camera_.project(Vector<Camera>{b.homogeneous()});
      if (p && q) j.col(k) = Eigen::Vector2d(q->u - p->u, q->v - p->v) / (2 * kStep);
    }
    return j;
  };
  const Eigen::Vector2d m = d->v.hnormalized();
  const Eigen::Vector3d q = plane * m.homogeneous();
  if (!(q.z() > 0)) return Eigen::Matrix2d::Identity();
  Eigen::Matrix2d by_plane;
  for (int k = 0; k < 2; ++k)
    by_plane.col(k) = (plane.col(k).head<2>() - q.hnormalized() * plane(2, k)) / q.z();
  return slope(q.hnormalized()) * by_plane * slope(m).inverse();
}

}  // namespace watersky::align
