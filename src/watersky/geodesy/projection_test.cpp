// SPDX-License-Identifier: MIT
#include "watersky/geodesy/projection.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <GeographicLib/TransverseMercator.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "support/matchers.hpp"

namespace watersky {
namespace {

using test::fails_with;
using test::succeeds;

Geodetic place(double lat_deg, double lon_deg, double height_m = 0) {
  return {Angle::degrees(lat_deg), Angle::degrees(lon_deg), height_m};
}

std::string chosen_for(double lat_deg, double lon_deg) {
  const auto projection = Projection::for_place(place(lat_deg, lon_deg));
  return projection ? projection->name() : projection.error().message;
}

TEST(Projection, ChoosesTheUtmZoneOfThePlace) {
  EXPECT_EQ(chosen_for(43.0, -87.9), "EPSG:32616");
  EXPECT_EQ(chosen_for(63.4, 10.4), "EPSG:32632");
  EXPECT_EQ(chosen_for(0.0, 0.0), "EPSG:32631");
  EXPECT_EQ(chosen_for(50.0, 179.99), "EPSG:32660");
  EXPECT_EQ(chosen_for(50.0, 180.0), "EPSG:32601");
  EXPECT_EQ(chosen_for(50.0, -180.0), "EPSG:32601");
  EXPECT_EQ(chosen_for(50.0, 190.0), "EPSG:32602");
}

TEST(Projection, ChoosesSouthernZonesSouthOfTheEquator) {
  EXPECT_EQ(chosen_for(-0.001, 0.0), "EPSG:32731");
  EXPECT_EQ(chosen_for(-54.8, -68.3), "EPSG:32719");
  EXPECT_EQ(chosen_for(-80.0, 0.0), "EPSG:32731");
}

TEST(Projection, KnowsTheExceptionsForNorwayAndSvalbard) {
  EXPECT_EQ(chosen_for(60.0, 4.0), "EPSG:32632");   // 32V, would be 31
  EXPECT_EQ(chosen_for(55.9, 4.0), "EPSG:32631");   // south of the exception
  EXPECT_EQ(chosen_for(64.1, 4.0), "EPSG:32631");   // north of it
  EXPECT_EQ(chosen_for(78.9, 8.9), "EPSG:32631");   // 31X, would be 32
  EXPECT_EQ(chosen_for(78.9, 9.1), "EPSG:32633");   // 33X, would be 32
  EXPECT_EQ(chosen_for(78.9, 11.9), "EPSG:32633");  // 33X, would be 32
  EXPECT_EQ(chosen_for(78.2, 20.9), "EPSG:32633");  // 33X, would be 34
  EXPECT_EQ(chosen_for(78.2, 21.1), "EPSG:32635");  // 35X, would be 34
  EXPECT_EQ(chosen_for(80.0, 32.9), "EPSG:32635");  // 35X, would be 36
  EXPECT_EQ(chosen_for(80.0, 33.1), "EPSG:32637");  // 37X, would be 36
  EXPECT_EQ(chosen_for(71.9, 11.9), "EPSG:32632");  // south of Svalbard's band
}

TEST(Projection, ChoosesPolarGridsBeyondUtm) {
  EXPECT_EQ(chosen_for(83.999, 11.9), "EPSG:32633");
  EXPECT_EQ(chosen_for(84.0, 11.9), "EPSG:3413");
  EXPECT_EQ(chosen_for(90.0, 0.0), "EPSG:3413");
  EXPECT_EQ(chosen_for(-80.001, 11.9), "EPSG:3031");
  EXPECT_EQ(chosen_for(-90.0, 0.0), "EPSG:3031");
}

TEST(Projection, RefusesPlacesThatAreNone) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const auto& [lat, lon] : {std::pair{nan, 0.0},
                                 {0.0, nan},
                                 {inf, 0.0},
                                 {0.0, inf},
                                 {-inf, 0.0},
                                 {90.1, 0.0},
                                 {-91.0, 5.0},
                                 {86.0, nan}})
    EXPECT_TRUE(fails_with(Projection::for_place(place(lat, lon)), ErrorCode::InvalidInput, {}))
        << lat << ", " << lon;
}

TEST(Projection, RefusesWhatIsNotAMapInMetres) {
  for (const char* crs :
       {"EPSG:4326", "EPSG:4978", "EPSG:5773", "EPSG:2263", "EPSG:999999", "nonsense", "",
        "+proj=longlat +datum=WGS84 +type=crs", "+proj=utm +zone=33 +units=us-ft +type=crs", "\n"})
    EXPECT_TRUE(fails_with(Projection::from_text(crs), ErrorCode::InvalidInput,
                           {"in metres, such as EPSG:32633"}))
        << crs;
}

// The map's columns would run west.
TEST(Projection, RefusesAxesThatRunWest) {
  EXPECT_TRUE(fails_with(Projection::from_text("EPSG:2048"), ErrorCode::InvalidInput, {"west"}));
}

TEST(Projection, TakesProjStringsAndWkt) {
  const auto by_code = Projection::from_text("EPSG:32633").value();
  const Eigen::Vector2d expected = by_code.forward(78.9_deg, 11.9_deg).value();
  for (const std::string& crs :
       {std::string("+proj=utm +zone=33 +datum=WGS84"),
        std::string("+proj=utm +zone=33 +datum=WGS84 +type=crs"), by_code.wkt()}) {
    const auto same = Projection::from_text(crs);
    ASSERT_TRUE(succeeds(same)) << crs;
    EXPECT_LT((same->forward(78.9_deg, 11.9_deg).value() - expected).norm(), 1e-6);
    EXPECT_EQ(same->name(), crs);
  }
  EXPECT_NE(by_code.wkt().find("32633"), std::string::npos);
}

// EPSG:32661 lists northing before easting, EPSG:5041 is the same grid the other way around.
TEST(Projection, GivesEastingFirstWhateverTheAxisOrder) {
  const auto ne = Projection::from_text("EPSG:32661").value();
  const auto en = Projection::from_text("EPSG:5041").value();
  const Eigen::Vector2d p = ne.forward(85_deg, 30_deg).value();
  EXPECT_LT((p - en.forward(85_deg, 30_deg).value()).norm(), 1e-6);
  EXPECT_GT(p.x(), 2e6);  // east of the meridian of Greenwich
  EXPECT_LT(p.y(), 2e6);  // on this side of the pole
}

TEST(Projection, AgreesWithGeographicLibOverSvalbard) {
  const auto utm33 = Projection::from_text("EPSG:32633").value();
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> lat(72, 84), lon(6, 24);
  for (int i = 0; i < 500; ++i) {
    const double lat_deg = lat(rng), lon_deg = lon(rng);
    double easting = 0, northing = 0, gamma_deg = 0, k = 0;
    GeographicLib::TransverseMercator::UTM().Forward(15.0, lat_deg, lon_deg, easting, northing,
                                                     gamma_deg, k);
    const ProjectedPlace here = utm33.at(place(lat_deg, lon_deg)).value();
    EXPECT_NEAR(here.easting_northing_m.x(), easting + 500e3, 1e-6);
    EXPECT_NEAR(here.easting_northing_m.y(), northing, 1e-6);
    EXPECT_NEAR(here.convergence().degrees(), gamma_deg, 1e-7);
    EXPECT_NEAR(here.scale(), k, 2e-9);
    // Conformal, and seen from above as the ground is: no mirror image.
    const Eigen::Matrix2d& grid = here.grid_from_north_east;
    EXPECT_NEAR(grid(0, 1), grid(1, 0), 3e-9);
    EXPECT_NEAR(grid(1, 1), -grid(0, 0), 3e-9);
  }
}

TEST(Projection, ConvergenceAtNyAlesundInUtm33IsMinusThreeDegrees) {
  const auto utm33 = Projection::for_place(place(78.9, 11.9)).value();
  const ProjectedPlace here = utm33.at(place(78.9, 11.9)).value();
  EXPECT_NEAR(here.convergence().degrees(), -3.042, 0.001);
  EXPECT_NEAR(here.scale(), 0.9996, 1e-4);
  // Grid north lies west of true north there, so walking true north is walking grid east.
  EXPECT_GT(here.grid_from_north_east(0, 0), 0.05);
}

TEST(Projection, MetresAreThoseAtThePlacesHeight) {
  const auto utm33 = Projection::from_text("EPSG:32633").value();
  const double at_sea = utm33.at(place(78.9, 11.9, 0)).value().scale();
  const double high = utm33.at(place(78.9, 11.9, 6400)).value().scale();
  EXPECT_NEAR(at_sea / high, 1.001, 2e-6);
}

// EPSG:3575, the polar azimuthal equal-area grid (central meridian 10 E) is not conformal.
// Snyder, Map Projections: a Working Manual (1987), (3-12), (14-15), (21-30), (24-23): rho = a
// √(q_p - q), k = rho / (a m), h = 1/k.
TEST(Projection, EqualAreaGridHasItsOwnScaleAlongEachAxis) {
  const auto laea = Projection::from_text("EPSG:3575").value();
  constexpr double kA = 6378137.0, kF = 1 / 298.257223563, kE2 = kF * (2 - kF);
  const double e = std::sqrt(kE2);
  const auto q_of = [&](double s) {
    return (1 - kE2) * (s / (1 - kE2 * s * s) - std::log((1 - e * s) / (1 + e * s)) / (2 * e));
  };
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> lat(50, 89.9), lon(-180, 180);
  for (int i = 0; i < 300; ++i) {
    const Angle phi = Angle::degrees(lat(rng)), lambda = Angle::degrees(lon(rng));
    const double s = sin(phi);
    const double rho = kA * std::sqrt(q_of(1) - q_of(s));
    const double k = rho / (kA * cos(phi) / std::sqrt(1 - kE2 * s * s)), h = 1 / k;
    const Angle theta = lambda - 10_deg;
    const ProjectedPlace here = laea.at({phi, lambda, 0}).value();
    EXPECT_LT(
        (here.easting_northing_m - Eigen::Vector2d(rho * sin(theta), -rho * cos(theta))).norm(),
        1e-5);
    Eigen::Matrix2d expected;
    expected << -h * sin(theta), k * cos(theta), h * cos(theta), k * sin(theta);
    EXPECT_LT((here.grid_from_north_east - expected).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_NEAR(here.scale(), h, 1e-7);
    EXPECT_NEAR(here.grid_from_north_east.determinant(), -1.0, 1e-7);
  }
}

TEST(Projection, SeesTheAntimeridianLikeAnyOtherPlace) {
  for (const double lat_deg : {71.3, -77.85}) {
    for (const char* crs : {"EPSG:32660", "EPSG:32601", "EPSG:3413", "EPSG:3832", "EPSG:3395"}) {
      const auto projection = Projection::from_text(crs).value();
      const auto west = projection.at(place(lat_deg, 179.9)).value();
      const auto on = projection.at(place(lat_deg, 180.0));
      ASSERT_TRUE(succeeds(on)) << crs;
      EXPECT_LT((west.grid_from_north_east - on->grid_from_north_east).norm(),
                0.01 * on->grid_from_north_east.norm())
          << crs << " at " << lat_deg;
    }
  }
}

TEST(Projection, InverseUndoesForward) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const auto& [crs, lat0, lon0] : {std::tuple{"EPSG:32633", 78.0, 15.0},
                                        {"EPSG:32719", -54.0, -69.0},
                                        {"EPSG:3413", 86.0, 0.0},
                                        {"EPSG:3031", -86.0, 0.0},
                                        {"EPSG:3575", 80.0, 20.0},
                                        {"EPSG:25833", 78.0, 15.0}}) {
    const auto projection = Projection::from_text(crs).value();
    for (int i = 0; i < 200; ++i) {
      const Angle lat = Angle::degrees(lat0 + 3.9 * unit(rng));
      const Angle lon = Angle::degrees(lon0 + 5 * unit(rng));
      const Geodetic back = projection.inverse(projection.forward(lat, lon).value()).value();
      // PROJ inverts the authalic latitude of EPSG:3575 by a series good to 0.1 mm.
      EXPECT_LT(std::abs((back.latitude - lat).radians()) * 6.4e6, 1e-4) << crs;
      EXPECT_LT(std::abs((back.longitude - lon).wrapped().radians() * cos(lat)) * 6.4e6, 1e-5)
          << crs;
      EXPECT_EQ(back.height_ellipsoid_m, 0.0);
    }
  }
}

TEST(Projection, SaysWhenAPlaceIsOutsideIt) {
  const auto utm33 = Projection::from_text("EPSG:32633").value();
  const double nan = std::nan("");
  EXPECT_TRUE(
      fails_with(utm33.forward(Angle::degrees(nan), 0_deg), ErrorCode::OutOfRange, {"EPSG:32633"}));
  EXPECT_TRUE(fails_with(utm33.forward(95_deg, 0_deg), ErrorCode::OutOfRange, {"EPSG:32633"}));
  EXPECT_TRUE(fails_with(utm33.inverse({nan, 0.0}), ErrorCode::OutOfRange, {"EPSG:32633"}));
  EXPECT_TRUE(fails_with(utm33.inverse({1e30, 1e30}), ErrorCode::OutOfRange, {"EPSG:32633"}));
  EXPECT_TRUE(fails_with(utm33.at(place(nan, 0)), ErrorCode::OutOfRange, {"EPSG:32633"}));
}

TEST(Projection, CopiesMayBeUsedFromSeveralThreads) {
  const auto utm33 = Projection::from_text("EPSG:32633").value();
  const Eigen::Vector2d expected = utm33.forward(78.9_deg, 11.9_deg).value();
  std::vector<std::thread> threads;
  std::array<bool, 4> same{};
  for (std::size_t t = 0; t < same.size(); ++t)
    threads.emplace_back([&, t, copy = utm33] {
      same[t] = true;
      for (int i = 0; i < 500; ++i) {
        const double far = (i % 7) * 0.5;
        if (!copy.forward(Angle::degrees(70 + far), 11.9_deg).ok()) same[t] = false;
        if (copy.forward(78.9_deg, 11.9_deg).value() != expected) same[t] = false;
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(same, (std::array{true, true, true, true}));
}

// The values that NGA publishes with its EGM96 programs, for their own interpolation, which
// differs from the bilinear one by less than 6 cm at these places.
TEST(Egm96, AgreesWithThePublishedTestPoints) {
  if (!egm96_above_ellipsoid_m(0_deg, 0_deg).ok()) GTEST_SKIP() << "proj-data is not installed";
  for (const auto& [lat, lon, height_m] : {std::tuple{38.6281550, 269.7791550, -31.628},
                                           {-14.6212170, 305.0211140, -2.969},
                                           {46.8743190, 102.4487290, -43.575},
                                           {-23.6174460, 133.8747120, 15.871},
                                           {38.6254730, 359.9995000, 50.066},
                                           {-0.4667440, 0.0023000, 17.329}})
    EXPECT_NEAR(egm96_above_ellipsoid_m(Angle::degrees(lat), Angle::degrees(lon)).value(), height_m,
                0.06)
        << lat << ", " << lon;
}

// By PROJ's own program: cct +proj=vgridshift +grids=egm96_15.gtx +multiplier=1.
TEST(Egm96, AgreesWithCct) {
  if (!egm96_above_ellipsoid_m(0_deg, 0_deg).ok()) GTEST_SKIP() << "proj-data is not installed";
  EXPECT_NEAR(egm96_above_ellipsoid_m(78.9_deg, 11.9_deg).value(), 36.5647, 1e-4);
  EXPECT_NEAR(egm96_above_ellipsoid_m(78.2_deg, 15.6_deg).value(), 32.1900, 1e-4);
  EXPECT_NEAR(egm96_above_ellipsoid_m(90_deg, 0_deg).value(), 13.6062, 1e-4);
  EXPECT_NEAR(egm96_above_ellipsoid_m(0_deg, 180_deg).value(), 21.1533, 1e-4);
}

TEST(Egm96, IsOneSurfaceAcrossTheAntimeridian) {
  if (!egm96_above_ellipsoid_m(0_deg, 0_deg).ok()) GTEST_SKIP() << "proj-data is not installed";
  for (const double lat : {-77.85, 0.1, 71.3}) {
    const auto at = [&](double lon) {
      return egm96_above_ellipsoid_m(Angle::degrees(lat), Angle::degrees(lon)).value();
    };
    EXPECT_NEAR(at(179.9999), at(-179.9999), 1e-3);
    EXPECT_NEAR(at(-170), at(190), 1e-9);
  }
}

TEST(Egm96, RefusesPlacesThatAreNone) {
  if (!egm96_above_ellipsoid_m(0_deg, 0_deg).ok()) GTEST_SKIP() << "proj-data is not installed";
  const Angle nan = Angle::degrees(std::nan(""));
  EXPECT_TRUE(fails_with(egm96_above_ellipsoid_m(nan, 0_deg), ErrorCode::OutOfRange, {"EGM96"}));
  EXPECT_TRUE(fails_with(egm96_above_ellipsoid_m(0_deg, nan), ErrorCode::OutOfRange, {"EGM96"}));
  EXPECT_TRUE(fails_with(egm96_above_ellipsoid_m(95_deg, 0_deg), ErrorCode::OutOfRange, {"EGM96"}));
}

}  // namespace
}  // namespace watersky
