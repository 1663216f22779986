// SPDX-License-Identifier: MIT
#include "watersky/sim/renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/sim/detail/random.hpp"
#include "watersky/sim/sea_parameters.hpp"

namespace watersky::sim {
namespace {

/// Nothing but geometry: ice is 1 and water 0, to the share of each pixel's rays.
SensorParameters bare() {
  SensorParameters p;
  p.noise_counts = p.pattern_counts = p.vignetting = p.psf_px = 0.0;
  p.ice_texture = p.water_texture = p.floe_variation = 0.0;
  p.exposure_s = 0.0;
  p.supersampling = 8;
  return p;
}

LensParameters small_lens(double focal_px) {
  LensParameters p;
  p.width_px = 81;
  p.height_px = 61;
  p.focal_px = focal_px;
  return p;
}

/// Straight down from `height_m`, image top north: right is east, down in the image is south.
ScenePose nadir(double height_m, double north_m = 0.0, double east_m = 0.0) {
  ScenePose pose;
  pose.scene_from_camera << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  pose.origin_m = {north_m, east_m, -height_m};
  return pose;
}

ScenePoseAt still(const ScenePose& pose) {
  return [pose](double) { return pose; };
}

Renderer make(const Sea& sea, const LensParameters& lens, const SensorParameters& sensor,
              std::uint64_t seed = 1, const Eigen::Vector2d& drift = {0.0, 0.0}) {
  return Renderer::make(sea, lens, sensor, seed, drift).value();
}

// From 50 m with 100 px a pixel is 0.5 m; the middle pixel is (40, 30). The square from 4 m to
// 8 m north and 6 m to 11 m east spans columns 40 + 12 = 52 to 62 and rows 30 - 16 = 14 to 22,
// between pixel centres: the outermost columns and rows are half covered, the corner a quarter.
TEST(Renderer, ShowsTheNorthEastCornerWhereAHandCalculationPutsIt) {
  const Sea sea = Sea::from_outlines({{{4, 6}, {8, 6}, {8, 11}, {4, 11}}}, {}, {100, 100}).value();
  const cv::Mat seen = make(sea, small_lens(100.0), bare()).brightness(still(nadir(50.0)), 0.0);
  const auto at = [&](int u, int v) { return seen.at<float>(v, u); };
  EXPECT_NEAR(at(62, 14), 0.25, 1e-5);  // north-east
  EXPECT_NEAR(at(62, 18), 0.5, 1e-5);
  EXPECT_NEAR(at(57, 14), 0.5, 1e-5);
  EXPECT_NEAR(at(61, 15), 1.0, 1e-5);
  EXPECT_NEAR(at(63, 14), 0.0, 1e-5);
  EXPECT_NEAR(at(62, 13), 0.0, 1e-5);
  EXPECT_NEAR(at(52, 22), 0.25, 1e-5);  // south-west
  EXPECT_NEAR(cv::sum(seen)[0], 10.0 * 8.0, 1e-3);
}

// Every pixel of a scene without any symmetry against the drawing; a transpose or a mirror image
// anywhere fails.
TEST(Renderer, IsNeitherMirroredNorTransposed) {
  const Sea sea = Sea::from_ascii(R"(
      ##......
      #...#...
      #.....##
      ...#....
      .....#..)",
                                  5.0)
                      .value();
  const LensParameters lens = small_lens(100.0);
  const cv::Mat seen = make(sea, lens, bare()).brightness(still(nadir(50.0, 1.3, -2.1)), 0.0);
  int ice = 0;
  for (int v = 0; v < 61; ++v)
    for (int u = 0; u < 81; ++u) {
      const float b = seen.at<float>(v, u);
      if (b > 0.01F && b < 0.99F) continue;  // an edge runs through it
      EXPECT_EQ(b > 0.5F, sea.is_ice(1.3 - 0.5 * (v - 30), -2.1 + 0.5 * (u - 40))) << u << ' ' << v;
      ice += b > 0.5F;
    }
  EXPECT_GT(ice, 400);
}

// Discs at random places under random poses and lenses against cv::projectPoints.
TEST(Renderer, ShowsDiscsWhereOpenCvProjectsTheirMiddles) {
  Random random(21);
  for (int trial = 0; trial < 30; ++trial) {
    Outline disc;
    for (int k = 0; k < 40; ++k)
      disc.emplace_back(0.4 * std::cos(k * 0.15708), 0.4 * std::sin(k * 0.15708));
    const Eigen::Vector2d middle(random.uniform(-6, 6), random.uniform(-6, 6));
    for (Eigen::Vector2d& p : disc) p += middle;
    const Sea sea = Sea::from_outlines({disc}, {}, {40, 40}).value();

    LensParameters lens = small_lens(130.0);
    lens.k1 = random.uniform(-0.2, 0.1);
    lens.k2 = random.uniform(-0.02, 0.05);
    lens.p1 = random.uniform(-2e-3, 2e-3);
    lens.p2 = random.uniform(-2e-3, 2e-3);
    lens.k4 = random.uniform(-0.05, 0.1);
    lens.centre_right_px = random.uniform(-3, 3);
    const Eigen::Vector3d axis =
        Eigen::Vector3d(random.normal(), random.normal(), 0.3 * random.normal()).normalized();
    ScenePose pose = nadir(random.uniform(28, 40), random.uniform(-4, 4), random.uniform(-4, 4));
    pose.scene_from_camera = Eigen::AngleAxisd(random.uniform(0, 0.3), axis).toRotationMatrix() *
                             Eigen::AngleAxisd(random.uniform(-3, 3), Eigen::Vector3d::UnitZ()) *
                             pose.scene_from_camera;

    const Eigen::Matrix3d r = pose.scene_from_camera.transpose();
    const Eigen::Vector3d t = -r * pose.origin_m;
    const cv::Matx33d rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0),
                               r(2, 1), r(2, 2));
    cv::Vec3d turn;
    cv::Rodrigues(rotation, turn);
    const Lens model(lens);
    const cv::Matx33d camera(lens.focal_px, 0, model.u0(), 0, lens.focal_px, model.v0(), 0, 0, 1);
    const std::vector<double> distortion{lens.k1, lens.k2, lens.p1, lens.p2,
                                         lens.k3, lens.k4, lens.k5, lens.k6};
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(std::vector<cv::Point3d>{{middle.x(), middle.y(), 0.0}}, turn,
                      cv::Vec3d(t.x(), t.y(), t.z()), camera, distortion, pixels);
    if (pixels[0].x < 5 || pixels[0].x > 75 || pixels[0].y < 5 || pixels[0].y > 55) continue;

    const cv::Mat seen = make(sea, lens, bare()).brightness(still(pose), 0.0);
    const cv::Moments m = cv::moments(seen);
    // The image of a disc's middle is not quite the middle of its image: a few hundredths.
    EXPECT_NEAR(m.m10 / m.m00, pixels[0].x, 0.06);
    EXPECT_NEAR(m.m01 / m.m00, pixels[0].y, 0.06);
  }
}

// A step blurred by a Gaussian and by the pixel has the sum of their variances.
TEST(Renderer, BlursByItsPointSpreadAndThePixelItself) {
  const Sea sea =
      Sea::from_outlines({{{-40, 0.1}, {40, 0.1}, {40, 40}, {-40, 40}}}, {}, {100, 100}).value();
  SensorParameters sensor = bare();
  sensor.psf_px = 1.5;
  const cv::Mat seen = make(sea, small_lens(100.0), sensor).brightness(still(nadir(50.0)), 0.0);
  double mean = 0.0, variance = 0.0;
  const auto spread = [&](int u) { return seen.at<float>(30, u + 1) - seen.at<float>(30, u); };
  for (int u = 25; u < 55; ++u) mean += (u + 0.5) * spread(u);
  for (int u = 25; u < 55; ++u) variance += std::pow(u + 0.5 - mean, 2) * spread(u);
  EXPECT_NEAR(mean, 40.2, 0.02);
  EXPECT_NEAR(variance, 1.5 * 1.5 + 2.0 / 12.0, 0.06);  // the pixel, and the pixel's step once more
}

TEST(Renderer, FogTakesContrastByTheExponentOfTheSlantRange) {
  const Sea sea =
      Sea::from_outlines({{{-400, 0}, {400, 0}, {400, 400}, {-400, 400}}}, {}, {1000, 1000})
          .value();
  SensorParameters sensor = bare();
  sensor.fog_per_m = 0.01;
  sensor.fog_brightness = 0.4;
  const LensParameters lens = small_lens(40.0);
  const ScenePose pose = nadir(80.0, 0.0, 0.0);
  const cv::Mat foggy = make(sea, lens, sensor).brightness(still(pose), 0.0);
  for (const auto& [u, v] : {std::pair{44, 30}, std::pair{75, 3}, std::pair{60, 50}}) {
    const double range =
        80.0 * std::sqrt(1.0 + (std::pow(u - 40, 2) + std::pow(v - 30, 2)) / 1600.0);
    const double ice = foggy.at<float>(v, u), water = foggy.at<float>(v, 80 - u);
    EXPECT_NEAR(ice - water, std::exp(-0.01 * range), 1e-4);
    EXPECT_NEAR(water, 0.4 * (1.0 - std::exp(-0.01 * range)), 1e-4);
  }
}

TEST(Renderer, MeasuresTheContrastAndNoiseItWasGiven) {
  SeaParameters parameters;
  parameters.extent_north_m = parameters.extent_east_m = 200.0;
  parameters.isolated_count = 5;
  const Sea sea = make_sea(parameters).value();
  for (const bool darker : {false, true}) {
    SensorParameters sensor;  // everything on, as in the acceptance flight
    sensor.ice_darker = darker;
    sensor.floe_variation = 0.0;  // of the whole sea, not of the few floes seen here
    sensor.vignetting = 0.0;
    sensor.ice_texture = sensor.water_texture = 0.05;
    sensor.psf_px = 0.3;
    LensParameters lens;
    lens.width_px = 320;
    lens.height_px = 256;
    lens.focal_px = 200.0;
    const Renderer renderer = make(sea, lens, sensor);
    const ScenePoseAt pose = still(nadir(100.0));
    const cv::Mat first = renderer.image(pose, 0.0, 1), second = renderer.image(pose, 0.0, 2);
    cv::Mat a, b;
    first.convertTo(a, CV_64F);
    second.convertTo(b, CV_64F);
    // Two frames of one scene differ by noise alone: twice its variance, and twice the 1/12 of
    // rounding to whole counts.
    cv::Scalar mean, deviation;
    cv::meanStdDev(a - b, mean, deviation);
    EXPECT_NEAR(deviation[0] / std::sqrt(2.0), std::sqrt(36.0 + 1.0 / 12.0), 0.05);
    EXPECT_NEAR(mean[0], 0.0, 0.1);

    SensorParameters geometry = bare();
    geometry.supersampling = 2;
    const cv::Mat share = make(sea, lens, geometry).brightness(pose, 0.0);
    const double ice = cv::mean(a, share == 1.0F)[0], water = cv::mean(a, share == 0.0F)[0];
    EXPECT_NEAR(ice - water, darker ? -24.0 : 24.0, 1.0);
    EXPECT_NEAR(water, 100.0, 1.0);
  }
}

TEST(Renderer, RepeatsItselfForTheSameSeedAndFrameOnly) {
  const Sea sea = Sea::from_ascii("##..\n#...", 10.0).value();
  const LensParameters lens = small_lens(100.0);
  const ScenePoseAt pose = still(nadir(50.0));
  const cv::Mat image = make(sea, lens, {}, 5).image(pose, 0.0, 9);
  EXPECT_EQ(cv::norm(image, make(sea, lens, {}, 5).image(pose, 0.0, 9), cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(image, make(sea, lens, {}, 5).image(pose, 0.0, 10), cv::NORM_INF), 5.0);
  EXPECT_GT(cv::norm(image, make(sea, lens, {}, 6).image(pose, 0.0, 9), cv::NORM_INF), 5.0);
}

TEST(Renderer, TextureMakesNeitherIceNorWaterFlat) {
  const Sea sea =
      Sea::from_outlines({{{-90, 0}, {90, 0}, {90, 90}, {-90, 90}}}, {}, {200, 200}).value();
  SensorParameters sensor = bare();
  sensor.ice_texture = 0.12;
  sensor.water_texture = 0.06;
  sensor.supersampling = 1;
  LensParameters lens = small_lens(50.0);
  lens.width_px = lens.height_px = 300;
  const cv::Mat seen = make(sea, lens, sensor).brightness(still(nadir(25.0)), 0.0);
  cv::Scalar mean, deviation;
  cv::meanStdDev(seen.colRange(160, 300), mean, deviation);
  EXPECT_NEAR(mean[0], 1.0, 0.02);
  EXPECT_NEAR(deviation[0], 0.12, 0.03);
  cv::meanStdDev(seen.colRange(0, 140), mean, deviation);
  EXPECT_NEAR(mean[0], 0.0, 0.01);
  EXPECT_NEAR(deviation[0], 0.06, 0.015);
}

TEST(Renderer, FloesDifferInBrightnessButNotOnAverage) {
  SeaParameters parameters;
  parameters.isolated_count = 5;
  const Sea sea = make_sea(parameters).value();
  SensorParameters sensor = bare();
  sensor.floe_variation = 0.15;
  sensor.supersampling = 1;
  LensParameters lens = small_lens(400.0);
  lens.width_px = 360;
  lens.height_px = 420;
  const cv::Mat seen = make(sea, lens, sensor).brightness(still(nadir(400.0)), 0.0);
  cv::Scalar mean, deviation;
  cv::meanStdDev(seen, mean, deviation, seen > 0.0F);
  EXPECT_NEAR(mean[0], 1.0, 0.01);
  EXPECT_GT(deviation[0], 0.05);
}

// 20 m/s east for 0.1 s is 2 m or 4 pixels: an edge becomes a ramp of 4 pixels.
TEST(Renderer, SmearsWhatMovesDuringTheExposure) {
  const Sea sea =
      Sea::from_outlines({{{-40, 0}, {40, 0}, {40, 40}, {-40, 40}}}, {}, {100, 100}).value();
  SensorParameters sensor = bare();
  sensor.exposure_s = 0.1;
  const ScenePoseAt moving = [](double t) { return nadir(50.0, 0.0, 20.0 * t); };
  const cv::Mat seen = make(sea, small_lens(100.0), sensor).brightness(moving, 0.0);
  for (int u = 35; u <= 45; ++u)
    EXPECT_NEAR(seen.at<float>(30, u), std::clamp((u - 38.0) / 4.0, 0.0, 1.0), 0.04) << u;
}

// Read out in 1 s at 10 m/s east: the first row looks 5 m west of the middle row, 10 pixels.
TEST(Renderer, RollingShutterShearsTheImageAroundItsMiddleRow) {
  const Sea sea =
      Sea::from_outlines({{{-40, 0}, {40, 0}, {40, 40}, {-40, 40}}}, {}, {100, 100}).value();
  SensorParameters sensor = bare();
  sensor.readout_s = 1.0;
  const ScenePoseAt moving = [](double t) { return nadir(50.0, 0.0, 10.0 * (t - 7.0)); };
  const cv::Mat seen = make(sea, small_lens(100.0), sensor).brightness(moving, 7.0);
  const auto edge = [&](int v) { return 80.5 - cv::sum(seen.row(v))[0]; };
  EXPECT_NEAR(edge(30), 40.0, 0.02);
  EXPECT_NEAR(edge(0), 50.0, 0.02);
  EXPECT_NEAR(edge(60), 30.0, 0.02);
}

TEST(Renderer, IceDriftsAndTakesItsTruthWithIt) {
  const Sea sea =
      Sea::from_outlines({{{-5, -5}, {5, -5}, {5, 5}, {-5, 5}}}, {}, {100, 100}).value();
  const Renderer renderer = make(sea, small_lens(100.0), bare(), 1, {0.5, 1.0});
  const cv::Moments m = cv::moments(renderer.brightness(still(nadir(50.0)), 4.0));
  EXPECT_NEAR(m.m10 / m.m00, 40.0 + 8.0, 1e-3);  // 4 m east
  EXPECT_NEAR(m.m01 / m.m00, 30.0 - 4.0, 1e-3);  // 2 m north
}

TEST(Renderer, GivesSixteenBitsAndColourAndDarknessOutsideTheLens) {
  const Sea sea = Sea::from_ascii("##..\n#...", 10.0).value();
  SensorParameters sensor;
  sensor.bits = 16;
  sensor.water_counts = 20000.0;
  sensor.contrast_counts = 1000.0;
  EXPECT_EQ(make(sea, small_lens(100.0), sensor).image(still(nadir(50.0)), 0.0, 1).type(),
            CV_16UC1);
  sensor = SensorParameters{};
  sensor.color = true;
  LensParameters lens = small_lens(30.0);
  lens.k1 = -0.3;  // folds at 70 % of 30 px: the corners see nothing
  const cv::Mat color = make(sea, lens, sensor).image(still(nadir(50.0)), 0.0, 1);
  ASSERT_EQ(color.type(), CV_8UC3);
  EXPECT_EQ(color.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0));
  EXPECT_GT(color.at<cv::Vec3b>(30, 40)[0], 50);
  sensor.bits = 12;
  EXPECT_EQ(Renderer::make(sea, lens, sensor, 1, {0, 0}).error().code, ErrorCode::Usage);
}

TEST(Renderer, VignettingTakesItsShareInTheCorners) {
  const Sea sea = Sea::from_outlines({}, {}, {10, 10}).value();
  SensorParameters sensor = bare();
  sensor.vignetting = 0.3;
  sensor.supersampling = 1;
  const cv::Mat image = make(sea, small_lens(100.0), sensor).image(still(nadir(50.0)), 0.0, 1);
  EXPECT_EQ(image.at<unsigned char>(30, 40), 100);
  EXPECT_NEAR(image.at<unsigned char>(0, 0), 70, 2);
}

TEST(Renderer, SeesSkyAboveTheHorizon) {
  const Sea sea = Sea::from_outlines({}, {}, {10, 10}).value();
  SensorParameters sensor = bare();
  sensor.sky_brightness = 3.0;
  ScenePose pose;  // level, to the north
  pose.scene_from_camera << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  pose.origin_m = {0.0, 0.0, -50.0};
  const cv::Mat seen = make(sea, small_lens(100.0), sensor).brightness(still(pose), 0.0);
  EXPECT_EQ(seen.at<float>(20, 40), 3.0F);
  EXPECT_EQ(seen.at<float>(40, 40), 0.0F);
}

TEST(Renderer, ShowsAPictureThatTheSeaBrought) {
  cv::Mat ice = cv::Mat::zeros(6, 8, CV_8U), picture(6, 8, CV_8U);
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 8; ++c) {
      ice.at<unsigned char>(r, c) = c < 3 ? 1 : 0;
      picture.at<unsigned char>(r, c) = static_cast<unsigned char>(c < 3 ? 20 + r : 200 + 3 * c);
    }
  const Sea sea = Sea::from_raster(ice, picture, 4.0).value();
  SensorParameters sensor = bare();
  const cv::Mat seen = make(sea, small_lens(100.0), sensor).brightness(still(nadir(50.0)), 0.0);
  // Pixel (40 + 8, 30 - 4) sees 2 m north, 4 m east: row 2.5 - 0.5, column 5 - 0.5.
  EXPECT_NEAR(seen.at<float>(26, 48), sea.picture_at(2.0, 4.0), 0.002);
  EXPECT_NEAR(seen.at<float>(30, 20), sea.picture_at(0.0, -10.0), 0.002);
}

}  // namespace
}  // namespace watersky::sim
