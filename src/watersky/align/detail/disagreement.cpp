// SPDX-License-Identifier: MIT
#include "watersky/align/detail/disagreement.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "watersky/align/detail/flight_edit.hpp"

namespace watersky::detail {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kUnknowns = 7;
constexpr int kSteps = 8;
/// A ray must meet the sea at least this steep: sine of the angle.
constexpr double kLeastSine = 0.05;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Information = Eigen::Matrix<double, kUnknowns, kUnknowns>;

Nuisance plus(Nuisance n, const Unknowns& step, const NuisancePrior& prior) {
  n.turn = (n.turn + step.head<3>()).cwiseMax(-kMostTurn_rad).cwiseMin(kMostTurn_rad);
  const double most_log_height =
      prior.free_height() ? std::numeric_limits<double>::infinity() : kMostLogHeight;
  n.log_height = std::clamp(n.log_height + step(3), -most_log_height, most_log_height);
  n.delay_s += step(4);
  constexpr double kMost_s = kDelayStep_s * kNoDelay;
  n.delay_s = std::clamp(n.delay_s, -kMost_s, kMost_s);
  n.drift_m_s = (n.drift_m_s + step.tail<2>()).cwiseMax(-kMostDrift_m_s).cwiseMin(kMostDrift_m_s);
  return n;
}

Unknowns over_prior(const Nuisance& n, const NuisancePrior& prior) {
  Unknowns v;
  v << n.turn / prior.turn_rad, n.log_height / prior.log_height, n.delay_s / prior.delay_s,
      n.drift_m_s / prior.drift_m_s;
  return v;
}

Eigen::Matrix3d turned_by(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

}  // namespace

double median_of(std::vector<double> values) {
  if (values.empty()) return kNaN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<SeenFrame> see_frame(const Flight& flight, const ImageFrame& frame,
                                   Duration max_gap) {
  const auto here = flight.camera_pose(frame, max_gap);
  if (!here) return std::nullopt;
  SeenFrame seen;
  seen.time_s = to_seconds(here->time);
  const Rigid3<World, Sea> world_from_sea =
      here->world_from_camera * here->sea_from_camera.inverse();
  seen.sea = world_from_sea.origin().v;
  seen.up = world_from_sea.rotation() * -Eigen::Vector3d::UnitZ();
  const auto keep = [&](int i, const CameraPose& pose) {
    seen.rotation[static_cast<std::size_t>(i)] = pose.world_from_camera.rotation();
    seen.origin[static_cast<std::size_t>(i)] = pose.world_from_camera.origin().v;
  };
  keep(kNoDelay, *here);
  ImageFrame shifted;
  shifted.own_gimbal = frame.own_gimbal;
  // A pose recorded with the frame moves with it.
  const bool moves = !frame.own_pose;
  for (const int way : {-1, 1}) {
    CameraPose last = *here;
    for (int i = kNoDelay + way; i >= 0 && i < kDelays; i += way) {
      shifted.captured_at = here->time + seconds((i - kNoDelay) * kDelayStep_s);
      if (moves)
        if (const auto pose = flight.camera_pose(shifted, max_gap)) last = *pose;
      keep(i, last);
    }
  }
  return seen;
}

PairRays pair_rays(const CameraModel& camera, const RegisteredPair& pair, std::size_t a,
                   std::size_t b, std::size_t most) {
  PairRays out;
  out.a = a;
  out.b = b;
  const int w = camera.width_px(), h = camera.height_px();
  for (int k = 0; k < kQuarters; ++k) {
    if (k % 2 == 1 && w != h) continue;
    const auto i = static_cast<std::size_t>(k);
    // The points come spread: their first ones are as well.
    for (const PointPair& p : pair.points) {
      if (out.rays_a[i].size() == most) break;
      const auto ray_a = camera.direction(native_pixel({p.a.x, p.a.y}, k, w, h));
      const auto ray_b = camera.direction(native_pixel({p.b.x, p.b.y}, k, w, h));
      constexpr double kBeyondLens = 0.0;  // a direction of no length meets nothing
      out.rays_a[i].push_back(ray_a ? ray_a->v : Eigen::Vector3d::Constant(kBeyondLens).eval());
      out.rays_b[i].push_back(ray_b ? ray_b->v : Eigen::Vector3d::Constant(kBeyondLens).eval());
    }
  }
  return out;
}

double Disagreement::cost_of(double pair_m) const {
  return 0.5 * std::log1p(std::pow(std::min(pair_m, cap_m_) / noise_m_, 2));
}

std::vector<Eigen::Vector3d> Disagreement::on_sea(std::span<const SeenFrame> frames,
                                                  std::size_t frame,
                                                  std::span<const Eigen::Vector3d> rays,
                                                  const Nuisance& nuisance) const {
  const SeenFrame& seen = frames[frame];
  const double at = nuisance.delay_s / kDelayStep_s + kNoDelay;
  const auto i =
      static_cast<std::size_t>(std::clamp(static_cast<int>(std::floor(at)), 0, kDelays - 2));
  const double f = std::clamp(at - static_cast<double>(i), 0.0, 1.0);
  const Eigen::Matrix3d turned =
      seen.rotation[i].slerp(f, seen.rotation[i + 1]).toRotationMatrix() * turned_by(nuisance.turn);
  Eigen::Vector3d origin = (1 - f) * seen.origin[i] + f * seen.origin[i + 1];
  const double height_m = (origin - seen.sea).dot(seen.up) * std::exp(nuisance.log_height);
  origin += (height_m - (origin - seen.sea).dot(seen.up)) * seen.up;
  // World's first two axes lie along the sea wherever the datum is not far away.
  origin.head<2>() -= seen.time_s * nuisance.drift_m_s;
  std::vector<Eigen::Vector3d> out;
  out.reserve(rays.size());
  for (const Eigen::Vector3d& ray : rays) {
    const Eigen::Vector3d d = turned * ray;
    const double down = -d.dot(seen.up);
    out.push_back(down > kLeastSine && height_m > 0 ? Eigen::Vector3d(origin + height_m / down * d)
                                                    : Eigen::Vector3d::Constant(kNaN).eval());
  }
  return out;
}

double Disagreement::of_pair(std::size_t pair, std::span<const SeenFrame> frames, int quarters_a,
                             int quarters_b, const Nuisance& nuisance) const {
  const PairRays& p = pairs_[pair];
  const auto a = on_sea(frames, p.a, p.rays_a[static_cast<std::size_t>(quarters_a)], nuisance);
  const auto b = on_sea(frames, p.b, p.rays_b[static_cast<std::size_t>(quarters_b)], nuisance);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double off = (a[i] - b[i]).norm();
    sum += std::pow(std::isfinite(off) ? std::min(off, cap_m_) : cap_m_, 2);
  }
  return a.empty() ? cap_m_ : std::sqrt(sum / static_cast<double>(a.size()));
}

Eigen::VectorXd Disagreement::residuals(std::span<const SeenFrame> frames, const Quarters& quarters,
                                        const Nuisance& nuisance) const {
  Eigen::Index count = 0;
  for (const PairRays& p : pairs_) count += static_cast<Eigen::Index>(p.rays_a[0].size());
  Eigen::VectorXd out(3 * count);
  Eigen::Index row = 0;
  for (const PairRays& p : pairs_) {
    const auto turn = [&](std::size_t frame) {
      return static_cast<std::size_t>(quarters.empty() ? 0 : quarters[frame]);
    };
    const auto a = on_sea(frames, p.a, p.rays_a[turn(p.a)], nuisance);
    const auto b = on_sea(frames, p.b, p.rays_b[turn(p.b)], nuisance);
    for (std::size_t i = 0; i < p.rays_a[0].size(); ++i, row += 3)
      out.segment<3>(row) = a[i] - b[i];
  }
  return out;
}

std::vector<double> Disagreement::by_pair(const Eigen::VectorXd& residuals) const {
  std::vector<double> out;
  Eigen::Index row = 0;
  for (const PairRays& p : pairs_) {
    double sum = 0.0;
    for (std::size_t i = 0; i < p.rays_a[0].size(); ++i, row += 3) {
      const double off = residuals.segment<3>(row).norm();
      sum += std::pow(std::isfinite(off) ? std::min(off, cap_m_) : cap_m_, 2);
    }
    out.push_back(p.rays_a[0].empty() ? cap_m_
                                      : std::sqrt(sum / static_cast<double>(p.rays_a[0].size())));
  }
  return out;
}

Fit Disagreement::fit(std::span<const SeenFrame> frames, const Quarters& quarters,
                      const NuisancePrior& prior) const {
  const auto cost = [&](const std::vector<double>& pair_m, const Nuisance& n) {
    double sum = 0.5 * over_prior(n, prior).squaredNorm();
    for (const double m : pair_m) sum += cost_of(m);
    return sum;
  };
  // Delay and height may be far from zero, so where to begin is looked for.
  Fit best;
  best.cost = std::numeric_limits<double>::infinity();
  std::vector<double> heights{0.0};
  if (prior.free_height()) heights = {-1.2, -0.6, -0.3, 0.0, 0.3, 0.6, 1.2};
  for (const double log_height : heights)
    for (const double delay_s : {0.0, -0.4, -0.2, 0.2, 0.4}) {
      const Nuisance n{Eigen::Vector3d::Zero(), log_height, delay_s, Eigen::Vector2d::Zero()};
      auto pair_m = by_pair(residuals(frames, quarters, n));
      const double c = cost(pair_m, n);
      if (c < best.cost) best = {n, std::move(pair_m), c, 0.0};
    }

  Unknowns step_size, inverse_prior;
  step_size << 1e-4, 1e-4, 1e-4, 1e-4, 1e-2, 1e-3, 1e-3;
  inverse_prior << Eigen::Vector3d::Constant(1.0 / prior.turn_rad), 1.0 / prior.log_height,
      1.0 / prior.delay_s, Eigen::Vector2d::Constant(1.0 / prior.drift_m_s);
  Information information = Information::Zero();
  double damping = 1e-3;
  Eigen::VectorXd now = residuals(frames, quarters, best.nuisance);
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix<double, Eigen::Dynamic, kUnknowns> jacobian(now.size(), kUnknowns);
    for (int k = 0; k < kUnknowns; ++k) {
      Unknowns unit = Unknowns::Zero();
      // Inwards, so that it is there at the bounds as well.
      const Nuisance& n = best.nuisance;
      const double value = k < 3    ? n.turn(k)
                           : k == 3 ? n.log_height
                           : k == 4 ? n.delay_s
                                    : n.drift_m_s(k - 5);
      const double h = value > 0 ? -step_size(k) : step_size(k);
      unit(k) = h;
      jacobian.col(k) = (residuals(frames, quarters, plus(n, unit, prior)) - now) / h;
    }
    information = Information(inverse_prior.array().square().matrix().asDiagonal());
    Unknowns gradient = inverse_prior.cwiseProduct(over_prior(best.nuisance, prior));
    Eigen::Index row = 0;
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      // Points of one pair err alike: together they count as one.
      const auto points = static_cast<Eigen::Index>(pairs_[p].rays_a[0].size());
      const double weight = 1.0 / (noise_m_ * noise_m_ + best.pair_m[p] * best.pair_m[p]) /
                            static_cast<double>(std::max<Eigen::Index>(points, 1));
      for (Eigen::Index i = 0; i < points; ++i, row += 3) {
        const auto j = jacobian.middleRows<3>(row);
        const auto r = now.segment<3>(row);
        if (!r.allFinite() || !j.allFinite() || r.norm() > cap_m_) continue;
        information += weight * j.transpose() * j;
        gradient += weight * j.transpose() * r;
      }
    }
    Information damped = information;
    damped.diagonal() *= 1.0 + damping;
    const Nuisance next = plus(best.nuisance, -damped.ldlt().solve(gradient), prior);
    Eigen::VectorXd then = residuals(frames, quarters, next);
    auto pair_m = by_pair(then);
    const double c = cost(pair_m, next);
    if (!(c < best.cost)) {
      damping *= 10.0;
      if (damping > 1e4) break;
      continue;
    }
    const double gained = best.cost - c;
    best = {next, std::move(pair_m), c, 0.0};
    now = std::move(then);
    damping = std::max(1e-6, 0.1 * damping);
    if (gained < 1e-4) break;
  }
  // Weights took the noise as given; the residuals may say more.
  const double scale = std::max(1.0, 1.5 * median_of(best.pair_m) / noise_m_);
  const Information covariance = information.ldlt().solve(Information::Identity());
  best.sigma_log_height = scale * std::sqrt(std::max(0.0, covariance(3, 3)));
  return best;
}

}  // namespace watersky::detail
