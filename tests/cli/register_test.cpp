// SPDX-License-Identifier: MIT
/// `watersky register`: the contract that others script against.
#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cli_support.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

class Register : public ::testing::Test {
 protected:
  Register() {
    cv::RNG rng(5);
    cv::Mat field(520, 700, CV_8U, cv::Scalar(60));
    for (int i = 0; i < 500; ++i)
      cv::circle(field, {rng.uniform(0, 700), rng.uniform(0, 520)}, rng.uniform(3, 30),
                 cv::Scalar(rng.uniform(60, 220)), -1, cv::LINE_AA);
    cv::imwrite(path("a.png"), field(cv::Rect(40, 40, 480, 360)));
    cv::imwrite(path("b.png"), field(cv::Rect(65, 30, 480, 360)));  // a pixel moves by -25, 10
    cv::Mat other;
    cv::flip(field(cv::Rect(200, 100, 480, 360)), other, 0);
    cv::imwrite(path("other.png"), other);
    cv::imwrite(path("flat.png"), cv::Mat(360, 480, CV_8U, cv::Scalar(100)));
  }
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  [[nodiscard]] Outcome pair(const std::string& a, const std::string& b,
                             const std::string& options = "--json") const {
    return watersky("register '" + path(a) + "' '" + path(b) + "' " + options);
  }
  TemporaryFolder folder_;
};

TEST_F(Register, GivesTheHomographyFromPixelsOfAToThoseOfB) {
  for (const char* method : {"klt", "orb", "sift", "akaze"}) {
    const Outcome o = pair("a.png", "b.png", std::string("--json --method ") + method);
    ASSERT_EQ(o.status, 0) << o.err;
    const auto json = o.json();
    ASSERT_EQ(json["registered"], true) << method << o.out;
    EXPECT_EQ(json["method"], method);
    ASSERT_EQ(json["homography"].size(), 9u);
    const std::vector<double> h = json["homography"];
    const double w = h[6] * 200 + h[7] * 150 + h[8];
    EXPECT_NEAR((h[0] * 200 + h[1] * 150 + h[2]) / w, 175, 1.0) << method;
    EXPECT_NEAR((h[3] * 200 + h[4] * 150 + h[5]) / w, 160, 1.0) << method;
    ASSERT_EQ(json["covariance"].size(), 8u);
    for (std::size_t i = 0; i < 8; ++i) {
      ASSERT_EQ(json["covariance"][i].size(), 8u);
      EXPECT_GT(json["covariance"][i][i], 0.0);
    }
    EXPECT_GT(json["corner_sigma_px"], 0.0);
    EXPECT_LT(json["corner_sigma_px"], 5.0);
    EXPECT_GE(json["inliers"], 4);
    EXPECT_LT(json["mean_reprojection_px"], 5.0);
    EXPECT_TRUE(json["reason"].is_null());
  }
}

TEST_F(Register, WithoutAResultTheHomographyIsNullAndTheStatusZero) {
  for (const auto& [a, b] : {std::pair("a.png", "other.png"), std::pair("flat.png", "flat.png"),
                             std::pair("a.png", "flat.png")}) {
    const Outcome o = pair(a, b);
    ASSERT_EQ(o.status, 0) << o.err;
    const auto json = o.json();
    EXPECT_EQ(json["registered"], false);
    EXPECT_TRUE(json["homography"].is_null());
    EXPECT_TRUE(json["covariance"].is_null());
    EXPECT_TRUE(json["reason"].is_string());
  }
  const Outcome words = pair("flat.png", "flat.png", "");
  EXPECT_EQ(words.status, 0);
  EXPECT_THAT(words.out, HasSubstr("too little texture"));
}

TEST_F(Register, WritesAPictureOfTheMatches) {
  const Outcome o = pair("a.png", "b.png", "-o '" + path("m.png") + "'");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("registered (klt)"));
  const cv::Mat picture = cv::imread(path("m.png"));
  EXPECT_EQ(picture.size(), cv::Size(960, 360));
}

TEST_F(Register, BadInputIsOneLineAndStatusOne) {
  write_text(path("letter.png"), "dear");
  expect_one_line_error(pair("a.png", "letter.png"), 1);
  expect_one_line_error(pair("gone.png", "a.png"), 1);
}

TEST_F(Register, WrongCallsAreStatusTwo) {
  EXPECT_EQ(watersky("register '" + path("a.png") + "'").status, 2);
  EXPECT_EQ(pair("a.png", "b.png", "--method magic").status, 2);
  EXPECT_EQ(pair("a.png", "b.png", "-o '" + path("m.txt") + "'").status, 2);
}

TEST_F(Register, SurfIsThereOrSaidToBeAbsent) {
  const Outcome o = pair("a.png", "b.png", "--json --method surf");
  if (o.status == 0) {
    EXPECT_EQ(o.json()["registered"], true);
  } else {
    expect_one_line_error(o, 1);
    EXPECT_THAT(o.err, HasSubstr("SURF"));
  }
}

}  // namespace
}  // namespace watersky::test
