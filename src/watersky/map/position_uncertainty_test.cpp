// SPDX-License-Identifier: MIT
#include "watersky/map/position_uncertainty.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

namespace watersky {
namespace {

constexpr float kUnseen = std::numeric_limits<float>::quiet_NaN();

GridView whole(const CellBox& box) {
  Eigen::Matrix3d matrix;
  matrix << 100, 0, 31.5, 0, 100, 31.5, 0, 0, 1;
  GridView view{.camera = CameraModel::make(LensModel::Pinhole, 64, 64, matrix).value(),
                .footprint = {},
                .box = box};
  const double c0 = box.first_column - 0.5, r0 = box.first_row - 0.5;
  view.footprint = {
      {c0, r0}, {c0 + box.columns, r0}, {c0 + box.columns, r0 + box.rows}, {c0, r0 + box.rows}};
  return view;
}

cv::Mat half_ice(const CellBox& box, int edge) {
  cv::Mat p(box.rows, box.columns, CV_32F);
  for (int r = 0; r < p.rows; ++r)
    for (int c = 0; c < p.cols; ++c) p.at<float>(r, c) = c < edge ? 1.0F : 0.0F;
  return p;
}

TEST(PositionUncertainty, AnEdgeBecomesTheNormalDistributionOfItsPlace) {
  const CellBox box{-40, -30, 128, 96};
  const double sigma = 4.0;
  PositionUncertainty uncertainty;
  const Eigen::Matrix2d covariance = sigma * sigma * Eigen::Matrix2d::Identity();
  for (int look = 0; look < 30; ++look)  // thirty looks that err alike are one
    uncertainty.add(whole(box), [&](const Eigen::Vector2d&) { return covariance; });
  const cv::Mat soft = uncertainty.softened(half_ice(box, 64), box);
  for (int c = 40; c < 90; ++c) {
    const double expected = 0.5 * std::erfc((c - 63.5) / (sigma * std::sqrt(2.0)));
    EXPECT_NEAR(soft.at<float>(48, c), expected, 0.01) << c;
  }
}

TEST(PositionUncertainty, SoftensAlongWhatIsUncertainOnly) {
  const CellBox box{0, 0, 96, 96};
  PositionUncertainty uncertainty;
  const Eigen::Matrix2d along_rows = Eigen::Vector2d(0.0, 25.0).asDiagonal();
  uncertainty.add(whole(box), [&](const Eigen::Vector2d&) { return along_rows; });
  const cv::Mat across = uncertainty.softened(half_ice(box, 48), box);  // an edge between columns
  EXPECT_NEAR(across.at<float>(48, 46), 1.0, 0.02);
  EXPECT_NEAR(across.at<float>(48, 49), 0.0, 0.02);
  cv::Mat along;
  cv::transpose(half_ice(box, 48), along);
  along = uncertainty.softened(along, box);
  EXPECT_NEAR(along.at<float>(44, 48), 0.5 * std::erfc((44 - 47.5) / (5 * std::sqrt(2.0))), 0.02);
}

TEST(PositionUncertainty, MoreWhereItIsMore) {
  const CellBox box{0, 0, 256, 64};
  PositionUncertainty uncertainty;
  uncertainty.add(whole(box), [](const Eigen::Vector2d& at) {
    const double sigma = at.x() < 128 ? 1.0 : 6.0;
    return Eigen::Matrix2d(sigma * sigma * Eigen::Matrix2d::Identity());
  });
  cv::Mat p;
  cv::transpose(half_ice({0, 0, 64, 256}, 32), p);  // ice in the upper half
  const cv::Mat soft = uncertainty.softened(p, box);
  EXPECT_GT(soft.at<float>(28, 40), 0.97);
  EXPECT_NEAR(soft.at<float>(28, 210), 0.5 * std::erfc((28 - 31.5) / (6 * std::sqrt(2.0))), 0.05);
}

TEST(PositionUncertainty, TheUnseenStaysUnseenAndGivesNothing) {
  const CellBox box{0, 0, 64, 64};
  PositionUncertainty uncertainty;
  uncertainty.add(whole(box), [](const Eigen::Vector2d&) {
    return Eigen::Matrix2d(9.0 * Eigen::Matrix2d::Identity());
  });
  cv::Mat p(64, 64, CV_32F, cv::Scalar(0.9));
  p(cv::Rect(30, 0, 34, 64)).setTo(kUnseen);
  const cv::Mat soft = uncertainty.softened(p, box);
  for (int r = 0; r < 64; r += 7) {
    EXPECT_NEAR(soft.at<float>(r, 29), 0.9, 1e-4);
    EXPECT_TRUE(std::isnan(soft.at<float>(r, 30)));
  }
}

// A camera at a height above the grid: attitude errors grow with the square of the distance.
TEST(PositionUncertainty, IsKeptToAHundredthAndAskedForAtFewPlaces) {
  const CellBox box{-300, -410, 900, 700};
  int asked = 0;
  const auto covariance = [](const Eigen::Vector2d& at) {
    const double height = 400, x = (at.x() - 80) / height, y = (at.y() + 150) / height;
    Eigen::Matrix<double, 2, 3> by_turn;
    by_turn << x * y, -(1 + x * x), y, 1 + y * y, -x * y, -x;
    return Eigen::Matrix2d(9.0 * by_turn * by_turn.transpose() + Eigen::Matrix2d::Identity());
  };
  PositionUncertainty uncertainty;
  for (int look = 0; look < 3; ++look)
    uncertainty.add(whole(box), [&](const Eigen::Vector2d& at) {
      ++asked;
      return covariance(at);
    });
  const cv::Mat kept = uncertainty.covariance(box);
  int blocks = 0;
  for (int r = 1; r + 1 < kept.rows; ++r)
    for (int c = 1; c + 1 < kept.cols; ++c) {
      const auto k = kept.at<cv::Vec3f>(r, c);
      constexpr int n = PositionUncertainty::kBlockCells;
      const int first_column = -19 * n, first_row = -26 * n;  // the blocks around (-300, -410)
      const Eigen::Matrix2d exact =
          covariance({first_column + (c + 0.5) * n - 0.5, first_row + (r + 0.5) * n - 0.5});
      EXPECT_NEAR(k[0], exact(0, 0), 0.02 * exact.trace()) << r << " " << c;
      EXPECT_NEAR(k[1], exact(0, 1), 0.02 * exact.trace()) << r << " " << c;
      EXPECT_NEAR(k[2], exact(1, 1), 0.02 * exact.trace()) << r << " " << c;
      ++blocks;
    }
  EXPECT_GT(blocks, 2000);
  EXPECT_LT(asked / 3, blocks / 5);
}

TEST(PositionUncertainty, NothingKnownChangesNothing) {
  const CellBox box{0, 0, 32, 32};
  const cv::Mat p = half_ice(box, 16);
  const cv::Mat soft = PositionUncertainty().softened(p, box);
  EXPECT_EQ(cv::norm(soft, p, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace watersky
