// SPDX-License-Identifier: MIT
#include "watersky/ice/accuracy.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace watersky::ice {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(Accuracy, CountsByHand) {
  const cv::Mat p = (cv::Mat_<float>(2, 4) << 0.9F, 0.9F, 0.1F, kNaN, 0.9F, 0.1F, 0.1F, 0.9F);
  const cv::Mat truth = (cv::Mat_<float>(2, 4) << 1.0F, 0.2F, 0.0F, 1.0F, 0.5F, 1.0F, 0.4F, kNaN);
  const RasterAccuracy a = compare(p, truth);
  EXPECT_EQ(a.cells, 6u);
  EXPECT_NEAR(a.iou, 2.0 / 4, 1e-12);  // both: 2; either: 4
  EXPECT_NEAR(a.accuracy, 4.0 / 6, 1e-12);
  EXPECT_NEAR(a.concentration_error, 0.0, 1e-12);  // 3 called, 3 true
}

IceObject at(double column, double row) {
  IceObject o;
  o.centroid = {column, row};
  return o;
}

TEST(MatchObjects, IsOneToOneAndNearestFirst) {
  const std::vector<TruthObject> truth = {{{10, 10}, 3.0}, {{14, 10}, 3.0}, {{50, 50}, 1.0}};
  const std::vector<IceObject> found = {at(11, 10), at(13.5, 10), at(10.2, 10), at(80, 80)};
  const auto matches = match_objects(found, truth, 0.5);
  ASSERT_EQ(matches.size(), 2u);
  EXPECT_EQ(matches[0].truth, 0u);
  EXPECT_EQ(matches[0].found, 2u);
  EXPECT_NEAR(matches[0].centroid_error_m, 0.1, 1e-9);
  EXPECT_EQ(matches[1].truth, 1u);
  EXPECT_EQ(matches[1].found, 1u);
}

}  // namespace
}  // namespace watersky::ice
