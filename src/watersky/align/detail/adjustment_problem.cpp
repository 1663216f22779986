// SPDX-License-Identifier: MIT
#include "watersky/align/detail/adjustment_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace watersky::align {

Blocks blocks_of(const AdjustmentState& s) {
  return {static_cast<int>(s.knots.size()), static_cast<int>(s.delay_s.size()),
          static_cast<int>(s.jitter_s.size())};
}

namespace {

/// A state of its own with just these blocks filled in: the frames ask for no others.
const AdjustmentState& state_with(const Adjustment& adjustment, const std::vector<int>& blocks,
                                  double const* const* parameters,
                                  std::initializer_list<int> frames) {
  thread_local AdjustmentState s;
  const AdjustmentState& shape = adjustment.state;
  s.knots.resize(shape.knots.size());
  s.delay_s.resize(shape.delay_s.size());
  s.jitter_s.resize(shape.jitter_s.size());
  for (const int f : frames) s.jitter_s[static_cast<std::size_t>(f)] = 0.0;
  s.extra.resize(shape.extra.size());
  const Blocks all = blocks_of(shape);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const int b = blocks[k];
    const double* p = parameters[k];
    if (b < all.knots)
      std::copy(p, p + 6, s.knots[static_cast<std::size_t>(b)].begin());
    else if (b < all.knots + all.delays)
      s.delay_s[static_cast<std::size_t>(b - all.knots)] = *p;
    else if (b < all.globals())
      s.jitter_s[static_cast<std::size_t>(b - all.knots - all.delays)] = *p;
    else
      s.globals = Eigen::Map<const Globals::Vector>(p);
  }
  for (const int f : frames)
    s.extra[static_cast<std::size_t>(f)] = shape.extra[static_cast<std::size_t>(f)];
  return s;
}

}  // namespace

/// To two rows of jacobians what they owe to a camera's parameters.
std::array<std::size_t, 6> Adjustment::places(const Evaluated& camera,
                                              const std::vector<int>& blocks) {
  std::array<std::size_t, 6> at{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(camera.count); ++k)
    at[k] = static_cast<std::size_t>(
        std::find(blocks.begin(), blocks.end(), camera.slots[k].block) - blocks.begin());
  return at;
}

void Adjustment::add_rows(const Evaluated& camera, const std::array<std::size_t, 6>& at,
                          const Matrix26& by, int row, double** jacobians) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(camera.count); ++k) {
    const Slot& slot = camera.slots[k];
    double* j = jacobians[at[k]];
    if (!j) continue;
    for (int c = 0; c < slot.size; ++c) {
      const Eigen::Vector2d column = by * slot.by.col(c);
      j[row * slot.size + c] += column.x();
      j[(row + 1) * slot.size + c] += column.y();
    }
  }
}

/// The residuals of one pair of frames.
class TieCost final : public ceres::CostFunction {
 public:
  TieCost(const Adjustment& adjustment, const TieGroup& group, std::vector<int> blocks)
      : adjustment_(&adjustment), group_(&group), blocks_(std::move(blocks)) {
    const Blocks all = blocks_of(adjustment.state);
    int rows = 0;
    for (const Tie& t : group.ties) rows += t.held_out ? 0 : 2;
    set_num_residuals(rows);
    for (const int b : blocks_) mutable_parameter_block_sizes()->push_back(all.size(b));
    globals_ = static_cast<std::size_t>(std::find(blocks_.begin(), blocks_.end(), all.globals()) -
                                        blocks_.begin());
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const AdjustmentState& s =
        state_with(*adjustment_, blocks_, parameters, {group_->host, group_->frame});
    const Blocks all = blocks_of(adjustment_->state);
    Adjustment::Evaluated host, frame;
    const bool derive = jacobians != nullptr;
    adjustment_->evaluate(group_->host, s, derive, host);
    adjustment_->evaluate(group_->frame, s, derive, frame);
    const double focal = s.globals[Globals::kFocal];
    const Eigen::Vector2d drift = s.globals.segment<2>(Globals::kDrift);
    const double elapsed_s = frame.t_s - host.t_s;
    const int rows = num_residuals();
    if (derive)
      for (std::size_t k = 0; k < blocks_.size(); ++k)
        if (jacobians[k]) std::fill_n(jacobians[k], rows * all.size(blocks_[k]), 0.0);

    const auto host_at = Adjustment::places(host, blocks_),
               frame_at = Adjustment::places(frame, blocks_);
    int row = 0;
    for (const Tie& tie : group_->ties) {
      if (tie.held_out) continue;
      const Eigen::Matrix2d scale = adjustment_->focal_px() /
                                    (adjustment_->priors.tie * tie.scale * group_->scale) *
                                    std::sqrt(tie.robust) * tie.whiten;
      const auto t = transfer(host.camera.at_row(tie.host_row, adjustment_->readout_s()),
                              frame.camera.at_row(tie.frame_row, adjustment_->readout_s()),
                              tie.host, tie.frame, focal, drift, elapsed_s);
      if (!t) {
        // Off the sea for a trial step: as bad as can be, without a direction.
        residuals[row] = residuals[row + 1] = tie.robust > 0.0 ? 1e3 : 0.0;
        row += 2;
        continue;
      }
      const Eigen::Vector2d residual = scale * t->residual;
      residuals[row] = residual.x();
      residuals[row + 1] = residual.y();
      if (derive) {
        Adjustment::add_rows(host, host_at, scale * t->by_host, row, jacobians);
        Adjustment::add_rows(frame, frame_at, scale * t->by_frame, row, jacobians);
        if (double* j = jacobians[globals_]) {
          const Eigen::Vector2d by_focal = scale * t->by_focal;
          const Eigen::Matrix2d by_drift = scale * t->by_drift;
          for (int r = 0; r < 2; ++r) {
            double* line = j + (row + r) * Globals::kSize;
            line[Globals::kFocal] += by_focal[r];
            for (int c = 0; c < 2; ++c) line[Globals::kDrift + c] += by_drift(r, c);
          }
        }
      }
      row += 2;
    }
    return true;
  }

 private:
  const Adjustment* adjustment_;
  const TieGroup* group_;
  std::vector<int> blocks_;
  std::size_t globals_ = 0;
};

/// The residual of one sighting of an anchor.
class KnownPointCost final : public ceres::CostFunction {
 public:
  KnownPointCost(const Adjustment& adjustment, const KnownPoint& point, std::vector<int> blocks)
      : adjustment_(&adjustment), point_(&point), blocks_(std::move(blocks)) {
    const Blocks all = blocks_of(adjustment.state);
    set_num_residuals(2);
    for (const int b : blocks_) mutable_parameter_block_sizes()->push_back(all.size(b));
    globals_ = static_cast<std::size_t>(std::find(blocks_.begin(), blocks_.end(), all.globals()) -
                                        blocks_.begin());
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const AdjustmentState& s = state_with(*adjustment_, blocks_, parameters, {point_->frame});
    const Blocks all = blocks_of(adjustment_->state);
    Adjustment::Evaluated frame;
    adjustment_->evaluate(point_->frame, s, jacobians != nullptr, frame);
    if (jacobians)
      for (std::size_t k = 0; k < blocks_.size(); ++k)
        if (jacobians[k]) std::fill_n(jacobians[k], 2 * all.size(blocks_[k]), 0.0);
    const auto seen = see_known_point(frame.camera.at_row(point_->row, adjustment_->readout_s()),
                                      *point_, s.globals[Globals::kFocal], frame.t_s);
    if (!seen) {
      residuals[0] = residuals[1] = 1e3;  // behind the camera for a trial step
      return true;
    }
    const Eigen::Matrix2d scale = adjustment_->focal_px() * point_->whiten;
    Eigen::Map<Eigen::Vector2d>(residuals, 2) = scale * seen->residual;
    if (!jacobians) return true;
    Adjustment::add_rows(frame, Adjustment::places(frame, blocks_), scale * seen->by_camera, 0,
                         jacobians);
    if (double* j = jacobians[globals_]) {
      const Eigen::Vector2d by_focal = scale * seen->by_focal;
      for (int r = 0; r < 2; ++r) j[r * Globals::kSize + Globals::kFocal] += by_focal[r];
    }
    return true;
  }

 private:
  const Adjustment* adjustment_;
  const KnownPoint* point_;
  std::vector<int> blocks_;
  std::size_t globals_ = 0;
};

namespace {

/// The residual of one known height, linear in the knots around it and the height of all.
class KnownHeightCost final : public ceres::CostFunction {
 public:
  /// With blocks of `weight` 0 the second knot is not asked for.
  KnownHeightCost(const KnownHeight& height, double weight)
      : scale_(std::sqrt(height.robust) / height.sigma_m),
        error_m_(height.error_m),
        weight_(weight) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(Globals::kSize);
    mutable_parameter_block_sizes()->push_back(6);
    if (weight > 0.0) mutable_parameter_block_sizes()->push_back(6);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    double up_m = parameters[0][Globals::kHeight] - (1.0 - weight_) * parameters[1][2];
    if (weight_ > 0.0) up_m -= weight_ * parameters[2][2];
    residuals[0] = scale_ * (up_m - error_m_);
    if (!jacobians) return true;
    const auto set = [&](int block, int size, int at, double by) {
      if (!jacobians[block]) return;
      std::fill_n(jacobians[block], size, 0.0);
      jacobians[block][at] = scale_ * by;
    };
    set(0, Globals::kSize, Globals::kHeight, 1.0);
    set(1, 6, 2, weight_ - 1.0);
    if (weight_ > 0.0) set(2, 6, 2, -weight_);
    return true;
  }

 private:
  double scale_, error_m_, weight_;
};

/// (after - keep before) / sigma, element by element; without `before` a plain prior about `mean`.
class LinkCost final : public ceres::CostFunction {
 public:
  LinkCost(Eigen::VectorXd keep, Eigen::VectorXd sigma, Eigen::VectorXd mean, bool linked)
      : keep_(std::move(keep)), sigma_(std::move(sigma)), mean_(std::move(mean)), linked_(linked) {
    const int n = static_cast<int>(sigma_.size());
    set_num_residuals(n);
    mutable_parameter_block_sizes()->push_back(n);
    if (linked_) mutable_parameter_block_sizes()->push_back(n);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const int n = num_residuals();
    for (int k = 0; k < n; ++k) {
      const double expected = linked_ ? keep_[k] * parameters[1][k] : mean_[k];
      residuals[k] = (parameters[0][k] - expected) / sigma_[k];
    }
    if (!jacobians) return true;
    for (int b = 0; b < (linked_ ? 2 : 1); ++b)
      if (jacobians[b]) {
        std::fill_n(jacobians[b], n * n, 0.0);
        for (int k = 0; k < n; ++k)
          jacobians[b][k * n + k] = (b == 0 ? 1.0 : -keep_[k]) / sigma_[k];
      }
    return true;
  }

 private:
  Eigen::VectorXd keep_, sigma_, mean_;
  bool linked_;
};

/// That the delay goes on at the rate at which it went: what differs is what it walked.
class RateCost final : public ceres::SizedCostFunction<1, 1, 1, 1> {
 public:
  /// Seconds between the delay knots, first to second and second to third; the walk per root
  /// second.
  RateCost(double first_s, double second_s, double walk_s)
      : first_s_(first_s),
        second_s_(second_s),
        sigma_(walk_s * std::sqrt(1.0 / first_s + 1.0 / second_s)) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double third = *parameters[0], second = *parameters[1], first = *parameters[2];
    residuals[0] = ((third - second) / second_s_ - (second - first) / first_s_) / sigma_;
    if (!jacobians) return true;
    if (jacobians[0]) jacobians[0][0] = 1.0 / (second_s_ * sigma_);
    if (jacobians[1]) jacobians[1][0] = -(1.0 / second_s_ + 1.0 / first_s_) / sigma_;
    if (jacobians[2]) jacobians[2][0] = 1.0 / (first_s_ * sigma_);
    return true;
  }

 private:
  double first_s_, second_s_, sigma_;
};

}  // namespace

namespace {

/// root (x - mean) of blocks laid one behind the other.
class FirstFrameCost final : public ceres::CostFunction {
 public:
  /// `columns`: of each block, which elements of x its own are; -1: of none.
  FirstFrameCost(const FirstFramePrior& prior, std::vector<std::vector<int>> columns)
      : mean_(prior.mean), columns_(std::move(columns)) {
    const Eigen::LLT<Eigen::MatrixXd> covariance(prior.covariance);
    root_ = covariance.matrixL().solve(
        Eigen::MatrixXd::Identity(prior.covariance.rows(), prior.covariance.cols()));
    set_num_residuals(static_cast<int>(mean_.size()));
    for (const auto& c : columns_)
      mutable_parameter_block_sizes()->push_back(static_cast<int>(c.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::VectorXd x = mean_;
    for (std::size_t b = 0; b < columns_.size(); ++b)
      for (std::size_t k = 0; k < columns_[b].size(); ++k)
        if (columns_[b][k] >= 0) x[columns_[b][k]] = parameters[b][k];
    const Eigen::Index n = mean_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) = root_ * (x - mean_);
    if (!jacobians) return true;
    for (std::size_t b = 0; b < columns_.size(); ++b) {
      if (!jacobians[b]) continue;
      const auto size = static_cast<Eigen::Index>(columns_[b].size());
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> j(
          jacobians[b], n, size);
      for (Eigen::Index k = 0; k < size; ++k) {
        const int column = columns_[b][static_cast<std::size_t>(k)];
        if (column >= 0)
          j.col(k) = root_.col(column);
        else
          j.col(k).setZero();
      }
    }
    return true;
  }

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd root_;
  std::vector<std::vector<int>> columns_;
};

}  // namespace

Adjustment::Problem::Problem(const Adjustment& adjustment, AdjustmentState& state)
    : adjustment_(adjustment), state_(state), blocks_(blocks_of(state)) {
  ceres::Problem::Options options;
  options.enable_fast_removal = false;
  problem_ = std::make_unique<ceres::Problem>(options);
  used_.assign(static_cast<std::size_t>(blocks_.count()), 0);
  add_ties();
  add_known();
  add_priors();
}

double* Adjustment::Problem::pointer(int block) const {
  if (block < blocks_.knots) return state_.knots[static_cast<std::size_t>(block)].data();
  if (block < blocks_.knots + blocks_.delays)
    return &state_.delay_s[static_cast<std::size_t>(block - blocks_.knots)];
  if (block < blocks_.globals())
    return &state_.jitter_s[static_cast<std::size_t>(block - blocks_.knots - blocks_.delays)];
  return state_.globals.data();
}

Adjustment::Summary Adjustment::Problem::solve(const AdjustmentOptions& options) {
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // As fast as others at this size and structure, and without threads of its own.
  o.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  o.max_num_iterations = options.iterations;
  o.function_tolerance = 1e-6;
  o.num_threads = std::max(1, options.threads);
  o.logging_type = ceres::SILENT;
  o.use_nonmonotonic_steps = false;
  ceres::Solver::Summary s;
  ceres::Solve(o, problem_.get(), &s);
  return {s.IsSolutionUsable(), static_cast<int>(s.iterations.size()), s.total_time_in_seconds};
}

std::unique_ptr<Adjustment::Linear> Adjustment::Problem::linearise() const {
  auto out = std::make_unique<Linear>();
  ceres::Problem::EvaluateOptions o;
  out->first_column.assign(used_.size(), -1);
  int column = 0;
  for (int b = 0; b < blocks_.count(); ++b) {
    if (!used_[static_cast<std::size_t>(b)]) continue;
    o.parameter_blocks.push_back(pointer(b));
    out->first_column[static_cast<std::size_t>(b)] = column;
    column += b == blocks_.globals() ? static_cast<int>(free_globals_.size()) : blocks_.size(b);
  }
  for (const auto& r : rows_) {
    o.residual_blocks.push_back(r.id);
    for (int k = 0; k < r.size; ++k) {
      out->kind.push_back(r.kind);
      out->component.push_back(r.kind == Knots ? k % 6 : 0);
    }
  }
  ceres::CRSMatrix crs;
  std::vector<double> residuals;
  double cost = 0.0;
  if (!const_cast<ceres::Problem&>(*problem_).Evaluate(o, &cost, &residuals, nullptr, &crs))
    return out;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(crs.values.size());
  for (int r = 0; r < crs.num_rows; ++r)
    for (int k = crs.rows[static_cast<std::size_t>(r)];
         k < crs.rows[static_cast<std::size_t>(r) + 1]; ++k)
      if (crs.values[static_cast<std::size_t>(k)] != 0.0)
        entries.emplace_back(r, crs.cols[static_cast<std::size_t>(k)],
                             crs.values[static_cast<std::size_t>(k)]);
  out->jacobian.resize(crs.num_rows, crs.num_cols);
  out->jacobian.setFromTriplets(entries.begin(), entries.end());
  out->residuals = Eigen::Map<const Eigen::VectorXd>(residuals.data(),
                                                     static_cast<Eigen::Index>(residuals.size()));
  const Eigen::SparseMatrix<double> normal = out->jacobian.transpose() * out->jacobian;
  out->normal.compute(normal);
  out->good = out->normal.info() == Eigen::Success;
  return out;
}

void Adjustment::Problem::add(ceres::CostFunction* cost, const std::vector<int>& blocks,
                              Kind kind) {
  std::vector<double*> pointers;
  for (const int b : blocks) {
    pointers.push_back(pointer(b));
    used_[static_cast<std::size_t>(b)] = 1;
  }
  const int size = cost->num_residuals();
  rows_.push_back({problem_->AddResidualBlock(cost, nullptr, pointers), size, kind});
}

std::vector<int> Adjustment::Problem::blocks_of_frames(std::initializer_list<int> frames) const {
  std::vector<int> blocks;
  Evaluated e;
  for (const int f : frames) {
    adjustment_.evaluate(f, state_, true, e);
    for (int k = 0; k < e.count; ++k) {
      const int b = e.slots[static_cast<std::size_t>(k)].block;
      if (std::find(blocks.begin(), blocks.end(), b) == blocks.end()) blocks.push_back(b);
    }
  }
  return blocks;
}

void Adjustment::Problem::add_ties() {
  for (const TieGroup& group : adjustment_.groups) {
    if (group.astray ||
        std::all_of(group.ties.begin(), group.ties.end(), [](const Tie& t) { return t.held_out; }))
      continue;
    std::vector<int> blocks = blocks_of_frames({group.host, group.frame});
    auto* cost = new TieCost(adjustment_, group, blocks);
    add(cost, blocks, Ties);
  }
}

void Adjustment::Problem::add_known() {
  for (const KnownPoint& point : adjustment_.known_points) {
    const std::vector<int> blocks = blocks_of_frames({point.frame});
    add(new KnownPointCost(adjustment_, point, blocks), blocks, Known);
  }
  for (const KnownHeight& height : adjustment_.known_heights) {
    if (!(height.robust > 0.0)) continue;
    const auto [knot, weight] = adjustment_.knot_place(height.t_s);
    std::vector<int> blocks{blocks_.globals(), knot};
    if (weight > 0.0) blocks.push_back(knot + 1);
    add(new KnownHeightCost(height, weight), blocks, Known);
  }
}

void Adjustment::Problem::add_priors() {
  const AdjustmentPriors& p = adjustment_.priors;
  const bool first = adjustment_.before_first.has_value();
  const auto& t = adjustment_.knot_times_s;
  for (std::size_t k = 0; k < t.size(); ++k) {
    const int block = static_cast<int>(k);
    Eigen::VectorXd keep = Eigen::VectorXd::Zero(6), sigma = p.knot;
    if (k > 0) {
      const double dt = t[k] - t[k - 1];
      for (int c = 0; c < 6; ++c) {
        keep[c] = std::exp(-dt / (c < 3 ? p.position_correlation_s : p.attitude_correlation_s));
        sigma[c] *= std::sqrt(std::max(1e-12, 1.0 - keep[c] * keep[c]));
      }
      add(new LinkCost(keep, sigma, Eigen::VectorXd::Zero(6), true), {block, block - 1}, Knots);
    } else if (!first) {
      add(new LinkCost(keep, sigma, Eigen::VectorXd::Zero(6), false), {block}, Knots);
    }
  }
  const auto one = [](double x) { return Eigen::VectorXd(Eigen::VectorXd::Constant(1, x)); };
  const bool any_delayed = std::any_of(adjustment_.frames.begin(), adjustment_.frames.end(),
                                       [](const AdjustedFrame& f) { return f.delayed && !f.own; });
  if (any_delayed && !adjustment_.delay_knot_times_s.empty()) {
    const auto& d = adjustment_.delay_knot_times_s;
    for (std::size_t k = 0; k < d.size(); ++k) {
      const int block = blocks_.delay(static_cast<int>(k));
      if (k == 0 && first) continue;
      if (k == 0)
        add(new LinkCost(one(0), one(p.delay_s), one(adjustment_.delay_start_s), false), {block},
            Delays);
      else if (const double dt = d[k] - d[k - 1]; k == 1 || !(p.delay_rate > 0.0))
        add(new LinkCost(one(1), one(std::hypot(p.delay_walk_s * std::sqrt(dt), p.delay_rate * dt)),
                         one(0), true),
            {block, block - 1}, Delays);
      else
        add(new RateCost(d[k - 1] - d[k - 2], dt, p.delay_walk_s), {block, block - 1, block - 2},
            Delays);
    }
  }
  for (int f = 0; f < blocks_.frames; ++f) {
    const int block = blocks_.jitter(f);
    if (!used_[static_cast<std::size_t>(block)] || (first && f == 0)) continue;
    add(new LinkCost(one(0), one(p.jitter_s), one(0), false), {block}, Jitters);
  }
  const int globals = blocks_.globals();
  std::vector<int> fixed;
  Eigen::VectorXd sigma(Globals::kSize);
  free_globals_.clear();
  for (int k = 0; k < Globals::kSize; ++k) {
    if (p.globals[k] > 0.0)
      free_globals_.push_back(k);
    else
      fixed.push_back(k);
    sigma[k] = p.globals[k] > 0.0 ? p.globals[k] : 1.0;
  }
  if (first)
    add_first();
  else
    add(new LinkCost(Eigen::VectorXd::Zero(Globals::kSize), sigma,
                     Eigen::VectorXd::Zero(Globals::kSize), false),
        {globals}, Shared);
  if (free_globals_.empty())
    problem_->SetParameterBlockConstant(pointer(globals));
  else if (!fixed.empty())
    problem_->SetManifold(pointer(globals), new ceres::SubsetManifold(Globals::kSize, fixed));
  if (free_globals_.empty()) used_[static_cast<std::size_t>(globals)] = 0;
}

void Adjustment::Problem::add_first() {
  std::vector<int> blocks;
  std::vector<std::vector<int>> columns;
  int column = 0;
  const auto lay = [&](int block) {
    std::vector<int> own;
    for (int k = 0; k < blocks_.size(block); ++k)
      own.push_back(block == blocks_.globals() && adjustment_.priors.globals[k] <= 0.0 ? -1
                                                                                       : column++);
    blocks.push_back(block);
    columns.push_back(std::move(own));
  };
  for (const int block : adjustment_.first_blocks()) lay(block);
  add(new FirstFrameCost(*adjustment_.before_first, std::move(columns)), blocks, First);
}

}  // namespace watersky::align
