// SPDX-License-Identifier: MIT
#pragma once
/// The adjustment as Ceres sees it, and its normal equations. For adjustment*.cpp alone.
#include <ceres/ceres.h>

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "watersky/align/detail/sea_transfer.hpp"

namespace watersky::align {

/// Where a frame's parameters are.
struct Adjustment::Slot {
  int block = -1;
  int size = 0;
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, Globals::kSize> by;
};

struct Adjustment::Evaluated {
  ModelCamera camera;
  double t_s = 0.0;
  std::array<Slot, 6> slots;
  int count = 0;
};

/// Blocks in one row: knots, delay knots, jitters, globals.
struct Blocks {
  int knots = 0, delays = 0, frames = 0;
  [[nodiscard]] int delay(int i) const { return knots + i; }
  [[nodiscard]] int jitter(int i) const { return knots + delays + i; }
  [[nodiscard]] int globals() const { return knots + delays + frames; }
  [[nodiscard]] int count() const { return globals() + 1; }
  [[nodiscard]] int size(int block) const {
    if (block < knots) return 6;
    return block == globals() ? Globals::kSize : 1;
  }
};

[[nodiscard]] Blocks blocks_of(const AdjustmentState& s);

/// Rows and columns at the present state.
struct Adjustment::Linear {
  Eigen::SparseMatrix<double> jacobian;
  Eigen::VectorXd residuals;
  std::vector<int> kind;          ///< of each row
  std::vector<int> component;     ///< of a knot's row: 0 to 5
  std::vector<int> first_column;  ///< of each block; -1: not in it
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> normal;
  bool good = false;
};

/// The Ceres problem, and its rows by what they assume.
class Adjustment::Problem {
 public:
  enum Kind { Ties, Knots, Delays, Jitters, Shared, Known, First };

  Problem(const Adjustment& adjustment, AdjustmentState& state);

  [[nodiscard]] double* pointer(int block) const;

  Summary solve(const AdjustmentOptions& options);

  std::unique_ptr<Linear> linearise() const;

  [[nodiscard]] const std::vector<int>& free_globals() const { return free_globals_; }
  [[nodiscard]] const Blocks& blocks() const { return blocks_; }

 private:
  struct Rows {
    ceres::ResidualBlockId id;
    int size;
    Kind kind;
  };

  void add(ceres::CostFunction* cost, const std::vector<int>& blocks, Kind kind);

  std::vector<int> blocks_of_frames(std::initializer_list<int> frames) const;

  void add_ties();

  void add_known();

  void add_priors();

  /// In the order of FirstFramePrior.
  void add_first();

  const Adjustment& adjustment_;
  AdjustmentState& state_;
  Blocks blocks_;
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<Rows> rows_;
  std::vector<char> used_;
  std::vector<int> free_globals_;
};

}  // namespace watersky::align
