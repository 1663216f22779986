// SPDX-License-Identifier: MIT
#pragma once
/// The outlines of floes: simple polygons on the sea.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace watersky::sim {

class Random;

/// Corners (north, east) in metres around the scene's anchor; closed, the last point not
/// repeated; in either sense.
using Outline = std::vector<Eigen::Vector2d>;

/// Signed: positive when the corners run from north to east (clockwise seen from above).
[[nodiscard]] double signed_area_m2(const Outline& outline);
/// Of the area, not of the corners.
[[nodiscard]] Eigen::Vector2d centroid(const Outline& outline);
/// The largest caliper: the greatest distance between two corners.
[[nodiscard]] double max_length_m(const Outline& outline);
/// By crossing number, in time proportional to the corners. Points on an edge are in or out.
[[nodiscard]] bool contains(const Outline& outline, const Eigen::Vector2d& north_east_m);
/// The smallest distance between the edges of two outlines; 0 when they cross.
[[nodiscard]] double distance_m(const Outline& a, const Outline& b);
/// Whether no two edges cross, by trying all pairs.
[[nodiscard]] bool is_simple(const Outline& outline);

struct OutlineShape {
  double angularity = 0.22;  ///< one sigma of the corners' distances from the middle, relative
  double elongation = 0.22;  ///< one sigma of ln(length / width) / 2, at most 0.4
  double roughness = 0.02;   ///< amplitude of the small irregularities, relative to the size
  double corner_m = 0.25;    ///< wanted distance between neighbouring corners
};

/// A broken-off piece of ice: some straight sides, rounded corners, no symmetry; its centroid at
/// (0, 0), its area that of a disc of `diameter_m`. Seen from a point inside, the corners run
/// round in order, so it never crosses itself.
[[nodiscard]] Outline random_outline(Random& random, double diameter_m, const OutlineShape& shape);

}  // namespace watersky::sim
