// SPDX-License-Identifier: MIT
#include "watersky/camera/camera_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "support/matchers.hpp"

namespace watersky {
namespace {

using test::fails_with;
using test::succeeds;

template <class T>
concept CanBeProjected = requires(const CameraModel& camera, const T& p) { camera.project(p); };
static_assert(CanBeProjected<Point<Camera>>);
static_assert(CanBeProjected<Vector<Camera>>);
static_assert(!CanBeProjected<Point<World>>);
static_assert(!CanBeProjected<Vector<Sea>>);
static_assert(!CanBeProjected<Eigen::Vector3d>);
static_assert(!std::is_default_constructible_v<CameraModel>);

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const double kNan = std::nan("");

Eigen::Matrix3d matrix(double fx, double fy, double cx, double cy) {
  Eigen::Matrix3d a;
  a << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return a;
}

CameraModel pinhole(std::vector<double> distortion = {}) {
  return CameraModel::make(LensModel::Pinhole, 640, 480, matrix(500, 520, 325.5, 231.25),
                           std::move(distortion))
      .value();
}
CameraModel fisheye(std::vector<double> distortion = {}) {
  return CameraModel::make(LensModel::Fisheye, 640, 480, matrix(200, 210, 325.5, 231.25),
                           std::move(distortion))
      .value();
}

/// A direction off the axis by a radius (tangent of the angle) and an azimuth about it.
Vector<Camera> off_axis(double radius, double azimuth) {
  return {{radius * std::cos(azimuth), radius * std::sin(azimuth), 1.0}};
}
Vector<Camera> at_angle(double theta, double azimuth) {
  return {
      {std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth), std::cos(theta)}};
}

double angle_between(const Vector<Camera>& a, const Vector<Camera>& b) {
  return std::atan2(a.v.cross(b.v).norm(), a.v.dot(b.v));
}

class RandomLenses : public ::testing::Test {
 protected:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  Eigen::Matrix3d random_matrix() {
    const double f = uniform(200, 3000);
    return matrix(f, f * uniform(0.9, 1.1), uniform(300, 340), uniform(220, 260));
  }
  std::vector<double> random_pinhole(std::size_t count) {
    std::vector<double> k{uniform(-0.4, 0.3), uniform(-0.1, 0.2), uniform(-2e-3, 2e-3),
                          uniform(-2e-3, 2e-3), uniform(-0.02, 0.05)};
    if (count == 8)
      for (int i = 0; i < 3; ++i) k.push_back(uniform(-0.05, 0.2));
    k.resize(count);
    return k;
  }
  std::vector<double> random_fisheye() {
    return {uniform(-0.05, 0.05), uniform(-0.01, 0.01), uniform(-2e-3, 2e-3), uniform(-5e-4, 5e-4)};
  }
  std::mt19937 rng_{2};
};

TEST_F(RandomLenses, PinholeAgreesWithOpenCv) {
  for (int lens = 0; lens < 300; ++lens) {
    const std::vector<double> k = random_pinhole(std::array<std::size_t, 3>{4, 5, 8}[lens % 3]);
    const Eigen::Matrix3d a = random_matrix();
    const auto camera = CameraModel::make(LensModel::Pinhole, 640, 480, a, k).value();
    std::vector<cv::Point3d> points;
    for (int i = 0; i < 30; ++i) {
      const double r = uniform(0, 0.99 * std::min(1.5, camera.max_radius())),
                   depth = uniform(0.1, 900);
      const Eigen::Vector3d p = depth * off_axis(r, uniform(-4, 4)).v;
      points.emplace_back(p.x(), p.y(), p.z());
    }
    std::vector<cv::Point2d> expected;
    const cv::Matx33d k_cv(a(0, 0), 0, a(0, 2), 0, a(1, 1), a(1, 2), 0, 0, 1);
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), k_cv, k, expected);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = camera.project(Point<Camera>{{points[i].x, points[i].y, points[i].z}});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->u, expected[i].x, 1e-8);
      EXPECT_NEAR(pixel->v, expected[i].y, 1e-8);
    }
  }
}

TEST_F(RandomLenses, FisheyeAgreesWithOpenCv) {
  for (int lens = 0; lens < 300; ++lens) {
    const std::vector<double> k = random_fisheye();
    const Eigen::Matrix3d a = random_matrix();
    const auto camera = CameraModel::make(LensModel::Fisheye, 640, 480, a, k).value();
    std::vector<cv::Point3d> points{{0, 0, 1}};
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector3d p =
          at_angle(uniform(0, std::min(1.55, 0.999 * camera.max_radius())), uniform(-4, 4)).v *
          uniform(0.1, 900);
      points.emplace_back(p.x(), p.y(), p.z());
    }
    std::vector<cv::Point2d> expected;
    const cv::Matx33d k_cv(a(0, 0), 0, a(0, 2), 0, a(1, 1), a(1, 2), 0, 0, 1);
    cv::fisheye::projectPoints(points, expected, cv::Vec3d(), cv::Vec3d(), k_cv, k);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = camera.project(Point<Camera>{{points[i].x, points[i].y, points[i].z}});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->u, expected[i].x, 1e-7);
      EXPECT_NEAR(pixel->v, expected[i].y, 1e-7);
    }
  }
}

// Up to 98 % of the radius where the lens folds: there a pixel still tells its direction to
// 1e-9 rad. At the fold itself the slope is 0 and no arithmetic can.
TEST_F(RandomLenses, DirectionUndoesProject) {
  for (int lens = 0; lens < 400; ++lens) {
    const bool round = lens % 2 == 0;
    const auto camera =
        CameraModel::make(round ? LensModel::Fisheye : LensModel::Pinhole, 640, 480,
                          random_matrix(),
                          round ? random_fisheye() : random_pinhole(lens % 4 == 1 ? 5 : 8))
            .value();
    for (int i = 0; i < 50; ++i) {
      const double r =
          uniform(0, 0.98 * std::min(round ? std::numbers::pi : 3.0, camera.max_radius()));
      const Vector<Camera> d = round ? at_angle(r, uniform(-4, 4)) : off_axis(r, uniform(-4, 4));
      const auto pixel = camera.project(d);
      ASSERT_TRUE(pixel);
      const auto back = camera.direction(*pixel);
      ASSERT_TRUE(back) << "lens " << lens << ", radius " << r << " of " << camera.max_radius();
      EXPECT_LT(angle_between(*back, d), 1e-9)
          << "lens " << lens << ", radius " << r << " of " << camera.max_radius();
      EXPECT_NEAR(back->v.norm(), 1.0, 1e-12);
    }
  }
}

TEST_F(RandomLenses, ProjectUndoesDirectionOnEveryPixelThatHasOne) {
  for (int lens = 0; lens < 60; ++lens) {
    const bool round = lens % 3 == 0;
    const auto camera =
        CameraModel::make(round ? LensModel::Fisheye : LensModel::Pinhole, 640, 480,
                          random_matrix(),
                          round ? random_fisheye() : random_pinhole(lens % 3 == 1 ? 5 : 8))
            .value();
    for (double v = -0.5; v <= 479.5; v += 24)
      for (double u = -0.5; u <= 639.5; u += 32)
        if (const auto d = camera.direction({u, v})) {
          const auto back = camera.project(*d);
          ASSERT_TRUE(back);
          EXPECT_NEAR(back->u, u, 1e-6);
          EXPECT_NEAR(back->v, v, 1e-6);
        }
  }
}

// r (1 - 0.4 r²) grows up to r = 1/√1.2.
TEST(CameraModel, ABarrelLensShowsNoGhostsBeyondItsFold) {
  const auto camera = pinhole({-0.4, 0, 0, 0, 0});
  const double fold = 1 / std::sqrt(1.2);
  EXPECT_NEAR(camera.max_radius(), fold, 1e-8);
  EXPECT_TRUE(camera.project(off_axis(fold - 1e-6, 0.7)));
  for (double r = fold + 1e-6; r < 1e9; r *= 1.01) {
    EXPECT_FALSE(camera.project(off_axis(r, 0.7))) << r;
    EXPECT_FALSE(camera.project(off_axis(r, -2.0))) << r;
  }
  // The image of the fold: nothing is seen beyond it.
  const double edge = fold * (1 - 0.4 * fold * fold);
  EXPECT_TRUE(camera.direction({325.5 + 500 * (edge - 1e-4), 231.25}));
  EXPECT_FALSE(camera.direction({325.5 + 500 * (edge + 1e-4), 231.25}));
  EXPECT_FALSE(camera.direction({325.5 + 500 * 5.0, 231.25}));
}

// A lens that is nearly straight folds back so far out that only points at the edge of the
// half-space in front of the camera are affected; an oblique camera has sea there.
TEST(CameraModel, ANearlyStraightLensShowsNoGhostsEither) {
  const auto camera = pinhole({-1e-4, 0, 0, 0, 0});
  for (double r = 1.0; r < 1e9; r *= 1.003) {
    const auto pixel = camera.project(off_axis(r, 0.3));
    EXPECT_TRUE(!pixel || !camera.contains(*pixel)) << r;
  }
}

TEST(CameraModel, ARationalLensIsCutBeforeItsPole) {
  const auto camera = pinhole({0, 0, 0, 0, 0, -0.25, 0, 0});  // 1/(1 - r²/4): infinite at r = 2
  EXPECT_LE(camera.max_radius(), 2.0);
  EXPECT_GT(camera.max_radius(), 1.9);
  for (double r = 2.0; r < 1e6; r *= 1.01) EXPECT_FALSE(camera.project(off_axis(r, 0.3))) << r;
}

TEST(CameraModel, AFisheyeFoldsWhereItsAngleStopsGrowing) {
  const auto camera = fisheye({-0.1, 0, 0, 0});  // θ (1 - 0.1 θ²) grows up to 1/√0.3
  EXPECT_NEAR(camera.max_radius(), 1 / std::sqrt(0.3), 1e-8);
  EXPECT_TRUE(camera.project(at_angle(1.82, 1.0)));
  for (double theta = 1.83; theta <= std::numbers::pi; theta += 0.01)
    EXPECT_FALSE(camera.project(at_angle(theta, 1.0)));
  EXPECT_FALSE(camera.direction({325.5 + 200 * 1.3, 231.25}));
}

TEST(CameraModel, MasksWhatIsBehindIt) {
  for (const auto& camera : {pinhole(), pinhole({-0.1, 0.01, 0, 0, 0})}) {
    EXPECT_TRUE(camera.project(Point<Camera>{{0.1, 0.1, 1e-3 + 1.0}}));
    EXPECT_FALSE(camera.project(Point<Camera>{{0.1, 0.1, -1.0}}));
    EXPECT_FALSE(camera.project(Point<Camera>{{0.1, 0.1, 0.0}}));
    EXPECT_FALSE(camera.project(Point<Camera>{{0.0, 0.0, 0.0}}));
    EXPECT_FALSE(camera.project(Point<Camera>{{kNan, 0.0, 1.0}}));
    EXPECT_FALSE(camera.project(Point<Camera>{{0.0, 0.0, kNan}}));
  }
}

TEST(CameraModel, AFisheyeSeesBehindItsPlaneButNotItself) {
  const auto camera = fisheye();
  const auto pixel = camera.project(at_angle(2.0, 0.0));
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->u, 325.5 + 200 * 2.0, 1e-9);
  EXPECT_LT(camera.direction(*pixel)->v.z(), 0.0);
  EXPECT_FALSE(camera.project(Point<Camera>{{0, 0, 0}}));
  EXPECT_FALSE(camera.project(Point<Camera>{{0, 0, -1}}));
  EXPECT_FALSE(camera.project(Point<Camera>{{0, kNan, -1}}));
  EXPECT_FALSE(camera.direction({325.5 + 200 * 3.2, 231.25}));
}

TEST(CameraModel, NoPixelThatIsNotANumberHasADirection) {
  for (const auto& camera : {pinhole(), pinhole({-0.1, 0.01, 0, 0, 0}), fisheye()})
    for (const double bad : {kNan, kInfinity, -kInfinity}) {
      EXPECT_FALSE(camera.direction({bad, 10}));
      EXPECT_FALSE(camera.direction({10, bad}));
    }
}

TEST(CameraModel, ContainsHalfAPixelAroundTheOuterCentres) {
  const auto camera = pinhole();
  EXPECT_TRUE(camera.contains({-0.5, -0.5}));
  EXPECT_TRUE(camera.contains({639.5, 479.5}));
  EXPECT_FALSE(camera.contains({-0.51, 10}));
  EXPECT_FALSE(camera.contains({10, 479.51}));
  EXPECT_FALSE(camera.contains({479.6, 480.0}));  // u is the column
  EXPECT_FALSE(camera.contains({kNan, 10}));
}

TEST(CameraModel, RefusesIntrinsicsThatCannotBe) {
  const auto make = [](int w, int h, const Eigen::Matrix3d& a, std::vector<double> k,
                       LensModel lens = LensModel::Pinhole) {
    return CameraModel::make(lens, w, h, a, std::move(k));
  };
  const Eigen::Matrix3d a = matrix(500, 500, 320, 240);
  Eigen::Matrix3d skewed = a, scaled = 2 * a;
  skewed(0, 1) = 0.5;
  const auto code = ErrorCode::InvalidInput;
  EXPECT_TRUE(succeeds(make(640, 480, a, {})));
  EXPECT_TRUE(fails_with(make(0, 480, a, {}), code, {"image_width", "0x480"}));
  EXPECT_TRUE(fails_with(make(640, -1, a, {}), code, {"image_height", "640x-1"}));
  EXPECT_TRUE(fails_with(make(2000000000, 480, a, {}), code, {"image_width"}));
  EXPECT_TRUE(fails_with(make(640, 480, matrix(0, 500, 320, 240), {}), code, {"camera_matrix"}));
  EXPECT_TRUE(fails_with(make(640, 480, matrix(500, -500, 320, 240), {}), code, {"camera_matrix"}));
  EXPECT_TRUE(fails_with(make(640, 480, matrix(500, 500, kNan, 240), {}), code, {"camera_matrix"}));
  EXPECT_TRUE(
      fails_with(make(640, 480, matrix(kInfinity, 500, 320, 240), {}), code, {"camera_matrix"}));
  EXPECT_TRUE(fails_with(make(640, 480, skewed, {}), code, {"camera_matrix"}));
  EXPECT_TRUE(fails_with(make(640, 480, scaled, {}), code, {"camera_matrix"}));
  EXPECT_TRUE(fails_with(make(640, 480, a, {kNan, 0, 0, 0}), code, {"distortion_coefficients"}));
  for (const std::size_t n : {1u, 2u, 3u, 6u, 7u, 9u, 12u, 14u})
    EXPECT_TRUE(fails_with(make(640, 480, a, std::vector<double>(n, 0.01)), code,
                           {"distortion_coefficients", std::to_string(n)}));
  EXPECT_TRUE(fails_with(make(640, 480, a, std::vector<double>(5, 0.01), LensModel::Fisheye), code,
                         {"distortion_coefficients", "5"}));
}

TEST(CameraModel, KeepsWhatItWasGiven) {
  const auto camera = pinhole({0.1, 0.2, 0.3, 0.4, 0.5});
  EXPECT_EQ(camera.distortion(), (std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.5, 0, 0, 0}));
  EXPECT_TRUE(camera.distorts());
  EXPECT_FALSE(pinhole({0, 0, 0, 0, 0}).distorts());
  EXPECT_TRUE(fisheye().distorts());
  EXPECT_EQ(camera.focal_px(), 510.0);
  EXPECT_EQ(camera.width_px(), 640);
  EXPECT_EQ(camera.height_px(), 480);
}

// u0' = (u0 + ½)s - ½, by resizing a picture of a bright spot with OpenCV itself.
TEST(CameraModel, ScalingKeepsPixelCentres) {
  const auto camera = pinhole({-0.2, 0.05, 1e-3, -1e-3, 0});
  for (const Vector<Camera>& direction :
       {off_axis(0.0, 0.0), off_axis(0.3, 0.4), off_axis(0.4, 3.3), off_axis(0.2, -1.2)}) {
    const Pixel spot = camera.project(direction).value();
    cv::Mat image(480, 640, CV_32F);
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols; ++u) {
        const double r2 = (u - spot.u) * (u - spot.u) + (v - spot.v) * (v - spot.v);
        image.at<float>(v, u) = static_cast<float>(std::exp(-r2 / (2 * 12.0 * 12.0)));
      }
    for (const cv::Size size : {cv::Size(320, 240), cv::Size(80, 60), cv::Size(200, 180)}) {
      cv::Mat small;
      cv::resize(image, small, size, 0, 0, cv::INTER_AREA);
      const cv::Moments m = cv::moments(small);
      const CameraModel scaled = camera.scaled_to(size.width, size.height);
      const Pixel expected = scaled.project(direction).value();
      EXPECT_NEAR(m.m10 / m.m00, expected.u, 0.01) << size;
      EXPECT_NEAR(m.m01 / m.m00, expected.v, 0.01) << size;
      EXPECT_EQ(scaled.width_px(), size.width);
      EXPECT_EQ(scaled.height_px(), size.height);
      EXPECT_EQ(scaled.max_radius(), camera.max_radius());
    }
  }
}

TEST(CameraModel, ScalingThereAndBackIsNothing) {
  const auto camera = pinhole();
  const auto back = camera.scaled_to(160, 120).scaled_to(640, 480);
  EXPECT_LT((back.camera_matrix() - camera.camera_matrix()).cwiseAbs().maxCoeff(), 1e-12);
}

cv::Mat texture(int type) {
  cv::Mat noise(480, 640, type), image;
  cv::RNG rng(5);
  rng.fill(noise, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 60000 : 255);
  cv::GaussianBlur(noise, image, {0, 0}, 4.0);
  return image;
}

cv::Matx33d opencv(const Eigen::Matrix3d& a) {
  return {a(0, 0), 0, a(0, 2), 0, a(1, 1), a(1, 2), 0, 0, 1};
}

TEST(Undistorter, AgreesWithOpenCvWhereItIsValid) {
  for (const auto& k : {std::vector{-0.3, 0.1, 1e-3, -2e-3, 0.0},
                        {0.2, -0.05, -1e-3, 1e-3, 0.01},
                        {0.1, 0.02, 0.0, 0.0, 0.0, 0.3, 0.1, 0.0}}) {
    const auto camera = pinhole(k);
    const Undistorter undistorter(camera);
    for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1}) {
      const cv::Mat image = texture(type);
      cv::Mat ours, valid, theirs;
      undistorter.undistort(image, ours, valid);
      cv::undistort(image, theirs, opencv(camera.camera_matrix()), k);
      ASSERT_EQ(ours.type(), type);
      ASSERT_GT(cv::countNonZero(valid), 640 * 480 / 2);
      // Both round positions to 1/32 px; the texture changes by less than 6 % a pixel.
      EXPECT_LE(cv::norm(ours, theirs, cv::NORM_INF, valid),
                CV_MAT_DEPTH(type) == CV_16U ? 200.0 : 1.0);
    }
  }
}

TEST(Undistorter, AgreesWithOpenCvsFisheye) {
  const auto camera = fisheye({-0.02, 0.004, -1e-3, 1e-4});
  const Undistorter undistorter(camera);
  const cv::Mat image = texture(CV_8UC1);
  cv::Mat ours, valid, theirs;
  undistorter.undistort(image, ours, valid);
  const cv::Matx33d k = opencv(camera.camera_matrix());
  cv::fisheye::undistortImage(image, theirs, k, camera.distortion(), k);
  EXPECT_LE(cv::norm(ours, theirs, cv::NORM_INF, valid), 1.0);
  EXPECT_GT(cv::countNonZero(valid), 640 * 480 * 9 / 10);
}

// A white picture comes out white where it shows something and black at the border.
TEST(Undistorter, IsInvalidExactlyWhereTheBorderWouldShow) {
  for (const auto& k : {std::vector{0.3, 0.1, 1e-3, -2e-3, 0.0}, {-0.3, 0.1, 1e-3, -2e-3, 0.0}}) {
    const auto camera = pinhole(k);
    const cv::Mat white(480, 640, CV_8U, cv::Scalar(255));
    cv::Mat ours, valid, theirs;
    Undistorter(camera).undistort(white, ours, valid);
    cv::undistort(white, theirs, opencv(camera.camera_matrix()), k);
    EXPECT_EQ(cv::countNonZero(ours != valid), 0);
    int border = 0;
    for (int v = 0; v < 480; ++v)
      for (int u = 0; u < 640; ++u) {
        if (valid.at<uchar>(v, u)) {
          EXPECT_EQ(theirs.at<uchar>(v, u), 255) << u << ", " << v;
        } else if (theirs.at<uchar>(v, u) == 255) {
          // OpenCV rounds to 1/32 px, so it may take what lies that close to the outer centres.
          const Eigen::Vector2d p((u - 325.5) / 500, (v - 231.25) / 520);
          const Pixel at = camera.project(Vector<Camera>{p.homogeneous()}).value();
          EXPECT_TRUE(at.u > -0.04 && at.v > -0.04 && at.u < 639.04 && at.v < 479.04)
              << u << ", " << v;
        } else {
          ++border;
        }
      }
    EXPECT_EQ(border > 0, k[0] > 0);
  }
}

TEST_F(RandomLenses, ALensWithoutDistortionLosesNoPixelToUndistortion) {
  cv::Mat image(48, 64, CV_8U), out, valid;
  cv::randu(image, 0, 255);
  for (int lens = 0; lens < 300; ++lens) {
    const auto camera = CameraModel::make(LensModel::Pinhole, 64, 48,
                                          matrix(uniform(40, 900), uniform(40, 900),
                                                 uniform(25, 40), uniform(15, 30)),
                                          {0, 0, 0, 0, 0})
                            .value();
    Undistorter(camera).undistort(image, out, valid);
    EXPECT_EQ(cv::countNonZero(valid), 64 * 48);
    EXPECT_EQ(cv::norm(out, image, cv::NORM_INF), 0.0);
  }
}

TEST(Undistorter, ItsCameraIsTheOneOfTheUndistortedImage) {
  const auto camera = fisheye({-0.02, 0.004, -1e-3, 1e-4});
  const CameraModel plain = Undistorter(camera).undistorted_camera();
  EXPECT_EQ(plain.lens(), LensModel::Pinhole);
  EXPECT_FALSE(plain.distorts());
  EXPECT_EQ(plain.max_radius(), kInfinity);
  // A spot drawn where the lens shows a direction is found where the plain camera shows it.
  const Vector<Camera> direction = off_axis(0.8, 0.5);
  const Pixel spot = camera.project(direction).value();
  cv::Mat image(480, 640, CV_32F);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u)
      image.at<float>(v, u) = static_cast<float>(
          std::exp(-((u - spot.u) * (u - spot.u) + (v - spot.v) * (v - spot.v)) / (2 * 2.0 * 2.0)));
  cv::Mat out, valid;
  Undistorter(camera).undistort(image, out, valid);
  cv::Point peak;
  cv::minMaxLoc(out, nullptr, nullptr, nullptr, &peak);
  EXPECT_NEAR(peak.x, plain.project(direction)->u, 0.75);
  EXPECT_NEAR(peak.y, plain.project(direction)->v, 0.75);
}

}  // namespace
}  // namespace watersky
