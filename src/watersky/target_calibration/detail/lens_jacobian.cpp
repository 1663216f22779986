// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/detail/lens_jacobian.hpp"

#include <cmath>

namespace watersky::detail {

namespace {

bool project_pinhole(const Lens& lens, const Eigen::Vector3d& p, bool derivatives, Projection& to) {
  if (!(p.z() > 1e-9)) return false;
  const auto& a = lens.parameters;
  const double k1 = a[4], k2 = a[5], p1 = a[6], p2 = a[7], k3 = a[8], k4 = a[9], k5 = a[10],
               k6 = a[11];
  const double x = p.x() / p.z(), y = p.y() / p.z();
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double above = 1 + k1 * r2 + k2 * r4 + k3 * r6, below = 1 + k4 * r2 + k5 * r4 + k6 * r6;
  const double factor = above / below;
  const double xd = factor * x + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = factor * y + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  to.pixel = {a[0] * xd + a[2], a[1] * yd + a[3]};
  if (!derivatives) return to.pixel.allFinite();

  auto& j = to.by_lens;
  j.setZero();
  j(0, 0) = xd, j(1, 1) = yd, j(0, 2) = 1, j(1, 3) = 1;
  const auto radial = [&](int column, double by) {
    j(0, column) = a[0] * x * by;
    j(1, column) = a[1] * y * by;
  };
  radial(4, r2 / below), radial(5, r4 / below), radial(8, r6 / below);
  radial(9, -factor * r2 / below), radial(10, -factor * r4 / below);
  radial(11, -factor * r6 / below);
  j(0, 6) = a[0] * 2 * x * y, j(1, 6) = a[1] * (r2 + 2 * y * y);
  j(0, 7) = a[0] * (r2 + 2 * x * x), j(1, 7) = a[1] * 2 * x * y;

  const double slope =  // of the factor by r²
      (k1 + 2 * k2 * r2 + 3 * k3 * r4 - factor * (k4 + 2 * k5 * r2 + 3 * k6 * r4)) / below;
  Eigen::Matrix2d d;
  d(0, 0) = factor + 2 * slope * x * x + 2 * p1 * y + 6 * p2 * x;
  d(0, 1) = d(1, 0) = 2 * slope * x * y + 2 * p1 * x + 2 * p2 * y;
  d(1, 1) = factor + 2 * slope * y * y + 6 * p1 * y + 2 * p2 * x;
  Eigen::Matrix<double, 2, 3> flat;
  flat << 1, 0, -x, 0, 1, -y;
  to.by_point = Eigen::Vector2d(a[0], a[1]).asDiagonal() * d * (flat / p.z());
  return to.pixel.allFinite() && j.allFinite() && to.by_point.allFinite();
}

bool project_fisheye(const Lens& lens, const Eigen::Vector3d& p, bool derivatives, Projection& to) {
  const auto& a = lens.parameters;
  const double across = std::hypot(p.x(), p.y());
  const double theta = std::atan2(across, p.z()), t2 = theta * theta;
  const double bent = theta * (1 + t2 * (a[4] + t2 * (a[5] + t2 * (a[6] + t2 * a[7]))));
  // On the axis the direction across is arbitrary and its length nothing.
  const bool on_axis = !(across > 1e-12 * std::abs(p.z()));
  const double c = on_axis ? 1 : p.x() / across, s = on_axis ? 0 : p.y() / across;
  to.pixel = {a[0] * bent * c + a[2], a[1] * bent * s + a[3]};
  if (on_axis && !(p.z() > 0)) return false;
  if (!derivatives) return to.pixel.allFinite();

  auto& j = to.by_lens;
  j.setZero();
  j(0, 0) = bent * c, j(1, 1) = bent * s, j(0, 2) = 1, j(1, 3) = 1;
  double power = theta * t2;
  for (int k = 4; k < 8; ++k, power *= t2) j(0, k) = a[0] * c * power, j(1, k) = a[1] * s * power;

  const double slope = 1 + t2 * (3 * a[4] + t2 * (5 * a[5] + t2 * (7 * a[6] + t2 * 9 * a[7])));
  const double range2 = p.squaredNorm();
  const double turn = on_axis ? 1 / p.z() : bent / across;  // bent by the direction, per length
  Eigen::Matrix<double, 2, 3> d;
  const Eigen::RowVector3d by_theta(c * p.z() / range2, s * p.z() / range2, -across / range2);
  d.row(0) = slope * c * by_theta + turn * Eigen::RowVector3d(s * s, -s * c, 0);
  d.row(1) = slope * s * by_theta + turn * Eigen::RowVector3d(-s * c, c * c, 0);
  to.by_point = Eigen::Vector2d(a[0], a[1]).asDiagonal() * d;
  return to.pixel.allFinite() && j.allFinite() && to.by_point.allFinite();
}

}  // namespace

std::string_view parameter_name(LensModel model, int parameter) {
  constexpr std::array<std::string_view, kLensParameters> kPinhole{
      "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  constexpr std::array<std::string_view, 8> kFisheye{"fx", "fy", "cx", "cy",
                                                     "k1", "k2", "k3", "k4"};
  const auto i = static_cast<std::size_t>(parameter);
  return model == LensModel::Fisheye ? kFisheye.at(i) : kPinhole.at(i);
}

bool project(const Lens& lens, const Eigen::Vector3d& p_camera, bool derivatives,
             Projection& projection) {
  return lens.model == LensModel::Fisheye
             ? project_fisheye(lens, p_camera, derivatives, projection)
             : project_pinhole(lens, p_camera, derivatives, projection);
}

}  // namespace watersky::detail
