// SPDX-License-Identifier: MIT
#include "watersky/registration/homography.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <map>

namespace watersky {

namespace {

using Vector8 = Eigen::Matrix<double, 8, 1>;
using Matrix8 = Eigen::Matrix<double, 8, 8>;
using Jacobian = Eigen::Matrix<double, 2, 8>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kSteps = 6;
/// Patches for residuals that err alike: so many across the wider side of what the pairs cover.
constexpr double kPatchesAcross = 10.0;
constexpr std::size_t kFewestPatches = 12;

/// Hartley's conditioning: centroid to 0, mean distance to √2.
Eigen::Matrix3d conditioning(std::span<const PointPair> pairs, cv::Point2d PointPair::*side) {
  cv::Point2d mean(0, 0);
  for (const PointPair& pair : pairs) mean += pair.*side;
  mean *= 1.0 / static_cast<double>(pairs.size());
  double distance = 0.0;
  for (const PointPair& pair : pairs) distance += cv::norm(pair.*side - mean);
  distance /= static_cast<double>(pairs.size());
  const double s = distance > 0 ? std::sqrt(2.0) / distance : 1.0;
  Eigen::Matrix3d t;
  t << s, 0, -s * mean.x, 0, s, -s * mean.y, 0, 0, 1;
  return t;
}

/// Of where `p` goes by the first eight elements, the last being 1.
Jacobian jacobian(const Eigen::Matrix3d& h, cv::Point2d p, cv::Point2d at) {
  const double w = h(2, 0) * p.x + h(2, 1) * p.y + h(2, 2);
  Jacobian j;
  j << p.x, p.y, 1, 0, 0, 0, -at.x * p.x, -at.x * p.y,  //
      0, 0, 0, p.x, p.y, 1, -at.y * p.x, -at.y * p.y;
  return j / w;
}

/// Row-major.
Eigen::Matrix<double, 9, 1> stack(const Eigen::Matrix3d& m) {
  Eigen::Matrix<double, 9, 1> v;
  for (int i = 0; i < 9; ++i) v(i) = m(i / 3, i % 3);
  return v;
}

/// How the eight elements of Tb⁻¹ H Ta, its last made 1, move with the eight of H.
Matrix8 unconditioning(const Eigen::Matrix3d& tb_inverse, const Eigen::Matrix3d& h,
                       const Eigen::Matrix3d& ta) {
  const auto whole = stack(tb_inverse * h * ta);
  Matrix8 j;
  for (int k = 0; k < 8; ++k) {
    Eigen::Matrix3d unit = Eigen::Matrix3d::Zero();
    unit(k / 3, k % 3) = 1.0;
    const auto d = stack(tb_inverse * unit * ta);
    j.col(k) = (d.head<8>() - whole.head<8>() / whole(8) * d(8)) / whole(8);
  }
  return j;
}

/// The sum of scores by patches, for a covariance that neighbours' common errors do not fool.
class Patches {
 public:
  explicit Patches(std::span<const PointPair> pairs) {
    cv::Point2d low = pairs[0].a, high = pairs[0].a;
    for (const PointPair& pair : pairs) {
      low = {std::min(low.x, pair.a.x), std::min(low.y, pair.a.y)};
      high = {std::max(high.x, pair.a.x), std::max(high.y, pair.a.y)};
    }
    patch_px_ =
        std::max({1.0, (high.x - low.x) / kPatchesAcross, (high.y - low.y) / kPatchesAcross});
  }
  void add(cv::Point2d at, const Vector8& score) {
    const std::pair<int, int> patch{static_cast<int>(std::floor(at.x / patch_px_)),
                                    static_cast<int>(std::floor(at.y / patch_px_))};
    sums_.try_emplace(patch, Vector8::Zero()).first->second += score;
  }
  /// nullopt where there are too few to say.
  [[nodiscard]] std::optional<Matrix8> covariance(const Matrix8& inverse) const {
    if (sums_.size() < kFewestPatches) return std::nullopt;
    Matrix8 middle = Matrix8::Zero();
    for (const auto& [patch, sum] : sums_) middle += sum * sum.transpose();
    const auto n = static_cast<double>(sums_.size());
    return Matrix8(inverse * middle * inverse * (n / (n - 8.0)));
  }

 private:
  double patch_px_ = 1.0;
  std::map<std::pair<int, int>, Vector8> sums_;
};

}  // namespace

cv::Point2d apply(const Eigen::Matrix3d& h, cv::Point2d p) {
  const double w = h(2, 0) * p.x + h(2, 1) * p.y + h(2, 2);
  if (!(w > 1e-12)) return {kNaN, kNaN};
  return {(h(0, 0) * p.x + h(0, 1) * p.y + h(0, 2)) / w,
          (h(1, 0) * p.x + h(1, 1) * p.y + h(1, 2)) / w};
}

std::array<cv::Point2d, 4> corners_of(cv::Size size) {
  const double right = size.width - 1.0, bottom = size.height - 1.0;
  return {{{0, 0}, {right, 0}, {right, bottom}, {0, bottom}}};
}

double corner_error_px(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b, cv::Size size) {
  double most = 0.0;
  for (const cv::Point2d& corner : corners_of(size)) {
    const double error = cv::norm(apply(a, corner) - apply(b, corner));
    if (!std::isfinite(error)) return std::numeric_limits<double>::infinity();
    most = std::max(most, error);
  }
  return most;
}

bool is_plausible(const Eigen::Matrix3d& h, cv::Size size, double expected_scale) {
  constexpr double kZoom = 2.5, kSqueeze = 2.0, kVariation = 2.5;
  if (!h.allFinite()) return false;
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const cv::Point2d& p : corners_of(size)) {
    const cv::Point2d q = apply(h, p);
    if (!std::isfinite(q.x) || !std::isfinite(q.y)) return false;
    const double w = h(2, 0) * p.x + h(2, 1) * p.y + h(2, 2);
    Eigen::Matrix2d local;
    local << h(0, 0) - q.x * h(2, 0), h(0, 1) - q.x * h(2, 1), h(1, 0) - q.y * h(2, 0),
        h(1, 1) - q.y * h(2, 1);
    local /= w;
    const double determinant = local.determinant();
    if (!(determinant > 0)) return false;
    const Eigen::Vector2d singular = local.jacobiSvd().singularValues();
    if (singular(0) > kSqueeze * singular(1)) return false;
    const double scale = std::sqrt(determinant) / expected_scale;
    least = std::min(least, scale);
    most = std::max(most, scale);
  }
  return least > 1.0 / kZoom && most < kZoom && most < kVariation * least;
}

std::optional<HomographyFit> fit_homography(std::span<const PointPair> pairs,
                                            const Eigen::Matrix3d& start, cv::Size a_size) {
  if (pairs.size() < 5) return std::nullopt;
  const Eigen::Matrix3d ta = conditioning(pairs, &PointPair::a);
  const Eigen::Matrix3d tb = conditioning(pairs, &PointPair::b);
  const Eigen::Matrix3d tb_inverse = tb.inverse();
  Eigen::Matrix3d h = tb * start * ta.inverse();
  if (!h.allFinite() || std::abs(h(2, 2)) < 1e-9) return std::nullopt;
  h /= h(2, 2);

  // Weights are of mean 1, so that the residuals' scale stays that of pixels.
  std::vector<Eigen::Matrix2d> weights;
  std::vector<PointPair> conditioned;
  double mean_weight = 0.0;
  for (const PointPair& pair : pairs) {
    conditioned.push_back({apply(ta, pair.a), apply(tb, pair.b)});
    weights.push_back(pair.covariance.inverse());
    mean_weight += 0.5 * weights.back().trace() / static_cast<double>(pairs.size());
  }
  if (!(mean_weight > 0) || !std::isfinite(mean_weight)) return std::nullopt;
  for (Eigen::Matrix2d& weight : weights) weight /= mean_weight;

  Matrix8 normal, inverse;
  double square = 0.0;
  for (int step = 0; step <= kSteps; ++step) {
    normal.setZero();
    Vector8 score = Vector8::Zero();
    square = 0.0;
    for (std::size_t i = 0; i < conditioned.size(); ++i) {
      const PointPair& pair = conditioned[i];
      const cv::Point2d at = apply(h, pair.a);
      if (!std::isfinite(at.x)) return std::nullopt;
      const Eigen::Vector2d residual(pair.b.x - at.x, pair.b.y - at.y);
      const Jacobian j = jacobian(h, pair.a, at);
      const Eigen::Matrix<double, 8, 2> weighted = j.transpose() * weights[i];
      normal.noalias() += weighted * j;
      score.noalias() += weighted * residual;
      square += residual.dot(weights[i] * residual);
    }
    const Eigen::LDLT<Matrix8> solver(normal);
    const auto pivots = solver.vectorD();
    if (solver.info() != Eigen::Success || !(pivots.minCoeff() > 1e-10 * pivots.maxCoeff()))
      return std::nullopt;
    inverse = solver.solve(Matrix8::Identity());
    if (step == kSteps) break;
    const Vector8 move = inverse * score;
    for (int k = 0; k < 8; ++k) h(k / 3, k % 3) += move(k);
    if (move.norm() < 1e-10) step = kSteps - 1;  // once more, for the normal matrix there
  }

  HomographyFit fit;
  fit.b_from_a = tb_inverse * h * ta;
  if (!fit.b_from_a.allFinite() || std::abs(fit.b_from_a(2, 2)) < 1e-9) return std::nullopt;
  const Matrix8 to_pixels = unconditioning(tb_inverse, h, ta);
  fit.b_from_a /= fit.b_from_a(2, 2);
  fit.inliers.assign(pairs.begin(), pairs.end());

  Patches patches(pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const cv::Point2d at = apply(h, conditioned[i].a);
    const Eigen::Vector2d residual(conditioned[i].b.x - at.x, conditioned[i].b.y - at.y);
    patches.add(pairs[i].a,
                jacobian(h, conditioned[i].a, at).transpose() * (weights[i] * residual));
  }
  Eigen::Matrix<double, 8, 8> corners_by_h;
  const auto corners = corners_of(a_size);
  for (int k = 0; k < 4; ++k) {
    const cv::Point2d at = apply(fit.b_from_a, corners[static_cast<std::size_t>(k)]);
    if (!std::isfinite(at.x)) return std::nullopt;
    corners_by_h.middleRows<2>(2 * k) =
        jacobian(fit.b_from_a, corners[static_cast<std::size_t>(k)], at);
  }
  const Matrix8 corners_by_conditioned = corners_by_h * to_pixels;
  // At least a residual of rounding: pairs that fit exactly are not known exactly.
  const double degrees = 2.0 * static_cast<double>(pairs.size()) - 8.0;
  const double floor = std::pow(tb(0, 0) * 1e-3, 2);
  Matrix8 covariance = inverse * std::max(square / degrees, floor);
  if (const auto by_patches = patches.covariance(inverse)) {
    const auto spread = [&](const Matrix8& c) {
      return (corners_by_conditioned * c * corners_by_conditioned.transpose()).trace();
    };
    if (spread(*by_patches) > spread(covariance)) covariance = *by_patches;
  }
  fit.covariance = to_pixels * covariance * to_pixels.transpose();
  fit.corner_covariance = corners_by_conditioned * covariance * corners_by_conditioned.transpose();
  fit.corner_sigma_px = std::sqrt(std::max(0.0, fit.corner_covariance.trace()) / 4.0);
  return fit;
}

}  // namespace watersky
