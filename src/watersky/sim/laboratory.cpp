// SPDX-License-Identifier: MIT
#include "watersky/sim/laboratory.hpp"

#include <cmath>
#include <numbers>

#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kExtent_m = 8.0;
/// "Simple polygons like triangles and rectangles."
constexpr std::array<int, 8> kCorners{3, 4, 3, 4, 5, 4, 3, 6};

/// Sides that touch the circle, their normals about evenly spread: the sharpest corner, of a
/// triangle whose normals are 138° apart, lies 2.8 radii from the middle.
Outline tangent_polygon(Random& random, int corners, double radius_m) {
  const auto n = static_cast<std::size_t>(corners);
  std::vector<double> normal(n);
  const double first = random.uniform(0.0, kTurn), step = kTurn / corners;
  for (std::size_t i = 0; i < n; ++i)
    normal[i] = first + step * (static_cast<double>(i) + random.uniform(-0.075, 0.075));
  Outline outline;
  for (std::size_t i = 0; i < n; ++i) {
    const double next = i + 1 < n ? normal[i + 1] : normal[0] + kTurn;
    const double middle = 0.5 * (normal[i] + next);
    const double reach_m = radius_m / std::cos(0.5 * (next - normal[i]));
    outline.emplace_back(reach_m * std::cos(middle), reach_m * std::sin(middle));
  }
  return outline;
}

/// As wide as the circle, and longer.
Outline rectangle(Random& random, double radius_m) {
  const double half_m = radius_m * random.uniform(1.0, 1.5), turn = random.uniform(0.0, kTurn);
  const Eigen::Vector2d along(std::cos(turn), std::sin(turn)), across(-along.y(), along.x());
  return {half_m * along + radius_m * across, -half_m * along + radius_m * across,
          -half_m * along - radius_m * across, half_m * along - radius_m * across};
}

}  // namespace

Result<Sea> laboratory_sea(int seed, double x_azimuth_deg) {
  const double azimuth = x_azimuth_deg * kTurn / 360.0;
  Eigen::Matrix2d north_east_from_world;
  north_east_from_world << std::cos(azimuth), -std::sin(azimuth), std::sin(azimuth),
      std::cos(azimuth);
  Random random(static_cast<std::uint64_t>(seed), Stream::Patches);
  std::vector<Outline> outlines;
  for (std::size_t i = 0; i < kPaperPatches.size(); ++i) {
    const PaperPatch& patch = kPaperPatches[i];
    Outline outline = kCorners[i] == 4
                          ? rectangle(random, patch.inscribed_radius_m)
                          : tangent_polygon(random, kCorners[i], patch.inscribed_radius_m);
    const Eigen::Vector2d middle = centroid(outline);
    for (Eigen::Vector2d& corner : outline)
      corner = north_east_from_world * (corner - middle + Eigen::Vector2d(patch.x_m, -patch.y_m));
    outlines.push_back(std::move(outline));
  }
  return Sea::from_outlines(std::move(outlines), std::vector<bool>(kPaperPatches.size(), true),
                            {kExtent_m, kExtent_m});
}

}  // namespace watersky::sim
