// SPDX-License-Identifier: MIT
#include "watersky/map/mosaic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "watersky/map/detail/cell_projection.hpp"
#include "watersky/map/detail/test_scene.hpp"

namespace watersky {
namespace {

using test::FlatGrid;

TEST(Mosaic, ColoursLandWhereTheyWereSeen) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  cv::Mat image(120, 160, CV_8UC3, cv::Scalar(10, 20, 30));
  image(cv::Rect(80, 0, 80, 60)).setTo(cv::Scalar(200, 100, 50));  // the north-east quarter
  Mosaic mosaic;
  ASSERT_TRUE(
      mosaic
          .add(test::grid_view(camera, test::pose({0, 0, -40.0}, {0_deg, -90_deg, 0_deg}), grid),
               image)
          .ok());
  const cv::Mat out = mosaic.bgra({0, 0, 260, 170});
  const auto at = [&](double north_m, double east_m) {
    return out.at<cv::Vec4b>(static_cast<int>((37.0 - north_m) / 0.5),
                             static_cast<int>((east_m + 61.0) / 0.5));
  };
  EXPECT_EQ(at(6.0, 8.0), cv::Vec4b(200, 100, 50, 255));
  EXPECT_EQ(at(-6.0, 8.0), cv::Vec4b(10, 20, 30, 255));
  EXPECT_EQ(at(6.0, -8.0), cv::Vec4b(10, 20, 30, 255));
  EXPECT_EQ(at(33.0, 60.0), cv::Vec4b(0, 0, 0, 0));
}

TEST(Mosaic, TheFrameNearestToItsNadirWinsWhateverTheOrder) {
  const FlatGrid grid;
  const CameraModel camera = test::pinhole();
  const cv::Mat red(120, 160, CV_8U, cv::Scalar(200)), blue(120, 160, CV_8U, cv::Scalar(50));
  const auto west =
      test::grid_view(camera, test::pose({0, -10, -40.0}, {0_deg, -90_deg, 0_deg}), grid);
  const auto east =
      test::grid_view(camera, test::pose({0, 10, -40.0}, {0_deg, -90_deg, 0_deg}), grid);
  Mosaic one, two;
  ASSERT_TRUE(one.add(west, red).ok() && one.add(east, blue).ok());
  ASSERT_TRUE(two.add(east, blue).ok() && two.add(west, red).ok());
  const cv::Mat a = one.bgra({0, 0, 260, 170}), b = two.bgra({0, 0, 260, 170});
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0.0);
  const int row = static_cast<int>(37.0 / 0.5);
  EXPECT_EQ(a.at<cv::Vec4b>(row, static_cast<int>((61.0 - 3) / 0.5))[0], 200);
  EXPECT_EQ(a.at<cv::Vec4b>(row, static_cast<int>((61.0 + 3) / 0.5))[0], 50);
}

// Blue grows along u, green along v: a cell's colour says which pixel it was taken from.
TEST(Mosaic, CellsTakeWhatTheLensShowsOfThem) {
  cv::Mat image(240, 320, CV_8UC3);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u)
      image.at<cv::Vec3b>(v, u) = {static_cast<std::uint8_t>(std::lround(u * 255 / 319.0)),
                                   static_cast<std::uint8_t>(std::lround(v * 255 / 239.0)), 77};
  constexpr double kLevels = 1.6;  // rounded in the image, in the shrunk one, and in the mosaic
  const CameraModel camera = test::pinhole(320, 240, 300.0, {-0.2, 0.03, 0.001, -0.002});
  for (const double cell_m : {0.1, 0.3, 0.9}) {  // from less than a pixel to seven of them
    const FlatGrid grid{.cell_m = cell_m, .columns = 1300, .rows = 850};
    const auto view =
        test::grid_view(camera, test::pose({2, 1, -40.0}, {20_deg, -65_deg, 4_deg}), grid);
    Mosaic mosaic;
    ASSERT_TRUE(mosaic.add(view, image));
    const CellBox box = view.box;
    const cv::Mat out = mosaic.bgra(box);
    const detail::CellProjection projection(view);
    int inside = 0;
    for (int r = 0; r < box.rows; ++r)
      for (int c = 0; c < box.columns; ++c) {
        const auto p = projection(box.first_column + c, box.first_row + r);
        const cv::Vec4b cell = out.at<cv::Vec4b>(r, c);
        const double margin = 2 + view.pixels_per_cell;
        const bool well_inside =
            p && p->u > margin && p->u < 319 - margin && p->v > margin && p->v < 239 - margin;
        if (!p || !camera.contains({p->u, p->v})) {
          // A cell at the edge may show by its half.
          if (!p || p->u < -margin || p->v < -margin || p->u > 319 + margin ||
              p->v > 239 + margin) {
            ASSERT_EQ(cell[3], 0);
          }
          continue;
        }
        if (!well_inside) continue;
        ++inside;
        ASSERT_EQ(cell[3], 255) << cell_m << ": " << c << ", " << r;
        ASSERT_NEAR(cell[0], p->u * 255 / 319, kLevels);
        ASSERT_NEAR(cell[1], p->v * 255 / 239, kLevels);
        ASSERT_EQ(cell[2], 77);
      }
    EXPECT_GT(inside, 500);
  }
}

TEST(Mosaic, SixteenBitsAreRefused) {
  const FlatGrid grid;
  Mosaic mosaic;
  EXPECT_FALSE(mosaic
                   .add(test::grid_view(test::pinhole(),
                                        test::pose({0, 0, -40.0}, {0_deg, -90_deg, 0_deg}), grid),
                        cv::Mat(120, 160, CV_16U, cv::Scalar(0)))
                   .ok());
  EXPECT_TRUE(mosaic.empty());
}

}  // namespace
}  // namespace watersky
