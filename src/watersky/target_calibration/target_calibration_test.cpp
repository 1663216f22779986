// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/target_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/matchers.hpp"
#include "support/target_scene.hpp"
#include "watersky/target_calibration/calibrate_images.hpp"
#include "watersky/target_calibration/detail/lens_fit.hpp"
#include "watersky/target_calibration/detail/lens_jacobian.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

const TargetSize kSize{9, 6};

double truth_of(const CameraModel& camera, const std::string& name) {
  const auto& a = camera.camera_matrix();
  if (name == "fx") return a(0, 0);
  if (name == "fy") return a(1, 1);
  if (name == "cx") return a(0, 2);
  if (name == "cy") return a(1, 2);
  static const std::vector<std::string> pinhole_names{"k1", "k2", "p1", "p2",
                                                      "k3", "k4", "k5", "k6"};
  static const std::vector<std::string> fisheye_names{"k1", "k2", "k3", "k4"};
  const auto& names = camera.lens() == LensModel::Fisheye ? fisheye_names : pinhole_names;
  return camera.distortion()[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) -
                                                      names.begin())];
}

/// Every parameter within four of its sigmas, the focal lengths within 0.3 %.
void expect_recovered(const TargetCalibration& found, const CameraModel& truth) {
  ASSERT_EQ(found.camera.lens(), truth.lens());
  for (const EstimatedParameter& p : found.parameters) {
    const double right = truth_of(truth, p.name);
    if (!p.estimated) {
      EXPECT_EQ(p.value, 0.0) << p.name;
      continue;
    }
    EXPECT_GT(p.sigma, 0.0) << p.name;
    EXPECT_NEAR(p.value, right, 4 * p.sigma) << p.name;
    if (p.name[0] == 'f') {
      EXPECT_NEAR(p.value / right, 1.0, 0.003);
    }
  }
}

std::string chosen_of(const TargetCalibration& found) {
  for (const LensCandidate& c : found.candidates)
    if (c.chosen) return c.name;
  return {};
}

const CalibrationView& view_of(const TargetCalibration& found, const std::string& name) {
  return *std::find_if(found.views.begin(), found.views.end(),
                       [&](const CalibrationView& v) { return v.name == name; });
}

TEST(LensJacobian, AgreesWithTheCameraModelAndWithFiniteDifferences) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const CameraModel& camera :
       {pinhole(500, {-0.2, 0.05, 0.001, -0.002, 0.01, 0.02, -0.01, 0.005}),
        fisheye(260, {0.03, -0.01, 0.002, -0.0005})}) {
    detail::Lens lens;
    lens.model = camera.lens();
    const auto& a = camera.camera_matrix();
    lens.parameters = {a(0, 0), a(1, 1), a(0, 2), a(1, 2)};
    for (std::size_t i = 0; i < camera.distortion().size(); ++i)
      lens.parameters[4 + i] = camera.distortion()[i];
    for (int trial = 0; trial < 100; ++trial) {
      const Eigen::Vector3d p(2 * unit(random), 2 * unit(random), 3 + unit(random));
      detail::Projection at, plus, minus;
      ASSERT_TRUE(detail::project(lens, p, true, at));
      const auto seen = camera.project(Vector<Camera>{p});
      ASSERT_TRUE(seen);
      EXPECT_NEAR(at.pixel.x(), seen->u, 1e-9);
      EXPECT_NEAR(at.pixel.y(), seen->v, 1e-9);
      for (int i = 0; i < (lens.model == LensModel::Fisheye ? 8 : 12); ++i) {
        detail::Lens more = lens, less = lens;
        const auto k = static_cast<std::size_t>(i);
        more.parameters[k] += 1e-6, less.parameters[k] -= 1e-6;
        ASSERT_TRUE(detail::project(more, p, false, plus) &&
                    detail::project(less, p, false, minus));
        const Eigen::Vector2d slope = (plus.pixel - minus.pixel) / 2e-6;
        EXPECT_LT((at.by_lens.col(i) - slope).norm(), 1e-5 * (1 + slope.norm())) << i;
      }
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(i);
        ASSERT_TRUE(detail::project(lens, p + step, false, plus) &&
                    detail::project(lens, p - step, false, minus));
        const Eigen::Vector2d slope = (plus.pixel - minus.pixel) / 2e-6;
        EXPECT_LT((at.by_point.col(i) - slope).norm(), 1e-5 * (1 + slope.norm())) << i;
      }
    }
  }
}

TEST(DiscOffset, IsWhereTheMeanOfTheDiscsPictureLies) {
  const CameraModel camera = pinhole(560, {-0.25, 0.08, 0.0005, -0.0003});
  detail::Lens lens;
  lens.parameters = {camera.camera_matrix()(0, 0),
                     camera.camera_matrix()(1, 1),
                     camera.camera_matrix()(0, 2),
                     camera.camera_matrix()(1, 2),
                     -0.25,
                     0.08,
                     0.0005,
                     -0.0003};
  const auto pose = pose_at(camera, {420, 300}, 9, 45, 30, 10, {0, 0});
  const detail::TargetPose p{pose.rotation, pose.translation};
  // Equal areas of the picture: a fine grid of pixels whose rays meet the disc.
  const Eigen::Vector2d offset = detail::disc_offset(lens, p, {0, 0}, 0.45);
  Eigen::Matrix3d target_from_ray;
  target_from_ray << pose.rotation.leftCols<2>(), pose.translation;
  target_from_ray = target_from_ray.inverse().eval();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double n = 0;
  for (double v = 260; v < 340; v += 0.2)
    for (double u = 380; u < 460; u += 0.2) {
      const Eigen::Vector3d q = target_from_ray * camera.direction({u, v})->v;
      if (q.hnormalized().norm() > 0.45) continue;
      sum += Eigen::Vector2d(u - 420, v - 300), n += 1;
    }
  EXPECT_GT(offset.norm(), 0.2);  // what would be wrong without it
  EXPECT_LT((offset - sum / n).norm(), 0.01);
}

TEST(CalibrateViews, RecoversKnownLensesAndChoosesTheirModelOrOneTermMore) {
  const struct {
    CameraModel camera;
    const char* model;
  } cases[] = {{pinhole(800, {-0.15, 0, 0, 0}), "pinhole k1"},
               {pinhole(560, {-0.25, 0.12, 0, 0}), "pinhole k1 k2"},
               {pinhole(560, {-0.25, 0.08, 0.002, -0.0015}), "pinhole k1 k2 p1 p2"},
               {fisheye(260, {0.03, -0.01, 0.002, -0.0005}), "fisheye k1 k2 k3 k4"}};
  for (const auto& c : cases) {
    const auto poses = good_poses(c.camera, TargetKind::Chessboard, kSize, 12);
    int exact = 0;
    for (const unsigned seed : {1U, 2U, 3U}) {
      const auto found = calibrate_views(bare_views(c.camera, poses, kSize, 0.08, seed), 640, 480);
      ASSERT_TRUE(found) << c.model << ": " << found.error().message;
      EXPECT_EQ(found->used_views(), 12u);
      EXPECT_NEAR(found->sigma_px, 0.08, 0.006);
      expect_recovered(*found, c.camera);
      exact += chosen_of(*found) == c.model ? 1 : 0;
      // Coefficients that are nothing are at times estimated as nearly nothing; never are ones that
      // are something left out, nor is the other family taken.
      EXPECT_TRUE(chosen_of(*found).starts_with(c.model)) << chosen_of(*found);
    }
    EXPECT_GE(exact, 2) << c.model;
  }
}

TEST(CalibrateViews, ARationalLensIsMatchedWhereverItWasSeen) {
  // Seen out to the corners, so that the polynomials are not enough.
  const CameraModel camera = pinhole(400, {0.9, 0.05, 0.001, 0.001, 0.0, 1.2, 0.25, 0.0});
  const auto poses = good_poses(camera, TargetKind::Chessboard, {13, 10}, 20, 0.8);
  const auto found = calibrate_views(bare_views(camera, poses, {13, 10}, 0.03, 8), 640, 480);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->camera.lens(), LensModel::Pinhole);
  EXPECT_NEAR(found->sigma_px, 0.03, 0.002);
  for (const CalibrationView& view : found->views)
    for (const TargetPoint& p : view.target->points) {
      const auto right = camera.direction(p.seen), got = found->camera.direction(p.seen);
      ASSERT_TRUE(right && got);
      EXPECT_LT((right->v - got->v).norm() * 400, 1.5);  // px
    }
}

TEST(CalibrateViews, SigmasAreHonestOverManySeeds) {
  const CameraModel camera = pinhole(560, {-0.25, 0.12, 0, 0}, 640, 480);
  const auto poses = good_poses(camera, TargetKind::Chessboard, {7, 5}, 10);
  constexpr int kSeeds = 24;
  double squares[5] = {};
  for (int seed = 0; seed < kSeeds; ++seed) {
    CalibrationParameters parameters;
    parameters.simpler_within_sigmas = 1.0;
    const auto found =
        calibrate_views(bare_views(camera, poses, {7, 5}, 0.1, static_cast<unsigned>(seed)), 640,
                        480, LensChoice::Pinhole, parameters);
    ASSERT_TRUE(found) << found.error().message;
    for (std::size_t i = 0; i < 5; ++i) {
      const EstimatedParameter& p = found->parameters[i];
      squares[i] += std::pow((p.value - truth_of(camera, p.name)) / p.sigma, 2) / kSeeds;
    }
  }
  // Of 24 honest ones the mean square is 1 ± 0.29. Sigmas may be somewhat large (they are the
  // larger of two estimates), and choosing the model adds some to the error.
  for (const double square : squares) {
    EXPECT_GT(square, 0.25);
    EXPECT_LT(square, 2.0);
  }
}

TEST(CalibrateViews, BadViewsAreRejectedAndNamed) {
  const CameraModel camera = pinhole(560, {-0.25, 0.08, 0.001, -0.001});
  const auto poses = good_poses(camera, TargetKind::Chessboard, kSize, 14);
  auto views = bare_views(camera, poses, kSize, 0.08, 5);
  for (auto& view : views) view.target->edge_width_px = 2.2;
  views[2].target->edge_width_px = 6.0;
  views[4].target = views[1].target;                                // the same picture twice
  for (std::size_t i = 0; i < views[6].target->points.size(); ++i)  // a bent board
    views[6].target->points[i].seen.u +=
        0.15 * std::pow(views[6].target->points[i].on_target.x() - 4, 2);
  for (TargetPoint& p : views[8].target->points)  // one corner of it detected a row off
    if (p.on_target.y() < 2 && p.on_target.x() < 5) p.seen.v += 9;
  views[9].target->points[7].seen.u += 4;  // a glint
  views[11].target.reset();
  views[11].reason = "no chessboard is seen";
  const auto found = calibrate_views(views, 640, 480);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(view_of(*found, "view2").reason, HasSubstr("blurred: its edges are 6.0 px"));
  EXPECT_THAT(view_of(*found, "view4").reason, HasSubstr("where view1 does"));
  EXPECT_THAT(view_of(*found, "view6").reason, HasSubstr("stand out"));
  EXPECT_THAT(view_of(*found, "view8").reason, HasSubstr("stand out"));
  EXPECT_EQ(view_of(*found, "view11").reason, "no chessboard is seen");
  EXPECT_EQ(found->used_views(), 9u);
  const CalibrationView& glint = view_of(*found, "view9");
  EXPECT_TRUE(glint.used);
  EXPECT_EQ(std::count(glint.left_out.begin(), glint.left_out.end(), true), 1);
  EXPECT_TRUE(glint.left_out[7]);
  expect_recovered(*found, camera);
}

TEST(CalibrateViews, RefusesWhatDoesNotTellTheLensAndSaysWhatToPhotograph) {
  const CameraModel camera = pinhole(560, {-0.2, 0.05, 0, 0});
  const auto middle = middle_of(TargetKind::Chessboard, kSize);
  std::mt19937 random(2);
  const auto views_of = [&](int count, const auto& pose) {
    std::vector<CalibrationView> views;
    for (int i = 0; i < count; ++i)
      views.push_back(bare_view(camera, pose(i), kSize, 0.1, random, "v" + std::to_string(i)));
    return views;
  };
  const auto straight = [&](int i) {
    return pose_at(camera, {200.0 + 25 * i, 160.0 + 17 * i}, 14 + 0.7 * i, 0, 0, 9.0 * i, middle);
  };
  EXPECT_TRUE(fails_with(calibrate_views(views_of(10, straight), 640, 480), ErrorCode::Degenerate,
                         {"tilted alike in all 10 views", "tilt it by 20 to 45"}));
  const auto alike = [&](int i) {
    return pose_at(camera, {200.0 + 25 * i, 160.0 + 17 * i}, 14 + 0.7 * i, 30, 20, 0, middle);
  };
  EXPECT_TRUE(fails_with(calibrate_views(views_of(10, alike), 640, 480), ErrorCode::Degenerate,
                         {"tilted alike"}));
  const auto one_place = [&](int) { return pose_at(camera, {320, 240}, 14, 30, 20, 0, middle); };
  EXPECT_TRUE(fails_with(calibrate_views(views_of(10, one_place), 640, 480), ErrorCode::Degenerate,
                         {"10 views show the target at one place", "move and tilt"}));
  const auto good = good_poses(camera, TargetKind::Chessboard, kSize, 3);
  EXPECT_TRUE(fails_with(
      calibrate_views(views_of(3, [&](int i) { return good[static_cast<std::size_t>(i)]; }), 640,
                      480),
      ErrorCode::Degenerate, {"only 3 of 3 views", "4 are needed"}));
  EXPECT_TRUE(fails_with(calibrate_views({}, 640, 480), ErrorCode::Degenerate, {"only 0"}));
}

TEST(CalibrateViews, GarbageIsRefusedNotCalibrated) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> u(0, 640), v(0, 480);
  const CameraModel camera = pinhole(560, {});
  auto views =
      bare_views(camera, good_poses(camera, TargetKind::Chessboard, kSize, 6), kSize, 0, 1);
  for (auto& view : views)
    for (auto& p : view.target->points) p.seen = {u(random), v(random)};
  EXPECT_FALSE(calibrate_views(views, 640, 480));
}

/// Images of a target, a smeared one and an empty one among them, as they come from a memory card.
std::vector<CalibrationImage> images_of(const CameraModel& camera, const Scene& scene, int count,
                                        bool deep, double fill = 0.5) {
  const TargetRenderer renderer(camera);
  const auto poses = good_poses(camera, scene.kind, scene.size, count, fill);
  std::vector<CalibrationImage> images;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Scene now = scene;
    if (i == 5) now.motion_px = 11;
    const cv::Mat levels = renderer.render(now, poses[i], static_cast<unsigned>(i));
    const cv::Mat image = deep ? as_16_bit(levels, 2) : as_8_bit(levels);
    images.push_back({"image" + std::to_string(i), [image] { return Result<cv::Mat>(image); }});
  }
  return images;
}

ImageCalibrationOptions looks_for(TargetKind kind, std::optional<TargetSize> size) {
  ImageCalibrationOptions options;
  options.target = {kind, size};
  return options;
}

TEST(CalibrateImages, RecoversAPinholeFromAChessboard) {
  const CameraModel camera = pinhole(420, {-0.25, 0.08, 0.001, -0.001}, 480, 360);
  Scene scene;
  const auto found = calibrate_images(images_of(camera, scene, 10, false),
                                      looks_for(TargetKind::Chessboard, scene.size));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_GE(found->used_views(), 9u);
  EXPECT_LT(found->rms_px, 0.1);
  expect_recovered(*found, camera);
}

TEST(CalibrateImages, RecoversAPinholeFromAsymmetricCirclesWhoseDiscsAreLarge) {
  const CameraModel camera = pinhole(420, {-0.25, 0.08, 0.001, -0.001}, 480, 360);
  Scene scene;
  scene.kind = TargetKind::AsymmetricCircles;
  scene.size = {4, 11};
  scene.radius = 0.45;
  auto images = images_of(camera, scene, 10, false);
  images.push_back({"black", [] { return Result<cv::Mat>(cv::Mat::zeros(360, 480, CV_8U)); }});
  const auto found = calibrate_images(images, looks_for(TargetKind::AsymmetricCircles, {}));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->size, scene.size);
  EXPECT_TRUE(found->size_was_found);
  EXPECT_LT(found->rms_px, 0.05);
  EXPECT_THAT(view_of(*found, "image5").reason, HasSubstr("blurred"));
  EXPECT_THAT(view_of(*found, "black").reason, HasSubstr("no grid of circles"));
  expect_recovered(*found, camera);
}

TEST(CalibrateImages, RecoversAFisheyeFromCircles) {
  const CameraModel camera = fisheye(200, {0.03, -0.01, 0.002, -0.0005}, 480, 360);
  Scene scene;
  scene.kind = TargetKind::Circles;
  const auto found = calibrate_images(images_of(camera, scene, 12, false, 0.6),
                                      looks_for(TargetKind::Circles, scene.size));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(chosen_of(*found), "fisheye k1 k2 k3 k4");
  expect_recovered(*found, camera);
}

TEST(CalibrateImages, RecoversAThermalCameraFromColdAndHotHolesIn16Bit) {
  const CameraModel camera = pinhole(450, {-0.35, 0.1, 0.001, -0.001}, 480, 384);
  for (const bool hot : {false, true}) {
    Scene scene;
    scene.kind = TargetKind::Holes;
    scene.size = {7, 5};
    scene.board = 80;
    scene.pattern = scene.around = hot ? 110 : 50;
    scene.gradient = 120;
    scene.noise = 2;
    const auto found = calibrate_images(images_of(camera, scene, 12, true),
                                        looks_for(TargetKind::Holes, scene.size));
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->kind, TargetKind::Holes);
    EXPECT_FALSE(view_of(*found, "image5").used);
    for (const CalibrationView& view : found->views) {
      if (view.used) {
        EXPECT_EQ(view.target->bright, hot);
      }
    }
    expect_recovered(*found, camera);
  }
}

TEST(CalibrateImages, SaysOfEveryImageWhyItIsNotUsed) {
  const CameraModel camera = pinhole(420, {-0.2, 0.05, 0, 0}, 480, 360);
  Scene scene;
  scene.kind = TargetKind::Circles;
  auto images = images_of(camera, scene, 7, false);
  images.push_back({"small", [] { return Result<cv::Mat>(cv::Mat::zeros(100, 100, CV_8U)); }});
  images.push_back({"torn", [] {
                      return Result<cv::Mat>(Error{ErrorCode::InvalidInput, "ends early"});
                    }});
  const auto found = calibrate_images(images, looks_for(TargetKind::Circles, scene.size));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(view_of(*found, "small").reason, HasSubstr("100x100 pixels, most images are of"));
  EXPECT_EQ(view_of(*found, "torn").reason, "ends early");

  EXPECT_TRUE(fails_with(
      calibrate_images({images[0], images[1]}, looks_for(TargetKind::Circles, TargetSize{20, 20})),
      ErrorCode::NotFound, {"image0", "9x6", "--size"}));
  EXPECT_TRUE(fails_with(calibrate_images({}, {}), ErrorCode::NotFound, {"no images"}));
  EXPECT_TRUE(fails_with(calibrate_images({images.back()}, {}), ErrorCode::InvalidInput,
                         {"torn: ends early"}));
}

}  // namespace
}  // namespace watersky::test
