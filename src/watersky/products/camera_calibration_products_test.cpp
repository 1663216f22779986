// SPDX-License-Identifier: MIT
#include "watersky/products/camera_calibration_products.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/matchers.hpp"
#include "support/target_scene.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/camera/calibration_file.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

CameraCalibrationRun run_of(const CameraModel& camera) {
  const TargetSize size{9, 6};
  auto views =
      bare_views(camera, good_poses(camera, TargetKind::Chessboard, size, 9), size, 0.1, 4);
  views[3].name = "<b>&\"tilted\".png";
  views.push_back({.name = "dark.png",
                   .reason = "no <chessboard> is seen",
                   .target = {},
                   .residuals = {},
                   .left_out = {},
                   .camera_from_target = {}});
  return {.calibration = calibrate_views(std::move(views), 640, 480).value(),
          .parameters = {},
          .spacing_m = {},
          .pictures = {}};
}

TEST(CalibrationProducts, TheFileHoldsTheCameraAndTheObjectAllFigures) {
  const TemporaryFolder folder;
  for (const CameraModel& camera :
       {pinhole(560, {-0.25, 0.08, 0.001, -0.001}), fisheye(260, {0.03, -0.01, 0.002, -0.0005})}) {
    CameraCalibrationRun run = run_of(camera);
    ASSERT_TRUE(write_camera_calibration(folder.path(), run));
    const auto read = read_calibration(folder.path() / "camera.yaml");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->lens(), run.calibration.camera.lens());
    EXPECT_EQ(read->camera_matrix(), run.calibration.camera.camera_matrix());
    EXPECT_EQ(read->distortion(), run.calibration.camera.distortion());

    const auto json = camera_calibration_json(run);
    EXPECT_THAT(json.dump(), Not(HasSubstr("nan")));
    EXPECT_EQ(json["lengths_are_in"], "spacings of the target");
    EXPECT_TRUE(json["target"]["spacing_m"].is_null());
    EXPECT_EQ(json["frames"]["used"], 9);
    EXPECT_EQ(json["frames"]["left_out"][0]["reason"], "no <chessboard> is seen");
    EXPECT_TRUE(json["views"][9]["rms_px"].is_null());
    const double distance = json["views"][0]["distance"];
    run.spacing_m = 0.03;
    EXPECT_NEAR(camera_calibration_json(run)["views"][0]["distance"], 0.03 * distance, 1e-9);
  }
}

TEST(CalibrationProducts, ThePageIsWholeAndSafeWhateverFilesAreCalled) {
  const std::string page =
      camera_calibration_report_html(run_of(pinhole(560, {-0.25, 0.08, 0.001, -0.001})));
  EXPECT_THAT(page, HasSubstr("&lt;b&gt;&amp;&quot;tilted&quot;.png"));
  EXPECT_THAT(page, HasSubstr("no &lt;chessboard&gt; is seen"));
  EXPECT_THAT(page, Not(HasSubstr("<b>&")));
  for (const char* outside : {"http://", "https://", "<script", "nan"})
    EXPECT_THAT(page, Not(HasSubstr(outside)));
}

TEST(CalibrationProducts, AViewsPictureIsSmallAndShowsItsPoints) {
  CalibrationView view;
  view.used = true;
  view.left_out = {false, true};
  view.target.emplace();
  view.target->points = {{{0, 0}, {200, 200}}, {{1, 0}, {600, 400}}};
  for (const cv::Mat& image :
       {cv::Mat(900, 1200, CV_16U, cv::Scalar(7000)), cv::Mat(900, 1200, CV_8U, cv::Scalar(90)),
        cv::Mat(900, 1200, CV_8UC3, cv::Scalar(90, 90, 90))}) {
    const std::string jpeg = view_jpeg(image, view);
    const cv::Mat picture =
        cv::imdecode(std::vector<char>(jpeg.begin(), jpeg.end()), cv::IMREAD_COLOR);
    EXPECT_EQ(picture.size(), cv::Size(480, 360));
    double least = 0, most = 0;
    cv::minMaxLoc(picture(cv::Rect(70, 70, 20, 20)).clone().reshape(1), &least, &most);
    EXPECT_GT(most - least, 50);
  }
}

}  // namespace
}  // namespace watersky::test
