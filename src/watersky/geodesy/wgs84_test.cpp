// SPDX-License-Identifier: MIT
#include "watersky/geodesy/wgs84.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "support/matchers.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky {
namespace {

using test::IsNear;

// The frames of the Earth do not mix.
static_assert(CanChain<Rigid3<Ecef, World>, Point<World>>);
static_assert(!CanChain<Rigid3<Ecef, World>, Point<Ecef>>);
static_assert(!CanChain<Rigid3<Ecef, World>, Point<Sea>>);
static_assert(!CanChain<Rigid3<Ecef, World>, Rigid3<Ecef, Sea>>);
static_assert(!std::is_constructible_v<Geodetic, double, double, double>);
static_assert(!std::is_invocable_v<decltype(&Datum::geodetic), Datum, Point<Ecef>>);

constexpr double kMicrometre = 1e-6;

/// The rows of a table of tests/reference, without its header.
std::vector<std::vector<double>> reference(const std::string& name) {
  std::ifstream file(WATERSKY_SOURCE_DIR "/tests/reference/" + name);
  std::vector<std::vector<double>> rows;
  std::string line, cell;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    auto& row = rows.emplace_back();
    while (std::getline(cells, cell, ',')) row.push_back(std::stod(cell));
  }
  return rows;
}

Geodetic geodetic(double lat_deg, double lon_deg, double height_m) {
  return {Angle::degrees(lat_deg), Angle::degrees(lon_deg), height_m};
}

/// How far apart two positions are: north, east, up in metres, from their angles alone, the
/// radius taken 1 % too large. Longitude counts modulo a turn, and not at all at a pole.
Eigen::Vector3d apart_m(const Geodetic& a, const Geodetic& b) {
  constexpr double kRadius_m = 6.44e6;
  return {kRadius_m * (a.latitude - b.latitude).radians(),
          kRadius_m * cos(b.latitude) * (a.longitude - b.longitude).wrapped().radians(),
          a.height_ellipsoid_m - b.height_ellipsoid_m};
}

TEST(Wgs84, EcefAgreesWithTheReferenceTableBothWays) {
  const auto rows = reference("wgs84_ecef.csv");
  ASSERT_EQ(rows.size(), 264u);
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), 6u);
    const Geodetic place = geodetic(row[0], row[1], row[2]);
    const Point<Ecef> p{{row[3], row[4], row[5]}};
    EXPECT_THAT(ecef_from(place), IsNear(p, kMicrometre)) << row[0] << ", " << row[1];
    EXPECT_LT(apart_m(geodetic_from(p), place).cwiseAbs().maxCoeff(), kMicrometre)
        << row[0] << ", " << row[1];
  }
}

TEST(Datum, WorldAgreesWithTheReferenceTableBothWays) {
  const auto rows = reference("wgs84_world.csv");
  ASSERT_EQ(rows.size(), 39u);
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), 10u);
    const Datum datum(geodetic(row[0], row[1], row[2]), Angle::degrees(row[3]));
    const Geodetic place = geodetic(row[4], row[5], row[6]);
    const Point<World> p{{row[7], row[8], row[9]}};
    EXPECT_THAT(datum.world(place), IsNear(p, kMicrometre)) << row[0] << ", azimuth " << row[3];
    EXPECT_LT(apart_m(datum.geodetic(p), place).cwiseAbs().maxCoeff(), kMicrometre)
        << row[0] << ", azimuth " << row[3];
  }
}

TEST(Datum, ItsOriginIsWorldsOrigin) {
  const Datum datum(geodetic(78.9, 11.9, 30), 33_deg);
  EXPECT_THAT(datum.world(datum.origin()), IsNear(Point<World>{}, 1e-8));
  EXPECT_EQ(datum.x_azimuth(), 33_deg);
  EXPECT_NEAR(datum.geodetic({{0, 0, -12.5}}).height_ellipsoid_m, 42.5, kMicrometre);
}

TEST(Datum, FirstAxisPointsAlongItsAzimuthClockwiseFromNorth) {
  const Geodetic origin = geodetic(78.9, 11.9, 0);
  const Datum east_first(origin, 90_deg);
  const Geodetic p = east_first.geodetic({{10.0, 0.0, 0.0}});
  EXPECT_GT(p.longitude, origin.longitude);
  EXPECT_NEAR(apart_m(p, origin).x(), 0.0, 1e-4);
  // The second axis lies clockwise of the first: south.
  EXPECT_LT(east_first.geodetic({{0.0, 10.0, 0.0}}).latitude, origin.latitude);
}

// A plane from the datum is 8 m off at 10 km and 196 m at 50 km (docs: why every frame uses the
// tangent plane of the sea under its own camera).
TEST(Datum, TheSeaFallsAwayBelowTheDatumsPlane) {
  const Datum datum(geodetic(78.9, 11.9, 0));
  EXPECT_NEAR(datum.geodetic({{0.0, 10e3, 0.0}}).height_ellipsoid_m, 7.8, 0.1);
  EXPECT_NEAR(datum.geodetic({{0.0, 50e3, 0.0}}).height_ellipsoid_m, 195.5, 1.0);
}

class NedRotation : public ::testing::Test {
 protected:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  std::mt19937 rng_{11};
};

// The axes of north, east, down are the derivatives of the position by latitude, longitude and
// height.
TEST_F(NedRotation, AxesAreTheDerivativesOfThePosition) {
  for (int i = 0; i < 200; ++i) {
    const Datum datum(geodetic(uniform(-89, 89), uniform(-180, 180), uniform(-100, 1000)),
                      Angle::degrees(uniform(-180, 180)));
    const Geodetic place =
        datum.geodetic({{uniform(-2e5, 2e5), uniform(-2e5, 2e5), uniform(-2e4, 0)}});
    if (std::abs(place.latitude.degrees()) > 89.5) continue;
    const auto step = [&](double lat, double lon, double height_m) {
      constexpr double kStep = 1e-6;  // rad, and 6.4 m
      const Angle dlat = Angle::radians(kStep * lat), dlon = Angle::radians(kStep * lon);
      const double dh = 6.4e6 * kStep * height_m;
      const Vector<World> d = datum.world({place.latitude + dlat, place.longitude + dlon,
                                           place.height_ellipsoid_m + dh}) -
                              datum.world({place.latitude - dlat, place.longitude - dlon,
                                           place.height_ellipsoid_m - dh});
      return d.v.normalized().eval();
    };
    const Eigen::Matrix3d r = datum.world_from_ned_rotation(place).toRotationMatrix();
    EXPECT_LT((r.col(0) - step(1, 0, 0)).norm(), 1e-7);
    EXPECT_LT((r.col(1) - step(0, 1, 0)).norm(), 1e-7);
    EXPECT_LT((r.col(2) + step(0, 0, 1)).norm(), 1e-7);
    EXPECT_NEAR(r.determinant(), 1.0, 1e-12);
  }
}

// 40 km east of the datum at 78.9 N: by hand, local north seen from the datum is
// (sin² cos Δ + cos², -sin Δ sin, …) of the latitude, with Δ the difference in longitude.
TEST_F(NedRotation, MeridiansConvergeFortyKilometresEast) {
  const Datum datum(geodetic(78.9, 11.9, 0));
  const Geodetic east_40_km = geodetic(78.9, 13.76, 0);
  ASSERT_NEAR(datum.world(east_40_km).v.y(), 40e3, 50.0);
  const double s = sin(78.9_deg), c = cos(78.9_deg), d = (1.86_deg).radians();
  const double by_hand = std::atan2(-s * std::sin(d), s * s * std::cos(d) + c * c);
  const YawPitchRoll turn = yaw_pitch_roll(datum.world_from_ned_rotation(east_40_km));
  EXPECT_NEAR(turn.yaw.radians(), by_hand, 1e-12);
  EXPECT_NEAR(turn.yaw.degrees(), -1.825, 0.001);
  EXPECT_NEAR(
      angle_between(datum.world_from_ned_rotation(datum.origin()), Eigen::Quaterniond::Identity())
          .radians(),
      0.0, 1e-12);
}

TEST(EcefFromSea, StandsOnThePlaceWithDownTowardsTheEarth) {
  const Geodetic place = geodetic(-54.8, -68.3, 17.5);
  const Rigid3<Ecef, Sea> ecef_from_here = ecef_from_sea(place);
  EXPECT_THAT(ecef_from_here.origin(), IsNear(ecef_from(place), 0.0));
  const Geodetic up = geodetic_from(ecef_from_here * Point<Sea>{{0, 0, -100}});
  EXPECT_LT((apart_m(up, place) - Eigen::Vector3d(0, 0, 100)).norm(), kMicrometre);
  EXPECT_GT(geodetic_from(ecef_from_here * Point<Sea>{{10, 0, 0}}).latitude, place.latitude);
  EXPECT_GT(geodetic_from(ecef_from_here * Point<Sea>{{0, 10, 0}}).longitude, place.longitude);
}

}  // namespace
}  // namespace watersky
