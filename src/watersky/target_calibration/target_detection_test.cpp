// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/target_detection.hpp"

#include <gtest/gtest.h>

#include "support/matchers.hpp"
#include "support/target_scene.hpp"

namespace watersky::test {
namespace {

const CameraModel kCamera = pinhole(420, {-0.25, 0.08, 0.0005, -0.0003}, 480, 360);

const TargetRenderer& renderer() {
  static const TargetRenderer drawn(kCamera);
  return drawn;
}

/// Root mean square distance of what was found to the nearest of where the points really are.
double rms_error_px(const DetectedTarget& found, const Scene& scene, const ScenePose& pose) {
  double sum = 0;
  for (const TargetPoint& p : found.points) {
    double nearest = 1e9;
    for (const auto& q : points_of(scene.kind, scene.size)) {
      const auto seen =
          kCamera.project(Vector<Camera>{pose.rotation.leftCols<2>() * q + pose.translation});
      nearest = std::min(nearest, std::hypot(seen->u - p.seen.u, seen->v - p.seen.v));
    }
    sum += nearest * nearest;
  }
  return std::sqrt(sum / static_cast<double>(found.points.size()));
}

/// Neighbours on the target are neighbours in the image: a homography takes one to the other but
/// for the lens, which bends these views by less than a fifth of a spacing.
bool is_in_order(const DetectedTarget& found) {
  for (const TargetPoint& p : found.points)
    for (const TargetPoint& q : found.points) {
      const double step = (p.on_target - q.on_target).norm();
      if (step < 0.5 || step > 1.5) continue;
      for (const TargetPoint& between : found.points) {
        if (&between == &p || &between == &q) continue;
        const double off = std::hypot(0.5 * (p.seen.u + q.seen.u) - between.seen.u,
                                      0.5 * (p.seen.v + q.seen.v) - between.seen.v);
        if (off < 0.25 * std::hypot(p.seen.u - q.seen.u, p.seen.v - q.seen.v)) return false;
      }
    }
  return true;
}

Scene scene_of(TargetKind kind) {
  Scene scene;
  scene.kind = kind;
  if (kind == TargetKind::AsymmetricCircles) scene.size = {4, 11}, scene.radius = 0.45;
  return scene;
}

TEST(DetectTarget, TellsKindAndSizeByItselfAndPointsToATenthOfAPixel) {
  for (const TargetKind kind :
       {TargetKind::Chessboard, TargetKind::Circles, TargetKind::AsymmetricCircles}) {
    const Scene scene = scene_of(kind);
    const auto poses = good_poses(kCamera, kind, scene.size, 4);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto found = detect_target(as_8_bit(renderer().render(scene, poses[i], 1)), {});
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_EQ(found->kind, kind) << i;
      // One of a view's circles lies half outside the image.
      EXPECT_GE(static_cast<int>(found->points.size()), scene.size.points() - 1) << i;
      EXPECT_TRUE(found->size == scene.size ||
                  found->size == (TargetSize{scene.size.rows, scene.size.columns}));
      EXPECT_TRUE(is_in_order(*found));
      // Asymmetric circles are large here: the centroid of a disc's picture is up to a third of
      // a pixel off the picture of its centre, which is the calibration's to know.
      EXPECT_LT(rms_error_px(*found, scene, poses[i]),
                kind == TargetKind::AsymmetricCircles ? 0.3 : 0.1);
      EXPECT_NEAR(found->edge_width_px, 2.2, 0.8);
      if (kind != TargetKind::Chessboard) {
        EXPECT_NEAR(found->radius, scene.radius, 0.01);
        EXPECT_FALSE(found->bright);
      }
    }
  }
}

TEST(DetectTarget, FindsColdAndHotHolesUnderAGradientWiderThanTheirContrastIn8And16Bit) {
  for (const bool hot : {false, true})
    for (const double contrast : {60.0, 12.0})
      for (const bool deep : {false, true}) {
        Scene scene = scene_of(TargetKind::Holes);
        scene.size = {7, 5};
        scene.board = 70;
        scene.pattern = scene.board + (hot ? contrast : -contrast);
        scene.around = scene.pattern;
        scene.gradient = 110;
        scene.noise = 1.0;
        const auto pose = good_poses(kCamera, scene.kind, scene.size, 3)[2];
        const cv::Mat levels = renderer().render(scene, pose, 7);
        const auto found = detect_target(deep ? as_16_bit(levels, 3) : as_8_bit(levels),
                                         {TargetKind::Holes, scene.size});
        ASSERT_TRUE(found) << found.error().message;
        EXPECT_EQ(found->kind, TargetKind::Holes);
        EXPECT_EQ(found->points.size(), 35u);
        EXPECT_EQ(found->bright, hot);
        EXPECT_NEAR(found->contrast, contrast * (deep ? 3 : 1), 0.1 * contrast * (deep ? 3 : 1));
        EXPECT_LT(rms_error_px(*found, scene, pose), contrast > 20 ? 0.1 : 0.25);
      }
}

TEST(DetectTarget, ColourAndLargeImagesAreAsGood) {
  const CameraModel large = pinhole(1500, {-0.2, 0.05, 0, 0}, 1800, 1350);
  const Scene scene = scene_of(TargetKind::Circles);
  const auto pose = good_poses(large, scene.kind, scene.size, 3)[1];
  cv::Mat color;
  cv::cvtColor(as_8_bit(TargetRenderer(large).render(scene, pose, 1)), color, cv::COLOR_GRAY2BGR);
  const auto found = detect_target(color, {TargetKind::Circles, scene.size});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->points.size(), 54u);
}

TEST(DetectTarget, APartOfAGridOfHolesWillDoButNotLessThanHalf) {
  Scene scene = scene_of(TargetKind::Holes);
  const auto middle = middle_of(scene.kind, scene.size);
  const auto most = pose_at(kCamera, {60, 180}, 14, 10, 40, 0, middle);
  const auto found =
      detect_target(as_8_bit(renderer().render(scene, most, 1)), {TargetKind::Holes, scene.size});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(found->points.size(), 54u);
  EXPECT_GE(found->points.size(), 27u);
  EXPECT_LT(rms_error_px(*found, scene, most), 0.1);
  const auto little = pose_at(kCamera, {-40, 180}, 14, 10, 40, 0, middle);
  EXPECT_TRUE(fails_with(
      detect_target(as_8_bit(renderer().render(scene, little, 1)), {TargetKind::Holes, scene.size}),
      ErrorCode::NotFound, {"holes"}));
}

TEST(DetectTarget, SeesNoneInNoiseInAFlatImageInATinyOneAndOfAnotherKind) {
  cv::Mat noise(360, 480, CV_8U);
  cv::RNG rng(3);
  rng.fill(noise, cv::RNG::NORMAL, 120, 25);
  for (const cv::Mat& image : {noise, cv::Mat(cv::Mat::zeros(360, 480, CV_16U)),
                               cv::Mat(cv::Mat::zeros(4, 4, CV_8U)), cv::Mat()}) {
    EXPECT_FALSE(detect_target(image, {}));
    EXPECT_FALSE(detect_target(image, {TargetKind::Holes, TargetSize{7, 5}}));
    EXPECT_FALSE(detect_target(image, {TargetKind::Chessboard, TargetSize{7, 5}}));
  }
  const Scene board = scene_of(TargetKind::Chessboard);
  const auto pose = good_poses(kCamera, board.kind, board.size, 1)[0];
  EXPECT_TRUE(fails_with(detect_target(as_8_bit(renderer().render(board, pose, 1)),
                                       {TargetKind::Chessboard, TargetSize{10, 7}}),
                         ErrorCode::NotFound, {"10x7"}));
}

TEST(TargetSize, ReadsColumnsByRowsAndSaysWhatElseIsWrong) {
  EXPECT_EQ(parse_target_size("9x6").value(), (TargetSize{9, 6}));
  EXPECT_EQ(parse_target_size("4X11").value(), (TargetSize{4, 11}));
  for (const char* text : {"", "9", "9x", "x6", "9x6x3", "2x9", "9x101", "-3x4", "9 x 6", "9*6"})
    EXPECT_TRUE(fails_with(parse_target_size(text), ErrorCode::Usage, {"COLUMNSxROWS"})) << text;
}

}  // namespace
}  // namespace watersky::test
