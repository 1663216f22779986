// SPDX-License-Identifier: MIT
#pragma once
/// Points on a regular lattice, seen in perspective and through a lens, among others.
#include <Eigen/Core>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "watersky/target_calibration/target.hpp"

namespace watersky::detail {

struct LatticeCandidate {
  Eigen::Vector2d position;
  double size = 1.0;  ///< of the spot; neighbours' sizes are alike
};

/// Column and row of a lattice → index of the candidate there.
using Lattice = std::map<std::pair<int, int>, std::size_t>;

/// The largest lattice among `candidates`, in any basis; empty if there is none of nine points.
[[nodiscard]] Lattice find_lattice(const std::vector<LatticeCandidate>& candidates);

/// A lattice read as a target: columns to the right, rows down, from (0, 0).
struct ReadLattice {
  TargetKind kind = TargetKind::Circles;
  TargetSize size;    ///< of the box around what is seen, counted as `kind` counts
  Lattice points;     ///< of an asymmetric grid, columns are in half steps
  double fill = 0.0;  ///< share of the box's places that are seen
};

/// The reading that fills its box best; nullopt when none fills two thirds. `kind` none: either
/// kind of circles. With a `size`, whatever does not fit into it is cut off.
[[nodiscard]] std::optional<ReadLattice> read_lattice(
    const Lattice& lattice, const std::vector<LatticeCandidate>& candidates,
    std::optional<TargetKind> kind, std::optional<TargetSize> size);

}  // namespace watersky::detail
