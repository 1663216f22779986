// SPDX-License-Identifier: MIT
/// The fast map against Algorithm 1, over lenses, sizes and poses; and what a cell's mean is.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/map/detail/test_scene.hpp"
#include "watersky/map/ice_map.hpp"

namespace watersky {
namespace {

using test::FlatGrid;

class Agreement : public testing::TestWithParam<int> {
 protected:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  CameraModel random_camera() {
    const int width = static_cast<int>(uniform(60, 260)),
              height = static_cast<int>(uniform(50, 200));
    const double focal = uniform(0.6, 1.6) * width;
    Eigen::Matrix3d a;
    a << focal, 0, 0.5 * width + uniform(-9, 9), 0, focal * uniform(0.97, 1.03),
        0.5 * height + uniform(-9, 9), 0, 0, 1;
    const auto make = [&](LensModel lens, std::vector<double> k) {
      return CameraModel::make(lens, width, height, a, std::move(k)).value();
    };
    if (GetParam() == 0) return make(LensModel::Pinhole, {});
    if (GetParam() == 1)
      return make(LensModel::Pinhole, {uniform(-0.25, 0.1), uniform(-0.02, 0.06),
                                       uniform(-0.002, 0.002), uniform(-0.002, 0.002), 0.0});
    return make(LensModel::Fisheye, {uniform(-0.03, 0.03), uniform(-0.01, 0.01), 0.0, 0.0});
  }
  std::mt19937 rng_{static_cast<unsigned>(GetParam()) + 17};
};

// Equal sampling (one bilinear sample a cell). The picture is a slope, which bilinear reading keeps
// exactly, so that the oracle may interpolate twice (once to take the distortion out). What is left
// is where: the oracle rounds positions to 1/32 pixel, with distortion twice, so it is off by up
// to 1/64 each time; ours are off by up to 1/32 and read by weights of 1/128. Along each axis that
// is less than 1/14 of a pixel, and a cell adds 1/1024 of rounding.
TEST_P(Agreement, WithAlgorithm1OverLensesSizesAndPoses) {
  int poses = 0;
  std::size_t compared = 0;
  double worst_share = 0.0;
  for (int i = 0; i < 1100; ++i) {
    FlatGrid grid;
    grid.cell_m = uniform(0.15, 1.2);
    grid.columns = 150;
    grid.rows = 110;
    grid.north_m = 55 * grid.cell_m + uniform(-9, 9);
    grid.east_m = -75 * grid.cell_m + uniform(-9, 9);
    const CameraModel camera = random_camera();
    const auto pose =
        test::pose({uniform(-9, 9), uniform(-9, 9), -uniform(10, 70)},
                   {Angle::degrees(uniform(0, 360)), Angle::degrees(uniform(-90, -35)),
                    Angle::degrees(uniform(-20, 20))});
    const auto sea = SeaView::make(camera, pose, {Angle::degrees(8)});
    if (!sea) continue;
    const double slope_u = uniform(-0.02, 0.02), slope_v = uniform(-0.02, 0.02);
    cv::Mat slope(camera.height_px(), camera.width_px(), CV_32F);
    for (int v = 0; v < slope.rows; ++v)
      for (int u = 0; u < slope.cols; ++u)
        slope.at<float>(v, u) =
            static_cast<float>(slope_u * (u - 0.5 * slope.cols) + slope_v * (v - 0.5 * slope.rows));
    auto oracle = Algorithm1::make({.width_cells = grid.columns,
                                    .height_cells = grid.rows,
                                    .dx_m = grid.cell_m,
                                    .dy_m = grid.cell_m},
                                   camera, grid.world_from_map())
                      .value();
    ASSERT_TRUE(oracle.update_map_log_odds(slope, test::in_world(pose)).ok());
    const cv::Mat ones(slope.size(), CV_32F, cv::Scalar(1));
    const cv::Mat whole = oracle.project_image_to_map(ones, test::in_world(pose)).value();
    IceMap map =
        IceMap::make({.cell_m = grid.cell_m, .max_probability = 0.999999, .supersampling = 1})
            .value();
    ASSERT_TRUE(map.update(make_grid_view(*sea, grid.sea_from_grid()).value(), slope, Time{}).ok());
    const CellBox box{0, 0, grid.columns, grid.rows};
    cv::Mat both = (whole > 0.9999) & (map.looks(box) > 0), difference;
    // The oracle's own border spreads over the pixels beside it when it interpolates twice.
    if (camera.distorts()) cv::erode(both, both, cv::Mat(), {-1, -1}, 2);
    cv::absdiff(map.log_odds(box), oracle.map(), difference);
    difference.setTo(0, both == 0);
    double worst = 0;
    cv::minMaxLoc(difference, nullptr, &worst);
    const double bound = (std::abs(slope_u) + std::abs(slope_v)) / 14 + 1.0 / 1024;
    ASSERT_LE(worst, bound) << "pose " << i;
    worst_share = std::max(worst_share, worst / bound);
    compared += static_cast<std::size_t>(cv::countNonZero(both));
    ++poses;
  }
  EXPECT_GT(poses, 1000);
  EXPECT_GT(compared, 1'000'000u);
  EXPECT_GT(worst_share, 0.2);  // the bound is one
}

INSTANTIATE_TEST_SUITE_P(Lenses, Agreement, testing::Values(0, 1, 2));

/// A camera that looks straight down on cells of so many pixels.
GridView nadir_view(double pixels_per_cell, double turn_deg) {
  FlatGrid grid;
  grid.cell_m = 1.0;
  const CameraModel camera = test::pinhole(400, 300, 300);
  return test::grid_view(
      camera,
      test::pose({0, 0, -300.0 / pixels_per_cell}, {Angle::degrees(turn_deg), -90_deg, 0_deg}),
      grid);
}

// No pixel is wasted, and none counts for two: how much of the map a single pixel makes, in shares
// of its area. A bilinear reading alone is uneven by 0.9 to 1.6 at 1.25 pixels a cell.
TEST(IceMapSampling, EveryPixelCountsForItsArea) {
  std::mt19937 rng(2);
  for (const double pixels : {0.4, 0.8, 1.2, 1.3, 1.9, 2.3, 2.6, 3.0, 3.2, 4.5, 6.0, 9.1, 17.0}) {
    const GridView view = nadir_view(pixels, 20.0);
    double sum = 0;
    constexpr int kTries = 40;
    for (int i = 0; i < kTries; ++i) {
      cv::Mat one(300, 400, CV_32F, cv::Scalar(0));
      const int u = std::uniform_int_distribution<int>(120, 280)(rng);
      const int v = std::uniform_int_distribution<int>(90, 210)(rng);
      one.at<float>(v, u) = 7.0F;
      IceMap map = IceMap::make({.cell_m = 1.0}).value();
      ASSERT_TRUE(map.update(view, one, Time{}).ok());
      const cv::Mat l = map.log_odds(map.seen());
      const double share = cv::sum(l)[0] / 7.0 * pixels * pixels;
      // Below, a cell's 1/1024 and the dither of all cells around say more than the pixel.
      if (pixels <= 6.0) {
        EXPECT_GT(share, 0.25) << pixels;
        EXPECT_LT(share, 1.75) << pixels;
      }
      sum += share / kTries;
    }
    EXPECT_NEAR(sum, 1.0, pixels <= 6.0 ? 0.15 : 1.0) << pixels;
  }
}

TEST(IceMapSampling, APatternFinerThanACellIsItsMean) {
  for (const double pixels : {1.9, 2.6, 3.1, 4.4, 6.0, 9.1, 17.0})
    for (const double turn : {0.0, 13.0, 45.0}) {
      cv::Mat stripes(300, 400, CV_32F, cv::Scalar(0));
      for (int u = 0; u < 400; u += 2) stripes.col(u).setTo(1.0);
      IceMap map = IceMap::make({.cell_m = 1.0}).value();
      ASSERT_TRUE(map.update(nadir_view(pixels, turn), stripes, Time{}).ok());
      const CellBox seen = map.seen();
      cv::Mat inner;
      cv::copyMakeBorder(map.looks(seen) > 0, inner, 1, 1, 1, 1, cv::BORDER_CONSTANT);
      cv::erode(inner, inner, cv::Mat(), {-1, -1}, 2);
      inner = inner(cv::Rect(1, 1, seen.columns, seen.rows));
      double low = 0, high = 0;
      cv::minMaxLoc(map.log_odds(seen), &low, &high, nullptr, nullptr, inner);
      EXPECT_GT(low, 0.4) << pixels << " " << turn;
      EXPECT_LT(high, 0.6) << pixels << " " << turn;
    }
}

TEST(IceMapSampling, LevelsAndTheirLogOddsMakeTheSameMap) {
  cv::Mat grey(300, 400, CV_8U);
  cv::randu(grey, 0, 256);
  const EvidenceTable tables[] = {threshold_evidence(127, 0.7, 0.4, 0.3),
                                  probability_evidence(0.5)};
  for (const EvidenceTable& table : tables) {
    cv::Mat_<float> log_odds(grey.size());
    for (int v = 0; v < grey.rows; ++v)
      for (int u = 0; u < grey.cols; ++u) log_odds(v, u) = table[grey.at<std::uint8_t>(v, u)];
    for (const double pixels : {0.7, 1.8, 2.7, 5.0}) {
      IceMap a = IceMap::make({.cell_m = 1.0}).value(), b = a;
      const GridView view = nadir_view(pixels, 30.0);
      for (int look = 0; look < 3; ++look) {
        ASSERT_TRUE(a.update(view, Evidence::of_levels(grey, table), Time{}).ok());
        ASSERT_TRUE(b.update(view, Evidence::of_log_odds(log_odds), Time{}).ok());
      }
      ASSERT_EQ(a.seen(), b.seen());
      EXPECT_LE(cv::norm(a.log_odds(a.seen()), b.log_odds(a.seen()), cv::NORM_INF), 3.5 / 1024);
      EXPECT_EQ(cv::norm(a.looks(a.seen()), b.looks(a.seen()), cv::NORM_INF), 0);
    }
  }
}

// A cell is off by less than 1/1024 however often it is told the same, but for the rounding of
// what it is told: half of 1/16384 a look.
TEST(IceMap, RoundingDoesNotBias) {
  const GridView view = nadir_view(0.9, 10.0);
  for (const double e : {0.0123, -0.0071, 0.03099, -0.0004}) {
    IceMap map = IceMap::make({.cell_m = 1.0}).value();
    constexpr int kLooks = 200;
    for (int look = 0; look < kLooks; ++look)
      ASSERT_TRUE(map.update(view, cv::Mat(300, 400, CV_32F, cv::Scalar(e)), Time{}).ok());
    const CellBox seen = map.seen();
    double low = 0, high = 0;
    cv::minMaxLoc(map.log_odds(seen), &low, &high, nullptr, nullptr, map.looks(seen) > 0);
    EXPECT_NEAR(low, kLooks * e, 1.0 / 1024 + kLooks * 0.5 / 16384);
    EXPECT_NEAR(high, kLooks * e, 1.0 / 1024 + kLooks * 0.5 / 16384);
  }
}

TEST(IceMap, VersionsOfTilesRiseWithEveryChangeAndATileCanBePutBack) {
  const GridView view = nadir_view(0.9, 10.0);
  const cv::Mat ice(300, 400, CV_32F, cv::Scalar(1.0));
  IceMap map = IceMap::make({.cell_m = 1.0}).value();
  ASSERT_TRUE(map.update(view, ice, Time(seconds(1))).ok());
  for (const auto& [index, tile] : map.tiles()) EXPECT_EQ(tile.version, 1u);
  ASSERT_TRUE(map.update(view, ice, Time(seconds(2))).ok());
  for (const auto& [index, tile] : map.tiles()) EXPECT_EQ(tile.version, 2u);
  IceMap back = IceMap::make({.cell_m = 1.0}).value();
  for (const auto& [index, tile] : map.tiles()) back.set_tile(index, tile.tile, tile.version);
  EXPECT_EQ(back.clock(), map.clock());
  ASSERT_TRUE(map.update(view, ice, Time(seconds(3))).ok());
  ASSERT_TRUE(back.update(view, ice, Time(seconds(3))).ok());
  for (const auto& [index, tile] : map.tiles()) {
    EXPECT_EQ(back.tiles().at(index).version, 3u);
    EXPECT_EQ(back.tiles().at(index).tile, tile.tile);
  }
}

}  // namespace
}  // namespace watersky
