// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <random>

#include "watersky/mapping/mapping.hpp"

namespace watersky {
namespace {

// The design's promise: the same floe 40 km from the datum, seen by cameras in different places,
// falls into the same cell. A point of the sea is carried to the grid through two tangent planes
// and, independently, through PROJ alone.
TEST(MapReference, TangentPlanesOfNeighbouringCamerasMeetInTheGrid) {
  std::mt19937 rng(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const char* crs : {"EPSG:32633", "EPSG:3413", "EPSG:3575"}) {
    const MapReference reference{Projection::from_text(crs).value(), 256000.0, 1024000.0, 0.5};
    for (int i = 0; i < 50; ++i) {
      const Geodetic floe{Angle::degrees(78.9 + 0.35 * uniform(rng)),
                          Angle::degrees(11.9 + 1.8 * uniform(rng)), 30.0};
      const Eigen::Vector2d by_proj =
          reference.grid(reference.projection.forward(floe.latitude, floe.longitude).value());
      for (int camera = 0; camera < 2; ++camera) {
        const Geodetic below = geodetic_from(
            ecef_from_sea(floe) * Point<Sea>{{200 * uniform(rng), 200 * uniform(rng), 0}});
        const Geodetic on_sea{below.latitude, below.longitude, 30.0};
        const Eigen::Vector3d ne = (ecef_from_sea(on_sea).inverse() * ecef_from(floe)).v;
        const Eigen::Vector2d by_plane =
            (reference.sea_from_grid(on_sea).value().inverse() * ne.head<2>().homogeneous())
                .head<2>();
        EXPECT_LT((by_plane - by_proj).norm() * reference.cell_m, 0.01) << crs;
      }
    }
  }
}

TEST(MapReference, RowsRunSouthAndColumnsEast) {
  const MapReference reference{Projection::from_text("EPSG:32633").value(), 1000.0, 5000.0, 2.0};
  EXPECT_EQ(reference.easting_northing_m(0, 0), Eigen::Vector2d(1001, 4999));
  EXPECT_EQ(reference.easting_northing_m(3, 1), Eigen::Vector2d(1007, 4997));
  EXPECT_EQ(reference.grid({1007, 4997}), Eigen::Vector2d(3, 1));
  const auto t = reference.geotransform({3, 1, 10, 10});
  EXPECT_EQ(t, (std::array<double, 6>{1006, 2, 0, 4998, 0, -2}));
}

// The homography includes the convergence: true north of a place in UTM 33 at 78.9 N 11.9 E lies
// 3.0° east of grid north's opposite, so going north moves the column by +sin(3°).
TEST(MapReference, TrueNorthIsTurnedByTheConvergence) {
  const MapReference reference{Projection::from_text("EPSG:32633").value(), 432640.0, 8759040.0,
                               1.0};
  const Geodetic place{Angle::degrees(78.9), Angle::degrees(11.9), 0.0};
  const Eigen::Matrix3d grid_from_sea = reference.sea_from_grid(place).value().inverse();
  const Eigen::Vector2d north =
      (grid_from_sea * Eigen::Vector3d(100, 0, 1) - grid_from_sea * Eigen::Vector3d(0, 0, 1))
          .head<2>();
  const double turn_deg = std::atan2(north.x(), -north.y()) * 180 / M_PI;
  EXPECT_NEAR(turn_deg, 3.04, 0.05);
}

}  // namespace
}  // namespace watersky
