// SPDX-License-Identifier: MIT
#include "watersky/ice/objects.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>
#include <sstream>

#include "watersky/ice/floe_statistics.hpp"

namespace watersky::ice {
namespace {

/// '#' ice (0.9), '.' water (0.1), ' ' never seen.
cv::Mat drawn(const std::vector<std::string>& rows) {
  cv::Mat p(static_cast<int>(rows.size()), static_cast<int>(rows[0].size()), CV_32F);
  for (int r = 0; r < p.rows; ++r)
    for (int c = 0; c < p.cols; ++c) {
      const char x = rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
      p.at<float>(r, c) = x == '#' ? 0.9F : x == '.' ? 0.1F : std::nanf("");
    }
  return p;
}

std::vector<IceObject> objects_of(const cv::Mat& p, double cell_m = 1.0, int min_cells = 1) {
  ObjectParameters parameters;
  parameters.min_cells = min_cells;
  return find_objects({p, {}, {}}, cell_m, parameters);
}

/// Positive counter-clockwise seen with north up (rows run south).
double signed_area(const Ring& ring) {
  double twice = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d& a = ring[i];
    const Eigen::Vector2d& b = ring[(i + 1) % ring.size()];
    twice += b.x() * a.y() - a.x() * b.y();
  }
  return twice / 2;
}

TEST(FindObjects, MeasuresARectangleWithAHole) {
  const auto found =
      objects_of(drawn({"........", ".#####..", ".#..##..", ".#####..", "........"}), 2.0);
  ASSERT_EQ(found.size(), 1u);
  const IceObject& o = found[0];
  EXPECT_EQ(o.cells, 13u);
  EXPECT_DOUBLE_EQ(o.area_m2, 52.0);
  EXPECT_NEAR(o.centroid.x(), (5 * 3 + 1 + 4 + 5 + 5 * 3) / 13.0, 1e-12);
  EXPECT_NEAR(o.centroid.y(), 2.0, 1e-12);
  EXPECT_NEAR(o.length_m, 2 * std::hypot(5, 3), 1e-12);
  EXPECT_NEAR(o.width_m, 2 * 3, 1e-12);
  EXPECT_NEAR(o.solidity, 13.0 / 15, 1e-12);
  EXPECT_NEAR(o.perimeter_m, std::numbers::pi / 4 * 2 * (16 + 6), 1e-12);
  EXPECT_NEAR(o.mean_probability, 0.9, 1e-6);
  EXPECT_FALSE(o.cut_by_edge);
  EXPECT_TRUE(std::isinf(o.gap_m));
  ASSERT_EQ(o.outline.size(), 1u);
  EXPECT_EQ(o.outline[0].outer.size(), 4u);
  EXPECT_DOUBLE_EQ(signed_area(o.outline[0].outer), 15.0);
  ASSERT_EQ(o.outline[0].holes.size(), 1u);
  EXPECT_DOUBLE_EQ(signed_area(o.outline[0].holes[0]), -2.0);
  EXPECT_EQ(*std::min_element(o.outline[0].outer.begin(), o.outline[0].outer.end(),
                              [](const auto& a, const auto& b) { return a.sum() < b.sum(); }),
            Eigen::Vector2d(0.5, 0.5));
}

TEST(FindObjects, PiecesThatTouchByACornerAreOneObjectWithTwoOutlines) {
  const auto found = objects_of(drawn({".....", ".#...", "..#..", "....."}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].outline.size(), 2u);
  EXPECT_NEAR(found[0].length_m, std::hypot(2, 2), 1e-12);
  EXPECT_NEAR(found[0].width_m, std::sqrt(2.0), 1e-12);
}

TEST(FindObjects, ALineThatMeetsItselfBecomesAnOuterLineAndAHole) {
  // The ring closes by a corner only: its inside touches the open water there.
  const auto found = objects_of(
      drawn({".......", ".####..", ".#..#..", ".#...#.", ".#...#.", ".#####.", "......."}));
  ASSERT_EQ(found.size(), 1u);
  double area = 0;
  for (const Polygon& polygon : found[0].outline) {
    area += signed_area(polygon.outer);
    for (const Ring& hole : polygon.holes) area += signed_area(hole);
  }
  EXPECT_DOUBLE_EQ(area, static_cast<double>(found[0].cells));
  ASSERT_EQ(found[0].outline.size(), 1u);
  ASSERT_EQ(found[0].outline[0].holes.size(), 1u);
}

TEST(FindObjects, TouchingTheUnseenOrTheBorderIsCut) {
  const auto found =
      objects_of(drawn({"#......   ", "......... ", "..##...#. ", "..##..... ", ".......## "}));
  ASSERT_EQ(found.size(), 4u);
  EXPECT_FALSE(found[0].cut_by_edge);  // the 2 x 2 piece
  EXPECT_TRUE(found[1].cut_by_edge);   // at the bottom border and the unseen column
  EXPECT_TRUE(found[2].cut_by_edge);   // the corner
  EXPECT_FALSE(found[3].cut_by_edge);  // one cell of water before the unseen
}

TEST(FindObjects, GapIsTheWaterBetween) {
  const auto found =
      objects_of(drawn({"............", ".##.....##..", ".##.....##..", "............"}), 0.5);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0].gap_m, 2.5, 1e-3);
  EXPECT_NEAR(found[1].gap_m, 2.5, 1e-3);
}

TEST(FindObjects, PiecesTooSmallToListStillCountAsIceNearby) {
  const auto found =
      objects_of(drawn({".........", ".##...#..", ".##......", "........."}), 1.0, 4);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].gap_m, 3.0, 1e-3);
}

TEST(FindObjects, OnlyAloneCompactWholeAndSureMakesAnIcebergCandidate) {
  cv::Mat p(60, 120, CV_32F, cv::Scalar(0.05));
  cv::circle(p, {20, 30}, 6, cv::Scalar(0.95), cv::FILLED);                    // candidate
  cv::ellipse(p, {50, 30}, {12, 2}, 0, 0, 360, cv::Scalar(0.95), cv::FILLED);  // thin
  cv::circle(p, {80, 30}, 6, cv::Scalar(0.6), cv::FILLED);                     // not sure
  cv::circle(p, {100, 0}, 6, cv::Scalar(0.95), cv::FILLED);                    // cut
  cv::circle(p, {100, 40}, 6, cv::Scalar(0.95), cv::FILLED);                   // a pair
  cv::circle(p, {114, 40}, 6, cv::Scalar(0.95), cv::FILLED);
  int candidates = 0;
  for (const IceObject& o : objects_of(p)) {
    if (o.kind != ObjectKind::IcebergCandidate) continue;
    ++candidates;
    EXPECT_NEAR(o.centroid.x(), 20, 0.1);
    EXPECT_EQ(o.size_class, "bergy bit");
  }
  EXPECT_EQ(candidates, 1);
}

TEST(FindObjects, LooksAndLastSeenComeFromTheirRasters) {
  const cv::Mat p = drawn({"....", ".##.", "...."});
  cv::Mat looks(p.size(), CV_16U, cv::Scalar(9));
  looks.at<std::uint16_t>(1, 1) = 2;
  looks.at<std::uint16_t>(1, 2) = 5;
  cv::Mat seen(p.size(), CV_64F, cv::Scalar(1e9));
  seen.at<double>(1, 1) = 100.5;
  seen.at<double>(1, 2) = 99.0;
  ObjectParameters parameters;
  parameters.min_cells = 1;
  const auto found = find_objects({p, looks, seen}, 1.0, parameters);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_DOUBLE_EQ(found[0].mean_looks, 3.5);
  EXPECT_DOUBLE_EQ(found[0].last_seen_s, 100.5);
}

TEST(FindObjects, AnEmptyOrIcelessMapHasNone) {
  EXPECT_TRUE(find_objects({}, 1.0).empty());
  EXPECT_TRUE(objects_of(cv::Mat(5, 5, CV_32F, cv::Scalar(std::nanf("")))).empty());
  EXPECT_TRUE(objects_of(cv::Mat(5, 5, CV_32F, cv::Scalar(0.2))).empty());
}

TEST(FindObjects, AllOfItIceIsOneObjectCutByTheBorder) {
  const auto found = objects_of(cv::Mat(5, 7, CV_32F, cv::Scalar(0.8)));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].cut_by_edge);
  EXPECT_EQ(found[0].outline[0].outer.size(), 4u);
  EXPECT_DOUBLE_EQ(signed_area(found[0].outline[0].outer), 35.0);
}

/// Laws over random seas, from sparse to nearly full, where every kind of meeting occurs.
TEST(FindObjects, OutlinesHoldExactlyTheirCellsAndAreSimple) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 60; ++trial) {
    const double fill = 0.15 + 0.75 * trial / 60.0;
    cv::Mat p(37, 53, CV_32F);
    for (int i = 0; i < static_cast<int>(p.total()); ++i)
      p.at<float>(i / p.cols, i % p.cols) = std::bernoulli_distribution(fill)(random) ? 0.9F : 0.1F;
    const auto found = objects_of(p);
    cv::Mat labels;
    EXPECT_EQ(static_cast<int>(found.size()) + 1,
              cv::connectedComponents(p > 0.5F, labels, 8, CV_32S));
    for (const IceObject& o : found) {
      double area = 0;
      for (const Polygon& polygon : o.outline) {
        const double outer = signed_area(polygon.outer);
        EXPECT_GT(outer, 0);
        area += outer;
        std::vector<const Ring*> rings{&polygon.outer};
        for (const Ring& hole : polygon.holes) {
          EXPECT_LT(signed_area(hole), 0);
          area += signed_area(hole);
          rings.push_back(&hole);
        }
        for (const Ring* ring : rings) {
          std::set<std::pair<double, double>> corners;
          for (const Eigen::Vector2d& v : *ring) corners.insert({v.x(), v.y()});
          EXPECT_EQ(corners.size(), ring->size()) << "a line touches itself";
        }
        // A hole lies in the outer line it is listed under.
        for (const Ring& hole : polygon.holes) {
          std::vector<cv::Point2f> outline;
          for (const auto& v : polygon.outer)
            outline.emplace_back(static_cast<float>(v.x()), static_cast<float>(v.y()));
          for (const auto& v : hole)
            EXPECT_GE(cv::pointPolygonTest(
                          outline, {static_cast<float>(v.x()), static_cast<float>(v.y())}, false),
                      0);
        }
      }
      EXPECT_DOUBLE_EQ(area, static_cast<double>(o.cells));
    }
  }
}

TEST(FindObjects, LengthAndWidthAgreeWithAllPairsAndAllDirections) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(0, 1);
  for (int trial = 0; trial < 50; ++trial) {
    cv::Mat p(80, 80, CV_32F, cv::Scalar(0.1));
    cv::ellipse(p, {40, 40},
                {4 + static_cast<int>(30 * u(random)), 2 + static_cast<int>(20 * u(random))},
                180 * u(random), 0, 360, cv::Scalar(0.9), cv::FILLED);
    const auto found = objects_of(p);
    ASSERT_EQ(found.size(), 1u);
    const Ring& outer = found[0].outline[0].outer;
    double length = 0;
    for (const auto& a : outer)
      for (const auto& b : outer) length = std::max(length, (a - b).norm());
    double width = 1e9;
    for (int step = 0; step < 3600; ++step) {
      const double angle = std::numbers::pi * step / 3600;
      double low = 1e9;
      double high = -1e9;
      for (const auto& a : outer) {
        const double s = a.x() * std::cos(angle) + a.y() * std::sin(angle);
        low = std::min(low, s);
        high = std::max(high, s);
      }
      width = std::min(width, high - low);
    }
    EXPECT_NEAR(found[0].length_m, length, 1e-9);
    EXPECT_LE(found[0].width_m, width + 1e-9);  // the true minimum lies between the directions
    EXPECT_GE(found[0].width_m, width - 0.05);
  }
}

TEST(FindObjects, GapsAgreeWithBruteForceWithinFivePercentOrACell) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    cv::Mat p(90, 110, CV_32F, cv::Scalar(0.1));
    for (int i = 0; i < 7; ++i)
      cv::circle(p, {static_cast<int>(random() % 110), static_cast<int>(random() % 90)},
                 1 + static_cast<int>(random() % 6), cv::Scalar(0.9), cv::FILLED);
    const auto found = objects_of(p);
    for (const IceObject& o : found) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const IceObject& other : found) {
        if (&other == &o) continue;
        for (const auto& polygon : o.outline)
          for (std::size_t i = 0; i < polygon.outer.size(); ++i) {
            const Eigen::Vector2d a = polygon.outer[i];
            for (const auto& other_polygon : other.outline)
              for (std::size_t j = 0; j < other_polygon.outer.size(); ++j) {
                const Eigen::Vector2d b = other_polygon.outer[j];
                const Eigen::Vector2d c = other_polygon.outer[(j + 1) % other_polygon.outer.size()];
                const double t = std::clamp((a - b).dot(c - b) / (c - b).squaredNorm(), 0.0, 1.0);
                nearest = std::min(nearest, (a - (b + t * (c - b))).norm());
              }
          }
      }
      if (std::isinf(nearest)) {
        EXPECT_TRUE(std::isinf(o.gap_m));
      } else {
        EXPECT_NEAR(o.gap_m, nearest, std::max(1.0, 0.05 * nearest)) << "trial " << trial;
      }
    }
  }
}

TEST(FindObjects, ADiscHasTheDiameterAndPerimeterOfADisc) {
  cv::Mat p(300, 300, CV_32F);
  for (int r = 0; r < 300; ++r)
    for (int c = 0; c < 300; ++c)
      p.at<float>(r, c) = std::hypot(c - 150.2, r - 149.7) < 100 ? 0.9F : 0.1F;
  const auto found = objects_of(p, 0.5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].equivalent_diameter_m, 100.0, 0.1);
  EXPECT_NEAR(found[0].perimeter_m, 100 * std::numbers::pi, 0.01 * 100 * std::numbers::pi);
  EXPECT_NEAR(found[0].length_m, 100.0, 0.75);
  EXPECT_NEAR(found[0].width_m, 100.0, 0.75);
}

TEST(FloeStatistics, CountAndAreaWeighTheirOwnWayAndCutPiecesAreLeftOut) {
  IceObject small;
  small.area_m2 = 1.0;
  small.equivalent_diameter_m = 1.1;
  small.length_m = 1.4;
  IceObject large = small;
  large.area_m2 = 99.0;
  large.equivalent_diameter_m = 11.2;
  large.length_m = 14.0;
  IceObject cut = large;
  cut.cut_by_edge = true;
  const FloeStatistics s = floe_statistics({large, small, cut});
  EXPECT_EQ(s.count, 2u);
  EXPECT_EQ(s.cut_by_edge, 1u);
  EXPECT_NEAR(s.mean_diameter_m, (1.1 + 11.2) / 2, 1e-12);
  EXPECT_NEAR(s.area_weighted_mean_diameter_m, (1.1 + 99 * 11.2) / 100, 1e-12);
  EXPECT_DOUBLE_EQ(s.largest_length_m, 14.0);
  std::size_t counted = 0;
  for (std::size_t i = 0; i < s.bins.size(); ++i) {
    counted += s.bins[i].count;
    if (i > 0) {
      EXPECT_DOUBLE_EQ(s.bins[i].from_m, s.bins[i - 1].to_m);
    }
  }
  EXPECT_EQ(counted, 2u);
  EXPECT_LE(s.bins.front().from_m, 1.1);
  EXPECT_GT(s.bins.back().to_m, 11.2);
  EXPECT_TRUE(std::isnan(floe_statistics({}).mean_length_m));
}

}  // namespace
}  // namespace watersky::ice
