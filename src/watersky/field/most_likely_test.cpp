// SPDX-License-Identifier: MIT
#include "watersky/field/most_likely.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <random>

#include "support/small_fields.hpp"

namespace watersky::field {
namespace {

cv::Mat cut(const cv::Mat& log_odds, double coupling) {
  const auto labels = most_likely(log_odds, coupling);
  EXPECT_TRUE(labels) << (labels ? "" : labels.error().message);
  return labels.value_or(cv::Mat());
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() &&
         std::equal(a.begin<std::uint8_t>(), a.end<std::uint8_t>(), b.begin<std::uint8_t>());
}

TEST(MostLikely, HasTheLeastEnergyOfAllMapsOf4x4Cells) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(0, 1);
  for (int trial = 0; trial < 30; ++trial) {
    const cv::Mat l = test::random_field(4, 4, 2.0, 0.1, random);
    const double coupling = 3 * u(random);
    EXPECT_NEAR(energy(l, cut(l, coupling), coupling), test::enumerate(l, coupling).least_energy,
                1e-5);
  }
}

// Evidence in whole steps makes several maps equally likely.
TEST(MostLikely, IsTheOneWithTheLeastIceWhereSeveralAre) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> step(-3, 3);
  for (int trial = 0; trial < 20; ++trial) {
    cv::Mat l(4, 4, CV_32F);
    for (float& x : cv::Mat_<float>(l)) x = 0.5F * static_cast<float>(step(random));
    const double coupling = 0.0625 * (trial % 16);
    const test::Enumeration all = test::enumerate(l, coupling);
    const cv::Mat labels = cut(l, coupling);
    EXPECT_NEAR(energy(l, labels, coupling), all.least_energy, 1e-5);
    EXPECT_EQ(cv::countNonZero(labels), all.least_ice);
  }
}

TEST(MostLikely, NoFlipOfACellOrABlockImprovesALargeMap) {
  std::mt19937 random(3);
  for (const double scale : {0.2, 1.0, 3.0}) {
    const cv::Mat l = test::random_field(150, 170, scale, 0.02, random);
    for (const double coupling : {0.15, 0.6, 2.0}) {
      const cv::Mat labels = cut(l, coupling);
      const double least = energy(l, labels, coupling);
      EXPECT_LE(least, energy(l, cut(l, 0.0), coupling) + 1e-4);
      EXPECT_LE(least, energy(l, cut(l, 1.1 * coupling), coupling) + 1e-4);
      EXPECT_LE(least, energy(l, cut(l, 0.9 * coupling), coupling) + 1e-4);
      std::uniform_int_distribution<int> side(1, 12), place(0, 130);
      for (int trial = 0; trial < 10; ++trial) {
        cv::Mat changed = labels.clone();
        for (std::uint8_t& x : cv::Mat_<std::uint8_t>(
                 changed(cv::Rect(place(random), place(random), side(random), side(random)))))
          x = x == kUnseen ? x : static_cast<std::uint8_t>(1 - x);
        EXPECT_GE(energy(l, changed, coupling), least - 1e-4);
      }
    }
  }
}

TEST(MostLikely, WithoutCouplingIsTheSignOfTheEvidence) {
  std::mt19937 random(4);
  cv::Mat l = test::random_field(30, 20, 1.0, 0.1, random);
  l.at<float>(3, 4) = 0.0F;
  const cv::Mat labels = cut(l, 0.0);
  for (int r = 0; r < l.rows; ++r)
    for (int c = 0; c < l.cols; ++c) {
      const float x = l.at<float>(r, c);
      EXPECT_EQ(labels.at<std::uint8_t>(r, c), x != x ? kUnseen : x > 0 ? 1 : 0);
    }
}

TEST(MostLikely, TurnsFlipsAndMovesWithItsEvidence) {
  std::mt19937 random(5);
  const cv::Mat l = test::random_field(40, 53, 1.0, 0.1, random);
  const cv::Mat labels = cut(l, 0.4);
  for (const auto turn :
       {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180, cv::ROTATE_90_COUNTERCLOCKWISE}) {
    cv::Mat turned_l, turned;
    cv::rotate(l, turned_l, turn);
    cv::rotate(labels, turned, turn);
    EXPECT_TRUE(same(cut(turned_l, 0.4), turned));
  }
  cv::Mat moved;
  cv::copyMakeBorder(l, moved, 7, 3, 5, 2, cv::BORDER_CONSTANT,
                     cv::Scalar(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_TRUE(same(cut(moved, 0.4)(cv::Rect(5, 7, l.cols, l.rows)).clone(), labels));
  cv::Mat opposite = labels.clone();
  for (std::uint8_t& x : cv::Mat_<std::uint8_t>(opposite))
    x = x == kUnseen ? x : static_cast<std::uint8_t>(1 - x);
  EXPECT_TRUE(same(cut(-l, 0.4), opposite));
}

TEST(MostLikely, CellsNeverSeenStayUnseenAndKeepTheirSidesApart) {
  cv::Mat l(5, 7, CV_32F, cv::Scalar(-5));
  l.colRange(4, 7).setTo(0.01);
  l.col(3).setTo(std::numeric_limits<float>::quiet_NaN());
  const cv::Mat labels = cut(l, 1.0);
  EXPECT_EQ(cv::countNonZero(labels.col(3) == kUnseen), 5);
  EXPECT_EQ(cv::countNonZero(labels.colRange(0, 3)), 0);
  EXPECT_EQ(cv::countNonZero(labels.colRange(4, 7) == 1), 15);
}

TEST(MostLikely, MoreEvidenceOfIceNeverMakesLessIce) {
  std::mt19937 random(6);
  std::uniform_int_distribution<int> place(0, 29);
  cv::Mat l = test::random_field(30, 30, 1.0, 0.05, random);
  cv::Mat before = cut(l, 0.5);
  for (int k = 0; k < 60; ++k) {
    l.at<float>(place(random), place(random)) += 1.5F;
    const cv::Mat after = cut(l, 0.5);
    EXPECT_EQ(cv::countNonZero(after < before), 0);
    before = after;
  }
}

TEST(MostLikely, RefusesWhatItCannotRead) {
  EXPECT_EQ(most_likely(cv::Mat(2, 2, CV_64F, cv::Scalar(0)), 1.0).error().code,
            ErrorCode::InvalidInput);
  for (const double coupling : {-0.1, 8.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_FALSE(most_likely(cv::Mat(2, 2, CV_32F, cv::Scalar(0)), coupling));
  EXPECT_TRUE(cut(cv::Mat(), 1.0).empty());
  cv::Mat endless(1, 3, CV_32F, cv::Scalar(std::numeric_limits<float>::infinity()));
  endless.at<float>(0, 1) = -std::numeric_limits<float>::infinity();
  EXPECT_EQ(cv::countNonZero(cut(endless, kMaxCoupling)), 2);
}

}  // namespace
}  // namespace watersky::field
