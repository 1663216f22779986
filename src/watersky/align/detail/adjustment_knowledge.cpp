// SPDX-License-Identifier: MIT
/// What is known after solving, and what is kept of frames that are let go.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "watersky/align/detail/adjustment_problem.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky::align {

std::vector<int> Adjustment::first_blocks() const {
  const Blocks blocks = blocks_of(state);
  std::vector<int> out{0};
  const bool delayed = !frames.empty() && frames.front().delayed && !frames.front().own;
  if (delayed && priors.jitter_s > 0.0) out.push_back(blocks.jitter(0));
  if (delayed && blocks.delays > 0) out.push_back(blocks.delay(0));
  out.push_back(blocks.globals());
  return out;
}

void Adjustment::forget_first(double walk_s) {
  // Of the first two frames alone: all that touches the first, and what the second has for itself.
  Adjustment pair(*navigation_, mount_, focal_px_, readout_s_);
  pair.frames = {frames[0], frames[1]};
  pair.knot_times_s = {knot_times_s[0], knot_times_s[1]};
  pair.delay_knot_times_s = delay_knot_times_s;
  pair.delay_start_s = delay_start_s;
  pair.priors = priors;
  pair.before_first = before_first;
  pair.state = state;
  pair.state.knots.resize(2);
  pair.state.jitter_s.resize(2);
  pair.state.extra.resize(2);
  for (const TieGroup& g : groups)
    if (g.host == 0 && g.frame == 1) pair.groups.push_back(g);
  const Blocks blocks = blocks_of(pair.state);
  const Problem problem(pair, pair.state);
  const auto linear = problem.linearise();
  before_first.reset();
  if (linear->good) {
    // Of the second frame it is what `before_first` holds, in that order.
    std::vector<int> kept{1};
    const bool delayed = frames[1].delayed && !frames[1].own;
    if (delayed && priors.jitter_s > 0.0) kept.push_back(blocks.jitter(1));
    if (delayed && blocks.delays > 0) kept.push_back(blocks.delay(0));
    kept.push_back(blocks.globals());
    std::vector<Eigen::Index> columns;  // -1: what nothing told of has its prior
    std::vector<double> mean;
    Eigen::Index walks = -1;
    for (const int b : kept) {
      const int column = linear->first_column[static_cast<std::size_t>(b)];
      const double* at = problem.pointer(b);
      if (blocks.delays > 0 && b == blocks.delay(0))
        walks = static_cast<Eigen::Index>(columns.size());
      if (b == blocks.globals()) {
        for (std::size_t k = 0; column >= 0 && k < problem.free_globals().size(); ++k) {
          columns.push_back(column + static_cast<Eigen::Index>(k));
          mean.push_back(at[problem.free_globals()[k]]);
        }
      } else {
        for (int k = 0; k < blocks.size(b); ++k) {
          columns.push_back(column < 0 ? -1 : column + k);
          mean.push_back(column < 0 ? 0.0 : at[k]);
        }
      }
    }
    const auto n = static_cast<Eigen::Index>(columns.size());
    const Eigen::VectorXd step =
        linear->normal.solve(-(linear->jacobian.transpose() * linear->residuals));
    FirstFramePrior made{Eigen::VectorXd(n), Eigen::MatrixXd::Zero(n, n)};
    for (Eigen::Index c = 0; c < n; ++c) {
      const auto column = columns[static_cast<std::size_t>(c)];
      made.mean[c] = mean[static_cast<std::size_t>(c)];
      if (column < 0) {
        // A frame's own delay is all that may have no row.
        made.covariance(c, c) = priors.jitter_s * priors.jitter_s;
        continue;
      }
      made.mean[c] += step[column];
      Eigen::VectorXd unit = Eigen::VectorXd::Zero(linear->jacobian.cols());
      unit[column] = 1.0;
      const Eigen::VectorXd solved = linear->normal.solve(unit);
      for (Eigen::Index r = 0; r < n; ++r)
        if (const auto row = columns[static_cast<std::size_t>(r)]; row >= 0)
          made.covariance(r, c) = solved[row];
    }
    made.covariance = 0.5 * (made.covariance + made.covariance.transpose()).eval();
    if (walks >= 0) made.covariance(walks, walks) += walk_s * walk_s;
    if (made.mean.allFinite() && made.covariance.allFinite() &&
        made.covariance.llt().info() == Eigen::Success)
      before_first = std::move(made);
  }
  frames.erase(frames.begin());
  for (AdjustedFrame& f : frames) --f.knot;
  knot_times_s.erase(knot_times_s.begin());
  state.knots.erase(state.knots.begin());
  state.jitter_s.erase(state.jitter_s.begin());
  state.extra.erase(state.extra.begin());
  std::erase_if(groups, [](const TieGroup& g) { return g.host == 0 || g.frame == 0; });
  for (TieGroup& g : groups) --g.host, --g.frame;
}

std::optional<Adjustment::Knowledge> Adjustment::knowledge() const {
  AdjustmentState copy = state;
  Problem problem(*this, copy);
  const auto linear = problem.linearise();
  if (!linear->good) return std::nullopt;
  const Blocks& blocks = problem.blocks();
  const Eigen::Index n = linear->jacobian.cols();
  const auto column_of = [&](int block) {
    return linear->first_column[static_cast<std::size_t>(block)];
  };
  const auto& free_globals = problem.free_globals();

  Knowledge out;
  const auto variance = [&](Eigen::Index column) {
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(n);
    unit[column] = 1.0;
    return linear->normal.solve(unit)[column];
  };
  for (std::size_t k = 0; k < free_globals.size(); ++k)
    out.globals_sigma[free_globals[k]] =
        std::sqrt(variance(column_of(blocks.globals()) + static_cast<Eigen::Index>(k)));
  for (std::size_t k = 0; k < state.delay_s.size(); ++k) {
    const int column = column_of(blocks.delay(static_cast<int>(k)));
    out.delay_sigma_s.push_back(column < 0 ? 0.0 : std::sqrt(variance(column)));
  }

  for (std::size_t k = 0; k < state.jitter_s.size(); ++k) {
    const int column = column_of(blocks.jitter(static_cast<int>(k)));
    out.jitter_sigma_s.push_back(column < 0 ? std::numeric_limits<double>::infinity()
                                            : std::sqrt(variance(column)));
  }

  // A camera's rows: 6 x n, sparse.
  const auto rows_of = [&](int frame) {
    Evaluated e;
    evaluate(frame, copy, true, e);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n, 6);
    for (int k = 0; k < e.count; ++k) {
      const Slot& slot = e.slots[static_cast<std::size_t>(k)];
      const int first = column_of(slot.block);
      if (first < 0) continue;
      if (slot.block == blocks.globals()) {
        for (std::size_t c = 0; c < free_globals.size(); ++c)
          rows.row(first + static_cast<Eigen::Index>(c)) +=
              slot.by.col(free_globals[c]).transpose();
      } else {
        rows.middleRows(first, slot.size) += slot.by.transpose();
      }
    }
    return std::pair(rows, e.camera);
  };
  const auto ground = [](const ModelCamera& camera) {
    Matrix26 g = Matrix26::Zero();
    auto hit = hit_sea(camera, Eigen::Vector3d::UnitZ());
    if (!hit) {
      g.leftCols<2>().setIdentity();
      return g;
    }
    g.leftCols<3>() = hit->by_position.topRows<2>();
    g.rightCols<3>() = -(hit->by_direction * skew(hit->ray)).topRows<2>();
    return g;
  };
  constexpr std::size_t kMostAsked = 300;
  const std::size_t stride =
      std::max<std::size_t>(1, (frames.size() + kMostAsked - 1) / kMostAsked);
  std::vector<std::size_t> asked;
  for (std::size_t i = 0; i < frames.size(); i += stride) asked.push_back(i);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(n, 2);
  for (const std::size_t i : asked) {
    const auto [rows, camera] = rows_of(static_cast<int>(i));
    mean += rows * ground(camera).transpose() / static_cast<double>(asked.size());
  }
  const Eigen::MatrixXd with_mean = linear->normal.solve(mean);
  out.shared_m2 = mean.transpose() * with_mean;
  const Eigen::Matrix2d inverse_shared =
      (out.shared_m2 + 1e-18 * Eigen::Matrix2d::Identity()).inverse();
  std::vector<Matrix6> covariances;
  for (const std::size_t i : asked) {
    const auto rows = rows_of(static_cast<int>(i)).first;
    const Eigen::MatrixXd solved = linear->normal.solve(rows);
    const Eigen::Matrix<double, 6, 2> cross = rows.transpose() * with_mean;
    const Matrix6 all = rows.transpose() * solved;
    covariances.push_back(all - cross * inverse_shared * cross.transpose());
  }
  for (std::size_t i = 0; i < frames.size(); ++i)
    out.camera.push_back(covariances[std::min(covariances.size() - 1, (i + stride / 2) / stride)]);
  return out;
}

}  // namespace watersky::align
