// SPDX-License-Identifier: MIT
#include "watersky/map/ice_map.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/map/detail/test_scene.hpp"

namespace watersky {
namespace {

using test::FlatGrid;

const CellBox kBox{0, 0, 260, 170};

IceMap make_map(int supersampling, double max_probability = 0.999999) {
  return IceMap::make(
             {.cell_m = 0.5, .max_probability = max_probability, .supersampling = supersampling})
      .value();
}

/// A random smooth pattern, segmented: neither symmetric nor periodic.
cv::Mat random_segmented(std::mt19937& rng, int width, int height) {
  cv::Mat noise(height, width, CV_32F);
  std::normal_distribution<float> normal;
  for (float& x : cv::Mat_<float>(noise)) x = normal(rng);
  cv::GaussianBlur(noise, noise, {}, 4.0);
  return noise > 0;
}

cv::Mat evidence_of(const cv::Mat& segmented, double sigma_px) {
  cv::Mat n(segmented.size(), CV_32F, cv::Scalar(log_odds(0.4)));
  n.setTo(log_odds(0.7), segmented);
  if (sigma_px > 0) cv::GaussianBlur(n, n, {}, sigma_px);
  return n;
}

// The promise of design.md: equal to the oracle for equal sampling and equal blur. What remains
// is warpPerspective's rounding of positions to 1/32 pixel: at most 1/64 pixel along each axis,
// each worth at most one step of the evidence, so 2/64 of its range a look. At the image's edge
// the two differ on purpose (border 0 against whole edge pixels), so cells within one pixel of
// it are left out.
TEST(IceMap, EqualsAlgorithm1OverRandomPoses) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  const double range = log_odds(0.7) - log_odds(0.4);
  int poses = 0, compared = 0;
  for (int i = 0; i < 300; ++i) {
    const double sigma_px = i % 3 == 0 ? 0.0 : 1.5 * uniform(rng) + 0.5;
    auto oracle = Algorithm1::make({.width_cells = grid.columns,
                                    .height_cells = grid.rows,
                                    .dx_m = grid.cell_m,
                                    .dy_m = grid.cell_m,
                                    .sigma_px = sigma_px},
                                   camera, grid.world_from_map())
                      .value();
    IceMap map = make_map(1);
    cv::Mat inner(grid.rows, grid.columns, CV_8U, cv::Scalar(255));
    cv::Mat once;
    for (int look = 0; look < 2; ++look) {
      const auto pose =
          test::pose({40 * uniform(rng) - 20, 60 * uniform(rng) - 30, -(5 + 60 * uniform(rng))},
                     {Angle::degrees(360 * uniform(rng)), Angle::degrees(-90 + 70 * uniform(rng)),
                      Angle::degrees(40 * uniform(rng) - 20)});
      const auto view = SeaView::make(camera, pose, {Angle::degrees(5)});
      if (!view) continue;
      const GridView grid_view = make_grid_view(*view, grid.sea_from_grid()).value();
      const cv::Mat segmented = random_segmented(rng, 160, 120);
      ASSERT_TRUE(oracle.update_map(segmented, test::in_world(pose)).ok());
      ASSERT_TRUE(map.update(grid_view, evidence_of(segmented, sigma_px), Time{}).ok());
      const Eigen::Matrix3d x = oracle.perspective_transform(test::in_world(pose));
      for (int v = 0; v < grid.rows; ++v)
        for (int u = 0; u < grid.columns; ++u) {
          const Eigen::Vector3d p = x * Eigen::Vector3d(u, v, 1);
          const bool in = p.z() > 0 && p.x() > p.z() && p.y() > p.z() && p.x() < 158 * p.z() &&
                          p.y() < 118 * p.z();
          const bool out = p.z() <= 0 || p.x() < -1 * p.z() || p.y() < -1 * p.z() ||
                           p.x() > 160 * p.z() || p.y() > 120 * p.z();
          const Eigen::Vector2d ne = (grid.sea_from_grid() * Eigen::Vector3d(u, v, 1)).head<2>() -
                                     pose.origin().v.head<2>();
          const bool grazing = ne.norm() > 0.999 * view->max_distance_m();
          if ((!in && !out) || (grazing && !out)) inner.at<uchar>(v, u) = 0;
        }
      ++poses;
    }
    cv::Mat difference, fast = map.log_odds(kBox);
    cv::absdiff(fast, oracle.map(), difference);
    difference.setTo(0, inner == 0);
    double worst = 0;
    cv::minMaxLoc(difference, nullptr, &worst);
    EXPECT_LE(worst, 2 * range * 2.0 / 64 + 1e-3) << "pose pair " << i;
    compared += cv::countNonZero((map.looks(kBox) > 0) & inner);
  }
  EXPECT_GT(poses, 500);
  EXPECT_GT(compared, 500'000);
}

TEST(IceMap, DistortionIsUndoneAsTheOracleDoes) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole(160, 120, 150, {-0.25, 0.08, 0.002, -0.001, 0.0});
  std::mt19937 rng(5);
  const auto pose = test::pose({3, -4, -45.0}, {25_deg, -75_deg, 4_deg});
  cv::Mat smooth;
  random_segmented(rng, 160, 120).convertTo(smooth, CV_32F, 1.0 / 255, -0.5);
  cv::GaussianBlur(smooth, smooth, {}, 3.0);
  auto oracle =
      Algorithm1::make(
          {.width_cells = grid.columns, .height_cells = grid.rows, .dx_m = 0.5, .dy_m = 0.5},
          camera, grid.world_from_map())
          .value();
  ASSERT_TRUE(oracle.update_map_log_odds(smooth, test::in_world(pose)).ok());
  IceMap map = make_map(1);
  ASSERT_TRUE(map.update(test::grid_view(camera, pose, grid), smooth, Time{}).ok());
  cv::Mat both = (oracle.map() != 0) & (map.looks(kBox) > 0);
  cv::erode(both, both, cv::Mat(), {-1, -1}, 3);
  cv::Mat difference;
  cv::absdiff(map.log_odds(kBox), oracle.map(), difference);
  difference.setTo(0, both == 0);
  double worst = 0;
  cv::minMaxLoc(difference, nullptr, &worst);
  ASSERT_GT(cv::countNonZero(both), 3000);
  EXPECT_LT(worst, 0.02);  // the oracle interpolates twice
}

TEST(IceMap, TheFootprintAndNothingElseIsTouched) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  const auto pose = test::pose({0, 0, -40.0}, {20_deg, -60_deg, 0_deg});
  const SeaView view = SeaView::make(camera, pose).value();
  IceMap map = make_map(0);
  ASSERT_TRUE(map.update(make_grid_view(view, grid.sea_from_grid()).value(),
                         cv::Mat(120, 160, CV_32F, cv::Scalar(1.0)), Time{})
                  .ok());
  const CellBox seen = map.seen();
  const cv::Mat looks = map.looks(seen);
  int wrong = 0, inside = 0;
  for (int r = 0; r < seen.rows; ++r)
    for (int c = 0; c < seen.columns; ++c) {
      const Eigen::Vector3d ne =
          grid.sea_from_grid() * Eigen::Vector3d(seen.first_column + c, seen.first_row + r, 1);
      const auto pixel = view.pixel(Point<Sea>{{ne.x(), ne.y(), 0}});
      const bool truly = pixel && camera.contains(*pixel) &&
                         (ne.head<2>() - pose.origin().v.head<2>()).norm() <= view.max_distance_m();
      inside += truly;
      wrong += truly != (looks.at<std::uint16_t>(r, c) > 0);
    }
  EXPECT_GT(inside, 5000);
  // Cells that the edge cuts in half may fall either way.
  EXPECT_LT(wrong, 0.01 * inside);
}

// A cell over many pixels takes their mean: fine stripes give the middle, not a moiré.
TEST(IceMap, ACellTakesTheMeanOverItsArea) {
  FlatGrid grid;
  grid.cell_m = 2.0;
  const CameraModel camera = test::pinhole(640, 480, 600);
  cv::Mat stripes(480, 640, CV_32F, cv::Scalar(0));
  for (int u = 0; u < 640; u += 2) stripes.col(u).setTo(1.0);
  IceMap map = IceMap::make({.cell_m = 2.0}).value();
  ASSERT_TRUE(map.update(test::grid_view(
                             camera, test::pose({0, 0, -100.0}, {10_deg, -90_deg, 0_deg}), grid),
                         stripes, Time{})
                  .ok());
  const CellBox seen = map.seen();
  const cv::Mat looks = map.looks(seen), l = map.log_odds(seen);
  double low = 0, high = 0;
  cv::Mat inner;
  cv::erode(looks > 0, inner, cv::Mat(), {-1, -1}, 2);
  cv::minMaxLoc(l, &low, &high, nullptr, nullptr, inner);
  EXPECT_NEAR(low, 0.5, 0.05);
  EXPECT_NEAR(high, 0.5, 0.05);
}

TEST(IceMap, UnknownPixelsAddNothingAndAreNotALook) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  const auto view =
      test::grid_view(camera, test::pose({0, 0, -40.0}, {0_deg, -90_deg, 0_deg}), grid);
  cv::Mat evidence(120, 160, CV_32F, cv::Scalar(1.0));
  evidence(cv::Rect(0, 0, 160, 60)).setTo(std::numeric_limits<float>::quiet_NaN());  // the north
  IceMap map = make_map(0);
  ASSERT_TRUE(map.update(view, evidence, *time_from_seconds(12.5)).ok());
  const cv::Mat looks = map.looks(kBox), p = map.probability(kBox), seen_s = map.last_seen_s(kBox);
  const int north_row = static_cast<int>((37.0 - 5.0) / 0.5),
            south_row = static_cast<int>((37.0 + 5.0) / 0.5);
  const int column = static_cast<int>(61.0 / 0.5);
  EXPECT_EQ(looks.at<std::uint16_t>(north_row, column), 0);
  EXPECT_TRUE(std::isnan(p.at<float>(north_row, column)));
  EXPECT_TRUE(std::isnan(seen_s.at<double>(north_row, column)));
  EXPECT_EQ(looks.at<std::uint16_t>(south_row, column), 1);
  EXPECT_NEAR(p.at<float>(south_row, column), probability(1.0), 1e-6);
  EXPECT_EQ(seen_s.at<double>(south_row, column), 12.5);
}

TEST(IceMap, EvidenceIsClampedSoThatAChangedSeaChangesTheMap) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  const auto view =
      test::grid_view(camera, test::pose({0, 0, -40.0}, {0_deg, -90_deg, 0_deg}), grid);
  IceMap map = IceMap::make({.prior = 0.3, .max_probability = 0.99}).value();
  const cv::Mat ice(120, 160, CV_32F, cv::Scalar(1.0)), water(120, 160, CV_32F, cv::Scalar(-1.0));
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(map.update(view, ice, Time{}).ok());
  const cv::Mat high = map.probability({120, 74, 1, 1});
  EXPECT_NEAR(high.at<float>(0, 0), 0.99, 1e-4);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(map.update(view, water, Time{}).ok());
  const cv::Mat low = map.probability({120, 74, 1, 1});
  EXPECT_NEAR(low.at<float>(0, 0), 0.01, 1e-3);
}

TEST(IceMap, TilesMeetWithoutASeamAlsoAtNegativeIndices) {
  FlatGrid grid;
  grid.north_m = -0.25;  // the camera stands over the corner of four tiles
  grid.east_m = 0.25;
  const auto view =
      test::grid_view(test::pinhole(), test::pose({0, 0, -40.0}, {15_deg, -90_deg, 0_deg}), grid);
  IceMap map = make_map(0);
  ASSERT_TRUE(map.update(view, cv::Mat(120, 160, CV_32F, cv::Scalar(1.0)), Time{}).ok());
  EXPECT_EQ(map.tiles().size(), 4u);
  const cv::Mat looks = map.looks({-10, -10, 20, 20});
  EXPECT_EQ(cv::countNonZero(looks == 1), 400);
  EXPECT_EQ(tile_of(-1), -1);
  EXPECT_EQ(tile_of(-256), -1);
  EXPECT_EQ(tile_of(-257), -2);
  EXPECT_EQ(tile_of(255), 0);
  EXPECT_EQ(tile_of(256), 1);
}

TEST(IceMap, EvidenceOfAnotherSizeIsRefused) {
  const FlatGrid grid;
  const auto view =
      test::grid_view(test::pinhole(), test::pose({0, 0, -40.0}, {0_deg, -90_deg, 0_deg}), grid);
  IceMap map = make_map(0);
  EXPECT_FALSE(map.update(view, cv::Mat(60, 80, CV_32F, cv::Scalar(1.0)), Time{}).ok());
  EXPECT_FALSE(map.update(view, cv::Mat(120, 160, CV_8U, cv::Scalar(1)), Time{}).ok());
  EXPECT_TRUE(map.tiles().empty());
}

TEST(IceMap, ARollingShuttersRowsEachHaveTheirPose) {
  // A camera that flies and turns while it reads: each cell's value is what the row that saw it
  // shows. The picture's evidence is a function of the sea, made row by row.
  const test::FlatGrid grid;
  const CameraModel camera = test::pinhole(160, 120, 150.0, {-0.08, 0.02, 0.0, 0.0});
  const Rigid3<Sea, Camera> middle = test::pose(
      {-10.0, 12.0, -60.0}, {Angle::degrees(25), Angle::degrees(-84), Angle::degrees(2)});
  const RollingShutter shutter{0.08, {11.0, -7.0, 1.5}, {0.25, -0.2, 0.35}};
  const auto at_row = [&](double row) -> Rigid3<Sea, Camera> {
    const double dt = ((row + 0.5) / camera.height_px() - 0.5) * shutter.readout_s;
    const Eigen::Vector3d turn = dt * shutter.turn_rate_rad_s;
    return {
        Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * middle.rotation(),
        Point<Sea>{middle.origin().v + dt * shutter.velocity_m_s}};
  };
  const auto slope = [](const Eigen::Vector3d& sea) {
    return static_cast<float>(0.01 * sea.x() - 0.013 * sea.y());
  };
  cv::Mat evidence(camera.height_px(), camera.width_px(), CV_32F);
  for (int v = 0; v < evidence.rows; ++v) {
    const Rigid3<Sea, Camera> pose = at_row(v);
    for (int u = 0; u < evidence.cols; ++u) {
      const Eigen::Vector3d ray =
          pose.rotation() * camera.direction({static_cast<double>(u), static_cast<double>(v)})->v;
      const Eigen::Vector3d& p = pose.origin().v;
      evidence.at<float>(v, u) = slope(p - p.z() / ray.z() * ray);
    }
  }
  const SeaView view = SeaView::make(camera, middle).value();
  const auto error_m = [&](const RollingShutter& s) {
    IceMap map = IceMap::make({.cell_m = 0.5, .max_probability = 0.99}).value();
    EXPECT_TRUE(
        map.update(make_grid_view(view, grid.sea_from_grid(), s).value(), evidence, Time()));
    const CellBox box = map.seen();
    const cv::Mat l = map.log_odds(box), looks = map.looks(box);
    double square = 0.0;
    int n = 0;
    for (int r = 0; r < box.rows; ++r)
      for (int c = 0; c < box.columns; ++c) {
        if (looks.at<std::uint16_t>(r, c) == 0) continue;
        const Eigen::Vector3d place =
            grid.sea_from_grid() * Eigen::Vector3d(box.first_column + c, box.first_row + r, 1.0);
        square += std::pow(static_cast<double>(l.at<float>(r, c) - slope(place)), 2);
        ++n;
      }
    return std::sqrt(square / n) / 0.0164;  // metres up the slope
  };
  // At the picture's edge a cell is half seen, and off by a quarter.
  EXPECT_LT(error_m(shutter), 0.05);
  EXPECT_GT(error_m({}), 0.2);
}

}  // namespace
}  // namespace watersky
