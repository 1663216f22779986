// SPDX-License-Identifier: MIT
#include "watersky/map/algorithm1.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "watersky/map/detail/test_scene.hpp"
#include "watersky/map/log_odds.hpp"

namespace watersky {
namespace {

using test::FlatGrid;

Algorithm1Parameters parameters(const FlatGrid& grid) {
  return {.width_cells = grid.columns,
          .height_cells = grid.rows,
          .dx_m = grid.cell_m,
          .dy_m = grid.cell_m};
}

TEST(Algorithm1, IcePixelsRiseToP1AndWaterFallsToP2AndTheUnseenStays) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  auto map = Algorithm1::make(parameters(grid), camera, grid.world_from_map()).value();
  // Straight down, image top north: the left half of the image is the west.
  const auto pose = test::in_world(test::pose({0.0, 0.0, -40.0}, {0_deg, -90_deg, 0_deg}));
  cv::Mat segmented(120, 160, CV_8U, cv::Scalar(0));
  segmented(cv::Rect(0, 0, 80, 120)).setTo(255);
  ASSERT_TRUE(map.update_map(segmented, pose).ok());

  const cv::Mat p = map.probability_map();
  ASSERT_EQ(p.cols, grid.columns);
  ASSERT_EQ(p.rows, grid.rows);
  const auto at = [&](double north_m, double east_m) {
    const cv::Point c =
        map.to_map_coordinates(map.to_map_frame(Point<World>{{north_m, east_m, 0.0}}));
    return p.at<float>(c);
  };
  EXPECT_NEAR(at(0.0, -10.0), 0.7, 1e-4);
  EXPECT_NEAR(at(0.0, 10.0), 0.4, 1e-4);
  EXPECT_NEAR(at(12.0, -19.0), 0.7, 1e-4);
  EXPECT_NEAR(at(30.0, 0.0), 0.5, 1e-6) << "not in the image";
}

TEST(Algorithm1, APriorOtherThanOneHalfLeavesUnseenCellsAlone) {
  const FlatGrid grid;
  auto p = parameters(grid);
  p.prior = 0.2;
  auto map = Algorithm1::make(p, test::pinhole(), grid.world_from_map()).value();
  const cv::Mat ice(120, 160, CV_8U, cv::Scalar(255));
  for (int i = 0; i < 5; ++i)
    ASSERT_TRUE(
        map.update_map(ice, test::in_world(test::pose({0, 0, -20.0}, {30_deg, -90_deg, 0_deg})))
            .ok());
  const cv::Mat m = map.map();
  EXPECT_NEAR(m.at<float>(0, 0), log_odds(0.2), 1e-6);
  const cv::Point centre = map.to_map_coordinates(map.to_map_frame(Point<World>{}));
  EXPECT_NEAR(m.at<float>(centre), log_odds(0.2) + 5 * (log_odds(0.7) - log_odds(0.2)), 1e-4);
}

// Without the mask on s <= 0 a camera that looks over the horizon paints a mirrored
// ghost behind itself.
TEST(Algorithm1, NothingIsPaintedBehindTheCamera) {
  const FlatGrid grid;
  auto map = Algorithm1::make(parameters(grid), test::pinhole(), grid.world_from_map()).value();
  const cv::Mat ice(120, 160, CV_8U, cv::Scalar(255));
  const auto pose = test::pose({0, 0, -10.0}, {0_deg, -5_deg, 0_deg});  // looks north, almost level
  ASSERT_TRUE(map.update_map(ice, test::in_world(pose)).ok());
  int ahead = 0;
  for (int v = 0; v < grid.rows; ++v)
    for (int u = 0; u < grid.columns; ++u) {
      const double north_m = grid.north_m - (v + 0.5) * grid.cell_m;
      if (north_m < 0) {
        ASSERT_EQ(map.map().at<float>(v, u), 0.0F) << u << ", " << v;
      } else {
        ahead += map.map().at<float>(v, u) > 0;
      }
    }
  EXPECT_GT(ahead, 100);
}

TEST(Algorithm1, ACameraInOrUnderThePlaneIsRefusedAndAddsNothing) {
  const FlatGrid grid;
  auto map = Algorithm1::make(parameters(grid), test::pinhole(), grid.world_from_map()).value();
  const cv::Mat ice(120, 160, CV_8U, cv::Scalar(255));
  for (const double down_m : {0.0, 5.0}) {
    const Status s =
        map.update_map(ice, test::in_world(test::pose({0, 0, down_m}, {0_deg, -90_deg, 0_deg})));
    ASSERT_FALSE(s.ok());
    EXPECT_EQ(s.error().code, ErrorCode::Degenerate);
  }
  EXPECT_EQ(cv::countNonZero(map.map()), 0);
}

TEST(Algorithm1, BadParametersAreRefused) {
  const FlatGrid grid;
  auto p = parameters(grid);
  p.p1 = 1.0;
  EXPECT_FALSE(Algorithm1::make(p, test::pinhole(), grid.world_from_map()).ok());
  p = parameters(grid);
  p.dx_m = 0;
  EXPECT_FALSE(Algorithm1::make(p, test::pinhole(), grid.world_from_map()).ok());
  p = parameters(grid);
  p.width_cells = 0;
  EXPECT_FALSE(Algorithm1::make(p, test::pinhole(), grid.world_from_map()).ok());
}

TEST(Algorithm1, FeaturesAreDrawnWhereTheyLie) {
  const FlatGrid grid;
  auto map = Algorithm1::make(parameters(grid), test::pinhole(), grid.world_from_map()).value();
  cv::Mat canvas(grid.rows, grid.columns, CV_8U, cv::Scalar(0));
  map.draw_features_on_map({{Point<World>{{10.0, -20.0, 0.0}}, 3.0}}, canvas);
  const cv::Point c = map.to_map_coordinates(map.to_map_frame(Point<World>{{10.0, -20.0, 0.0}}));
  EXPECT_GT(canvas.at<uchar>(c + cv::Point(-6, 0)) + canvas.at<uchar>(c + cv::Point(-7, 0)), 0);
  EXPECT_EQ(canvas.at<uchar>(c), 0) << "a circle, not a disc";
}

}  // namespace
}  // namespace watersky
