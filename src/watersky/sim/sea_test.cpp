// SPDX-License-Identifier: MIT
#include "watersky/sim/sea.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "watersky/geodesy/wgs84.hpp"
#include "watersky/sim/detail/earth.hpp"
#include "watersky/sim/detail/random.hpp"
#include "watersky/sim/sea_parameters.hpp"

namespace watersky::sim {
namespace {

SeaParameters small_sea(int seed) {
  SeaParameters p;
  p.sea_seed = seed;
  p.extent_north_m = 150.0;
  p.extent_east_m = 110.0;
  p.floe_max_m = 30.0;
  p.isolated_count = 8;
  p.isolated_max_m = 8.0;
  p.concentration = 0.35;
  return p;
}

TEST(RandomOutline, IsSimpleOfTheAskedAreaAroundZeroAndLikeNoMirrorImage) {
  Random random(3);
  for (int i = 0; i < 400; ++i) {
    const double diameter = std::exp(random.uniform(0.0, 4.5));
    const Outline outline = random_outline(random, diameter, {});
    EXPECT_TRUE(is_simple(outline)) << i;
    EXPECT_NEAR(std::abs(signed_area_m2(outline)), std::numbers::pi / 4 * diameter * diameter,
                1e-9 * diameter * diameter);
    EXPECT_LT(centroid(outline).norm(), 1e-9 * diameter);
    EXPECT_GE(max_length_m(outline), diameter);  // the disc is the shortest for its area
    EXPECT_LT(max_length_m(outline), 3.0 * diameter);
    // Share of the area that a mirror in the east axis does not cover with itself.
    int alone = 0, inside = 0;
    for (int k = 0; k < 2000; ++k) {
      const Eigen::Vector2d p(random.uniform(-1, 1) * diameter, random.uniform(-1, 1) * diameter);
      if (!contains(outline, p)) continue;
      ++inside;
      if (!contains(outline, {-p.x(), p.y()})) ++alone;
    }
    EXPECT_GT(alone, 0.005 * inside) << i;
  }
}

TEST(Sea, AnswersEveryPointAsTheOutlinesDo) {
  const Sea sea = make_sea(small_sea(4)).value();
  Random random(5);
  int ice = 0;
  const auto check = [&](double north, double east) {
    int expected = -1;
    for (std::size_t i = 0; i < sea.pieces().size(); ++i)
      if (contains(sea.pieces()[i], {north, east})) expected = static_cast<int>(i);
    ice += expected >= 0;
    EXPECT_EQ(sea.object_at(north, east), expected) << north << ' ' << east;
  };
  for (int i = 0; i < 4000; ++i) check(random.uniform(-80, 80), random.uniform(-60, 60));
  for (int i = 0; i < 4000; ++i) {  // near edges, where the index could err
    const Outline& outline = sea.pieces()[random.index(sea.pieces().size())];
    const Eigen::Vector2d& p = outline[random.index(outline.size())];
    check(p.x() + 0.05 * random.normal(), p.y() + 0.05 * random.normal());
  }
  EXPECT_GT(ice, 2000);
}

TEST(Sea, KeepsTheGapsItPromises) {
  SeaParameters p = small_sea(6);
  p.isolation_gap_m = 3.0;
  const Sea sea = make_sea(p).value();
  const auto& pieces = sea.pieces();
  int isolated = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    isolated += sea.objects()[i].isolated;
    for (std::size_t j = i + 1; j < pieces.size(); ++j) {
      const IceObject &a = sea.objects()[i], &b = sea.objects()[j];
      if ((a.centre_north_east_m - b.centre_north_east_m).norm() >
          a.max_length_m + b.max_length_m + 3.0)
        continue;
      EXPECT_GE(distance_m(pieces[i], pieces[j]), a.isolated || b.isolated ? 3.0 : p.floe_gap_m);
      EXPECT_FALSE(contains(pieces[i], pieces[j][0]) || contains(pieces[j], pieces[i][0]));
    }
  }
  EXPECT_EQ(isolated, 8);
}

TEST(Sea, ReachesItsConcentrationAndSaysWhenItCannot) {
  for (const double wanted : {0.1, 0.3, 0.5}) {
    SeaParameters p = small_sea(7);
    p.concentration = wanted;
    p.lead_count = 0;
    EXPECT_NEAR(make_sea(p).value().concentration(), wanted, 0.02);
  }
  SeaParameters p = small_sea(7);
  p.concentration = 0.9;
  const auto full = make_sea(p);
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().code, ErrorCode::OutOfRange);
  EXPECT_NE(full.error().message.find("hold 90 %"), std::string::npos) << full.error().message;
  p.isolated_count = 5000;
  EXPECT_EQ(make_sea(p).error().code, ErrorCode::OutOfRange);
  p.extent_north_m = -1.0;
  EXPECT_EQ(make_sea(p).error().code, ErrorCode::Usage);
}

/// Maximum likelihood for N(> d) ~ d^-a within [low, high], by bisection of the score.
double exponent_of(const std::vector<double>& d, double low, double high) {
  double mean_log = 0.0;
  for (const double x : d) mean_log += std::log(x / low) / static_cast<double>(d.size());
  const double span = std::log(high / low);
  double a0 = 0.05, a1 = 8.0;
  for (int i = 0; i < 100; ++i) {
    const double a = 0.5 * (a0 + a1);
    const double expected = 1.0 / a - span / std::expm1(a * span);
    (expected > mean_log ? a0 : a1) = a;
  }
  return a0;
}

TEST(Sea, HasFloesOfTheAskedPowerLaw) {
  for (const double exponent : {1.2, 1.8, 2.5}) {
    SeaParameters p;
    p.floe_exponent = exponent;
    p.concentration = 0.4;
    p.isolated_count = 0;
    const Sea sea = make_sea(p).value();
    std::vector<double> sizes;
    for (const IceObject& object : sea.objects()) {
      sizes.push_back(2.0 * object.equivalent_radius_m);
      EXPECT_GE(sizes.back(), p.floe_min_m - 1e-9);
      EXPECT_LE(sizes.back(), p.floe_max_m + 1e-9);
    }
    EXPECT_NEAR(exponent_of(sizes, p.floe_min_m, p.floe_max_m), exponent, 0.06) << sizes.size();
  }
}

TEST(Sea, IsTheSameForTheSameSeedOnly) {
  const Sea a = make_sea(small_sea(8)).value(), b = make_sea(small_sea(8)).value();
  const Sea c = make_sea(small_sea(9)).value();
  ASSERT_EQ(a.pieces().size(), b.pieces().size());
  for (std::size_t i = 0; i < a.pieces().size(); ++i) EXPECT_EQ(a.pieces()[i], b.pieces()[i]);
  EXPECT_NE(a.pieces()[0], c.pieces()[0]);
}

TEST(Sea, LeadsAreOpenFromEndToEnd) {
  SeaParameters p = small_sea(10);
  p.lead_width_m = 6.0;
  const Sea sea = make_sea(p).value();
  ASSERT_EQ(sea.leads().size(), 1u);
  const auto& line = sea.leads()[0].centreline_north_east_m;
  int inside = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Eigen::Vector2d across =
        Eigen::Vector2d(-(line[i + 1] - line[i]).y(), (line[i + 1] - line[i]).x()).normalized();
    for (const double part : {-0.45, 0.0, 0.45}) {
      const Eigen::Vector2d q = line[i] + part * sea.leads()[0].width_m * across;
      inside += std::abs(q.x()) < 75 && std::abs(q.y()) < 55;
      EXPECT_FALSE(sea.is_ice(q.x(), q.y()));
    }
  }
  EXPECT_GT(inside, 60);
}

TEST(SeaPreset, NotEasyIsNotEasy) {
  const Sea sea = make_sea(sea_preset("not_easy").value()).value();
  double small = 0.0, all = 0.0;
  int isolated = 0, isolated_3_m = 0;
  for (const IceObject& object : sea.objects()) {
    all += object.area_m2;
    if (object.max_length_m < 20.0) small += object.area_m2;
    isolated += object.isolated;
    isolated_3_m += object.isolated && 2.0 * object.equivalent_radius_m >= 3.0;
  }
  EXPECT_GE(small / all, 0.3);
  EXPECT_EQ(isolated, 60);
  EXPECT_GE(isolated_3_m, 20);
}

TEST(SeaPreset, AllAreMadeAndOthersAreNamed) {
  for (const std::string_view name : sea_preset_names())
    EXPECT_TRUE(make_sea(sea_preset(name).value()).ok()) << name;
  EXPECT_NE(sea_preset("pancake").error().message.find("marginal"), std::string::npos);
}

// Area shares against polygon areas, and cell by cell against a fine sampling.
TEST(IceFraction, AddsUpToTheAreaAndMatchesSampling) {
  const Sea sea = make_sea(small_sea(12)).value();
  for (const double cell : {0.7, 3.0, 11.0}) {
    const cv::Size cells(static_cast<int>(std::ceil(110 / cell)),
                         static_cast<int>(std::ceil(150 / cell)));
    const cv::Mat share = ice_fraction(sea, cells, [&](const Eigen::Vector2d& p) {
      return Eigen::Vector2d((p.y() + 55) / cell, (75 - p.x()) / cell);
    });
    double area = 0.0;
    for (const IceObject& object : sea.objects()) area += object.area_m2;
    EXPECT_NEAR(cv::sum(share)[0] * cell * cell, area, 1e-4 * area);
    Random random(13);
    for (int i = 0; i < 40; ++i) {
      const int r = static_cast<int>(random.index(static_cast<std::size_t>(cells.height)));
      const int c = static_cast<int>(random.index(static_cast<std::size_t>(cells.width)));
      int ice = 0;
      constexpr int kSide = 60;
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
          ice +=
              sea.is_ice(75 - (r + (y + 0.5) / kSide) * cell, -55 + (c + (x + 0.5) / kSide) * cell);
      EXPECT_NEAR(share.at<float>(r, c), static_cast<double>(ice) / (kSide * kSide), 0.02);
    }
  }
}

TEST(IceFraction, OfASquareCutByTheGridIsExact) {
  AreaCoverage coverage({4, 3});
  coverage.add({{-1.0, 0.25}, {2.5, 0.25}, {2.5, 1.5}, {-1.0, 1.5}});
  coverage.add({{3.5, 2.0}, {9.0, 2.0}, {9.0, 8.0}, {3.5, 8.0}});
  const cv::Mat expected =
      (cv::Mat_<float>(3, 4) << 0.75F, 0.75F, 0.375F, 0, 0.5F, 0.5F, 0.25F, 0, 0, 0, 0, 0.5F);
  EXPECT_LT(cv::norm(coverage.share(), expected, cv::NORM_INF), 1e-7);
}

// Neither square nor symmetric: a transpose or a mirror image fails.
TEST(SeaFromAscii, HasNorthUpAndEastRight) {
  const Sea sea = Sea::from_ascii(R"(
      ##....
      #...#.
      ......)",
                                  10.0, 5.0)
                      .value();
  EXPECT_EQ(sea.extent().north_m, 30.0);
  EXPECT_EQ(sea.extent().east_m, 60.0);
  EXPECT_TRUE(sea.is_ice(14.0, -29.0));
  EXPECT_TRUE(sea.is_ice(11.0, -11.0));
  EXPECT_FALSE(sea.is_ice(4.0, -11.0));
  EXPECT_TRUE(sea.is_ice(0.0, 15.0));
  EXPECT_FALSE(sea.is_ice(0.0, -15.0));
  EXPECT_FALSE(sea.is_ice(-14.0, -29.0));
  EXPECT_FALSE(sea.is_ice(16.0, -29.0));  // outside
  ASSERT_EQ(sea.objects().size(), 2u);
  EXPECT_DOUBLE_EQ(sea.objects()[0].area_m2, 300.0);
  EXPECT_NEAR(sea.objects()[0].max_length_m, std::hypot(20.0, 20.0), 1e-5);
  EXPECT_TRUE(sea.objects()[1].centre_north_east_m.isApprox(Eigen::Vector2d(0.0, 15.0)) ||
              (sea.objects()[1].centre_north_east_m - Eigen::Vector2d(0.0, 15.0)).norm() < 1e-9);
  EXPECT_FALSE(sea.objects()[0].isolated);  // touches the border: cut off
  EXPECT_TRUE(sea.objects()[1].isolated);
  EXPECT_NEAR(sea.concentration(), 4.0 / 18.0, 1e-12);
}

TEST(SeaFromAscii, RefusesWhatIsNotARectangleOfIceAndWater) {
  EXPECT_NE(Sea::from_ascii("##\n#", 1.0).error().message.find("line 2"), std::string::npos);
  EXPECT_NE(Sea::from_ascii("#o", 1.0).error().message.find("'o'"), std::string::npos);
  EXPECT_FALSE(Sea::from_ascii(" \n ", 1.0).ok());
  EXPECT_FALSE(Sea::from_ascii("#", 0.0).ok());
}

TEST(SeaFromRaster, ScalesItsPictureToWaterZeroIceOne) {
  const cv::Mat ice = (cv::Mat_<unsigned char>(2, 3) << 1, 0, 0, 2, 0, 0);
  const cv::Mat picture = (cv::Mat_<unsigned short>(2, 3) << 90, 200, 210, 110, 190, 200);
  const Sea sea = Sea::from_raster(ice, picture, 2.0).value();
  EXPECT_NEAR(sea.picture_at(1.0, -2.0), 1.1, 1e-6);  // (90 - 200) / (100 - 200)
  EXPECT_NEAR(sea.picture_at(0.0, -2.0), 1.0, 1e-6);  // half way
  EXPECT_NEAR(sea.picture_at(1.0, 2.0), -0.1, 1e-6);
  EXPECT_EQ(sea.objects().size(), 1u);
  EXPECT_FALSE(Sea::from_raster(ice, cv::Mat(2, 3, CV_8U, cv::Scalar(7)), 2.0).ok());
  EXPECT_FALSE(Sea::from_raster(ice, cv::Mat(3, 2, CV_8U, cv::Scalar(7)), 2.0).ok());
  EXPECT_FALSE(Sea::from_raster(cv::Mat(), cv::Mat(), 2.0).ok());
}

TEST(Sea, RefusesOutlinesThatAreNone) {
  EXPECT_FALSE(Sea::from_outlines({{{0, 0}, {1, 0}}}, {}, {10, 10}).ok());
  EXPECT_FALSE(Sea::from_outlines({{{0, 0}, {1, 0}, {2, 0}}}, {}, {10, 10}).ok());
  EXPECT_FALSE(Sea::from_outlines({{{0, 0}, {1, 0}, {2, 9}}}, {}, {10, 10}).ok());
  EXPECT_FALSE(Sea::from_outlines({{{0, 0}, {1, NAN}, {2, 1}}}, {}, {10, 10}).ok());
  EXPECT_FALSE(Sea::from_outlines({}, {}, {0, 10}).ok());
}

// The simulator's own earth against GeographicLib.
TEST(SimulatorsEarth, AgreesWithGeographicLib) {
  Random random(14);
  for (int i = 0; i < 2000; ++i) {
    const Geodetic p{Angle::degrees(random.uniform(-90, 90)),
                     Angle::degrees(random.uniform(-180, 180)), random.uniform(-500, 20000)};
    EXPECT_LT((earth_centred(p) - ecef_from(p).v).norm(), 5e-9);
    const Geodetic back = geodetic_of(earth_centred(p));
    EXPECT_LT((earth_centred(back) - earth_centred(p)).norm(), 5e-9);
    EXPECT_LT(
        (north_east_down(p) - ecef_from_ned_rotation(p.latitude, p.longitude).toRotationMatrix())
            .norm(),
        1e-12);
  }
}

TEST(SimulatorsEarth, TheSeaKeepsItsHeightAroundTheAnchor) {
  for (const double lat : {0.0, 45.0, 78.9, 89.0}) {
    const SeaSurface surface(Geodetic{Angle::degrees(lat), 11.9_deg, 30.0});
    for (const auto& [distance, bound] :
         {std::pair{1000.0, 1e-5}, std::pair{2000.0, 1e-4}, std::pair{5000.0, 5e-3}})
      for (int i = 0; i < 16; ++i) {
        const double a = i * std::numbers::pi / 8;
        const Eigen::Vector3d p =
            surface.above(distance * std::cos(a), distance * std::sin(a), 0.0);
        EXPECT_NEAR(geodetic_from({p}).height_ellipsoid_m, 30.0, bound) << lat << ' ' << distance;
      }
  }
}

}  // namespace
}  // namespace watersky::sim
