// SPDX-License-Identifier: MIT
/// Minimising, and the weights and sigmas that residuals tell.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "watersky/align/detail/adjustment_problem.hpp"

namespace watersky::align {

void Adjustment::look_at_residuals(bool first, bool forgiving) {
  std::vector<double> height_residuals_m;
  for (const KnownHeight& h : known_heights)
    height_residuals_m.push_back(h.error_m - height_error_m(h.t_s, state));
  weigh_heights(known_heights, height_residuals_m);
  std::vector<double> sizes;
  const Cameras now = cameras(state);
  for (TieGroup& group : groups)
    for (Tie& tie : group.ties) {
      const auto r = residual_px(group, tie, now);
      tie.robust = r ? (tie.whiten * *r).norm() : -1.0;  // for the moment
      if (r && !tie.held_out) sizes.push_back(tie.robust);
    }
  if (sizes.empty()) return;
  const auto middle_of = [](std::vector<double>& v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
  };
  std::vector<double> at_knots, between;
  const auto is_between = [this](const TieGroup& g) {
    return frames[static_cast<std::size_t>(g.host)].weight > 0.0 ||
           frames[static_cast<std::size_t>(g.frame)].weight > 0.0;
  };
  for (const TieGroup& group : groups)
    for (const Tie& tie : group.ties)
      if (tie.robust >= 0.0 && !tie.held_out)
        (is_between(group) ? between : at_knots).push_back(tie.robust);
  constexpr std::size_t kEnough = 20;
  constexpr double kMostApart = 1.5;
  const double apart =
      at_knots.size() < kEnough || between.size() < kEnough
          ? 1.0
          : std::clamp(middle_of(between) / std::max(1e-3, middle_of(at_knots)), 1.0, 100.0);
  sizes.clear();
  for (TieGroup& group : groups) {
    group.scale = is_between(group) ? apart : 1.0;
    group.astray = group.scale > kMostApart;
    for (Tie& tie : group.ties) {
      if (tie.robust < 0.0) continue;
      tie.robust /= group.scale;
      if (!tie.held_out) sizes.push_back(tie.robust);
    }
  }
  // Places differ: the corner of a floe is found to a tenth of what a smudge is. Each is weighed by
  // its own residuals, drawn towards those of all where there are few.
  const double all = std::max(1e-3, middle_of(sizes));
  std::map<int, std::vector<double>> of_track;
  if (!first)
    for (const TieGroup& group : groups)
      for (const Tie& tie : group.ties)
        if (tie.track >= 0 && tie.robust >= 0.0) of_track[tie.track].push_back(tie.robust);
  constexpr double kDrawn = 4.0;
  std::map<int, double> scale_of_track;
  for (auto& [track, residuals] : of_track) {
    const auto n = static_cast<double>(residuals.size());
    const double own = middle_of(residuals) / all;
    scale_of_track[track] =
        std::clamp(std::sqrt((n * own * own + kDrawn) / (n + kDrawn)), 0.1, 10.0);
  }
  sizes.clear();
  for (TieGroup& group : groups)
    for (Tie& tie : group.ties) {
      const auto found = scale_of_track.find(tie.track);
      tie.scale = found == scale_of_track.end() ? 1.0 : found->second;
      if (tie.robust < 0.0) continue;
      tie.robust /= tie.scale;
      if (!tie.held_out) sizes.push_back(tie.robust);
    }
  const double sigma = std::max(0.1, middle_of(sizes) / kMedianOfTwo);
  priors.tie = first ? std::max(sigma, 2.0) : sigma;
  for (TieGroup& group : groups) {
    // A frame whose time or pose is still wrong is off as a whole: that is what is to be found, and
    // only what strays from the others of its pair is to be doubted.
    double own = priors.tie;
    if (forgiving) {
      sizes.clear();
      for (const Tie& tie : group.ties)
        if (tie.robust >= 0.0) sizes.push_back(tie.robust);
      if (!sizes.empty()) own = std::max(own, middle_of(sizes) / kMedianOfTwo);
    }
    for (Tie& tie : group.ties) {
      const double x = tie.robust / (3.0 * own);
      tie.robust = tie.robust < 0.0 || (x > 4.0 && !first) ? 0.0 : 1.0 / (1.0 + x * x);
    }
  }
}

double Adjustment::log_evidence() const {
  AdjustmentState copy = state;
  return log_evidence(*Problem(*this, copy).linearise());
}

double Adjustment::log_evidence(const Linear& linear_at) const {
  const Linear* linear = &linear_at;
  if (!linear->good) return -std::numeric_limits<double>::infinity();
  double sum = 0.0;
  // Ties by the heavy-tailed density whose weights they have; other rows are normal.
  const Cameras now = cameras(state);
  for (const TieGroup& group : groups)
    for (const Tie& tie : group.ties) {
      if (tie.held_out) continue;
      const auto r = residual_px(group, tie, now);
      const double sigma = priors.tie * tie.scale * group.scale;
      const double x2 = r ? (tie.whiten * *r).squaredNorm() / std::pow(3.0 * sigma, 2) : 1e4;
      sum -= 4.5 * std::log1p(x2) + 2.0 * std::log(sigma);
    }
  for (std::size_t r = 0; r < linear->kind.size(); ++r)
    if (linear->kind[r] != Problem::Ties) {
      const double x = linear->residuals[static_cast<Eigen::Index>(r)];
      sum -= 0.5 * x * x;
    }
  // What each prior's width costs: the determinant of its rows by their unknowns.
  for (std::size_t k = 0; k < knot_times_s.size(); ++k)
    for (int c = 0; c < 6; ++c) {
      double sigma = priors.knot[c];
      if (k > 0) {
        const double tau = c < 3 ? priors.position_correlation_s : priors.attitude_correlation_s;
        sigma *= std::sqrt(
            std::max(1e-12, 1.0 - std::exp(-2.0 * (knot_times_s[k] - knot_times_s[k - 1]) / tau)));
      }
      sum -= std::log(sigma);
    }
  if (priors.jitter_s > 0.0)
    sum -= static_cast<double>(
               std::count(linear->kind.begin(), linear->kind.end(), Problem::Jitters)) *
           std::log(priors.jitter_s);
  const Eigen::SparseMatrix<double> factor = linear->normal.matrixL();
  for (Eigen::Index k = 0; k < factor.rows(); ++k) sum -= std::log(factor.coeff(k, k));
  return sum;
}

Adjustment::Summary Adjustment::solve(const AdjustmentOptions& options) {
  Summary total;
  // Sigmas from residuals can run away where the data tell little of them: the evidence decides.
  struct Best {
    double evidence = -std::numeric_limits<double>::infinity();
    AdjustmentPriors priors;
    AdjustmentState state;
  } best;
  for (int round = 0; round < options.rounds; ++round) {
    look_at_residuals(round == 0 && !options.warm, round + 1 < options.rounds);
    Problem problem(*this, state);
    const Summary s = problem.solve(options);
    total.usable = s.usable;
    total.iterations += s.iterations;
    total.seconds += s.seconds;
    if (!s.usable) return total;
    if (!options.estimate_variances) continue;
    // Variance components (Förstner 1979): what the residuals of a kind of rows weigh, over the
    // share of them that the solution did not use up. The trace is by random signs (Hutchinson).
    look_at_residuals(false, round + 1 < options.rounds);
    Problem again(*this, state);
    const auto linear = again.linearise();
    if (!linear->good) continue;
    if (const double evidence = log_evidence(*linear); evidence > best.evidence)
      best = {evidence, priors, state};
    if (round + 1 == options.rounds) break;
    std::mt19937 random(17);
    struct Component {
      double squares = 0.0, rows = 0.0, used = 0.0;
    };
    std::array<Component, 3> part;  // position, attitude, jitter
    const auto part_of = [&](Eigen::Index r) {
      const auto at = static_cast<std::size_t>(r);
      if (linear->kind[at] == Problem::Knots) return linear->component[at] < 3 ? 0 : 1;
      return linear->kind[at] == Problem::Jitters ? 2 : -1;
    };
    for (Eigen::Index r = 0; r < linear->residuals.size(); ++r)
      if (const int k = part_of(r); k >= 0) {
        part[static_cast<std::size_t>(k)].squares += linear->residuals[r] * linear->residuals[r];
        part[static_cast<std::size_t>(k)].rows += 1.0;
      }
    constexpr int kProbes = 8;
    for (int k = 0; k < 3; ++k) {
      if (part[static_cast<std::size_t>(k)].rows == 0.0) continue;
      for (int probe = 0; probe < kProbes; ++probe) {
        Eigen::VectorXd z = Eigen::VectorXd::Zero(linear->residuals.size());
        for (Eigen::Index r = 0; r < z.size(); ++r)
          if (part_of(r) == k) z[r] = (random() & 1U) != 0 ? 1.0 : -1.0;
        const Eigen::VectorXd jz = linear->jacobian.transpose() * z;
        const Eigen::VectorXd x = linear->normal.solve(jz);
        part[static_cast<std::size_t>(k)].used += jz.dot(x) / kProbes;
      }
    }
    const auto factor = [&](int k) {
      const Component& c = part[static_cast<std::size_t>(k)];
      // Where nearly all is used up the residuals say nothing of it.
      const double redundancy = c.rows - c.used;
      if (c.rows < 6 || redundancy < 0.02 * c.rows) return 1.0;
      return std::clamp(std::sqrt(c.squares / redundancy), 0.2, 5.0);
    };
    priors.knot.head<3>() *= factor(0);
    priors.knot.tail<3>() *= factor(1);
    priors.knot = priors.knot.cwiseMin(priors.knot_most);
    if (priors.jitter_s > 0.0) priors.jitter_s = std::max(1e-5, priors.jitter_s * factor(2));
  }
  if (std::isfinite(best.evidence)) {
    priors = best.priors;
    state = best.state;
    look_at_residuals(false, false);
  }
  return total;
}

Globals::Vector Adjustment::globals_sigma_by_places(const AdjustmentOptions& options) const {
  constexpr int kParts = 6;
  std::vector<Globals::Vector> found;
  for (int part = 0; part < kParts; ++part) {
    Adjustment without = *this;
    for (TieGroup& g : without.groups)
      for (Tie& t : g.ties)
        // By a step that has no divisor in common with that of the places which judge.
        if (t.track >= 0 && (t.track / 7) % kParts == part) t.held_out = true;
    Problem problem(without, without.state);
    if (!problem.solve(options).usable) continue;
    found.push_back(without.state.globals);
  }
  Globals::Vector mean = Globals::Vector::Zero(), square = Globals::Vector::Zero();
  if (found.size() < 2) return square;
  const auto n = static_cast<double>(found.size());
  for (const Globals::Vector& g : found) mean += g / n;
  for (const Globals::Vector& g : found) square += (g - mean).cwiseAbs2();
  return ((n - 1.0) / n * square).cwiseSqrt();
}

void Adjustment::solve_frames() {
  std::vector<std::vector<const TieGroup*>> groups_of(frames.size());
  for (const TieGroup& g : groups) groups_of[static_cast<std::size_t>(g.frame)].push_back(&g);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const AdjustedFrame& frame = frames[i];
    if (frame.weight <= 0.0) continue;
    const double dt = knot_times_s[static_cast<std::size_t>(frame.knot) + 1] -
                      knot_times_s[static_cast<std::size_t>(frame.knot)];
    Eigen::Matrix<double, 6, 1> sigma;
    for (int c = 0; c < 6; ++c) {
      const double tau = c < 3 ? priors.position_correlation_s : priors.attitude_correlation_s;
      sigma[c] = priors.knot[c] *
                 std::sqrt(2.0 * dt / tau * std::max(0.02, frame.weight * (1 - frame.weight)));
    }
    solve_frame(static_cast<int>(i), groups_of[i], sigma, 0.0, false);
  }
}

Eigen::Matrix<double, 6, 6> Adjustment::solve_frame(int frame,
                                                    const std::vector<const TieGroup*>& of_frame,
                                                    const Eigen::Matrix<double, 6, 1>& sigma,
                                                    double jitter_s, bool reweigh) {
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  using Matrix7 = Eigen::Matrix<double, 7, 7>;
  const auto i = static_cast<std::size_t>(frame);
  const int steps = reweigh ? 4 : 2;
  std::vector<ModelCamera> hosts;
  for (const TieGroup* g : of_frame) hosts.push_back(camera(g->host));
  Vector7 information;
  information << sigma.cwiseAbs2().cwiseInverse(),
      jitter_s > 0.0 ? 1.0 / (jitter_s * jitter_s) : 1.0;
  Eigen::Map<Eigen::Matrix<double, 6, 1>> extra(state.extra[i].data());
  Matrix7 normal;
  Eigen::Matrix<double, 6, 7> by;
  for (int step = 0; step < steps; ++step) {
    Evaluated e;
    evaluate(frame, state, true, e);
    // Of the frame's own error its knot's derivative is the whole, where it has but one.
    by.leftCols<6>() = e.slots[0].by.leftCols<6>() / (1.0 - frames[i].weight);
    by.col(6).setZero();
    if (jitter_s > 0.0) by.col(6) << -e.camera.velocity_m_s, -e.camera.rate_rad_s;
    normal = information.asDiagonal();
    Vector7 right;
    right << -(information.head<6>().cwiseProduct(extra)),
        (jitter_s > 0.0 ? -information[6] * state.jitter_s[i] : 0.0);
    for (std::size_t g = 0; g < of_frame.size(); ++g) {
      const double elapsed_s = e.t_s - time_s(of_frame[g]->host, state);
      for (const Tie& tie : of_frame[g]->ties) {
        if (tie.held_out || tie.robust <= 0.0) continue;
        const auto t = transfer(hosts[g].at_row(tie.host_row, readout_s_),
                                e.camera.at_row(tie.frame_row, readout_s_), tie.host, tie.frame,
                                state.globals[Globals::kFocal],
                                state.globals.segment<2>(Globals::kDrift), elapsed_s);
        if (!t) continue;
        const Eigen::Matrix2d whole = focal_px_ / (priors.tie * tie.scale) * tie.whiten;
        double robust = tie.robust;
        if (reweigh) {
          // Loose at first: a frame that is off as a whole is to be moved, not doubted.
          const double x2 = (whole * t->residual).squaredNorm() / (step == 0 ? 900.0 : 9.0);
          robust = 1.0 / (1.0 + x2);
        }
        const Eigen::Matrix2d scale = std::sqrt(robust) * whole;
        const Eigen::Matrix<double, 2, 7> rows = scale * t->by_frame * by;
        normal += rows.transpose() * rows;
        right -= rows.transpose() * (scale * t->residual);
      }
    }
    for (const KnownPoint& point : known_points) {
      if (point.frame != frame) continue;
      const auto seen = see_known(point, state);
      if (!seen) continue;
      const Eigen::Matrix<double, 2, 7> rows = point.whiten * seen->by_camera * by;
      normal += rows.transpose() * rows;
      right -= rows.transpose() * (point.whiten * seen->residual_px);
    }
    const Vector7 move = normal.ldlt().solve(right);
    extra += move.head<6>();
    if (jitter_s > 0.0) state.jitter_s[i] += move[6];
  }
  return by * normal.inverse() * by.transpose();
}

}  // namespace watersky::align
