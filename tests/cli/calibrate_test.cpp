// SPDX-License-Identifier: MIT
/// `watersky calibrate camera`: the contract that others script against.
#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>

#include "cli_support.hpp"
#include "support/target_scene.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

/// A thermal camera of the small flight's image size and a plate with 7 by 5 cold holes, in 16
/// bit; one view is there twice, one image shows nothing.
const CameraModel& thermal_camera() {
  static const CameraModel camera = pinhole(300, {-0.2, 0.05, 0, 0}, 320, 256);
  return camera;
}

class CalibrateCamera : public ::testing::Test {
 protected:
  static const fs::path& images() {
    static const TemporaryFolder folder;
    static const fs::path made = [] {
      Scene scene;
      scene.kind = TargetKind::Holes;
      scene.size = {7, 5};
      scene.board = 90;
      scene.pattern = scene.around = 60;
      scene.gradient = 80;
      const TargetRenderer renderer(thermal_camera());
      const auto poses = good_poses(thermal_camera(), scene.kind, scene.size, 9, 0.6);
      const fs::path path = folder.path() / "plate";
      fs::create_directory(path);
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const cv::Mat levels = renderer.render(scene, poses[i], static_cast<unsigned>(i));
        cv::imwrite((path / ("view_" + std::to_string(i) + ".png")).string(), as_16_bit(levels, 4));
        if (i == 3)
          cv::imwrite((path / "view_3_again.png").string(),
                      as_16_bit(renderer.render(scene, poses[i], 99), 4));
      }
      cv::imwrite((path / "wall.png").string(), cv::Mat(256, 320, CV_16U, cv::Scalar(7300)));
      return path;
    }();
    return made;
  }
  [[nodiscard]] std::string out(const std::string& name = "out") const {
    return (folder_.path() / name).string();
  }
  [[nodiscard]] Outcome calibrate(const std::string& input, const std::string& options = "") const {
    return watersky("calibrate camera " + input + " -o '" + out() + "' " + options);
  }
  [[nodiscard]] static std::string folder() { return "'" + images().string() + "'"; }
  TemporaryFolder folder_;
};

TEST_F(CalibrateCamera, WritesWhatItPrintsAndWhatMapTakes) {
  const Outcome o = calibrate(folder(), "--target holes --spacing-m 0.04 --json");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto json = o.json();
  EXPECT_EQ(json, nlohmann::json::parse(read_text(out() + "/calibration.json")));
  EXPECT_EQ(json["verb"], "calibrate camera");
  EXPECT_EQ(json["target"]["kind"], "holes");
  EXPECT_EQ(json["target"]["size"], "7x5");
  EXPECT_EQ(json["target"]["size_was_found"], true);
  EXPECT_EQ(json["lengths_are_in"], "m");
  EXPECT_EQ(json["camera_model"], "pinhole");
  EXPECT_EQ(json["frames"]["total"], 11);
  EXPECT_EQ(json["frames"]["used"], 9);
  for (const auto& p : json["intrinsics"]) {
    if (p["name"] == "fx") {
      EXPECT_NEAR(p["value"], 300, 4 * p["sigma"].get<double>());
      EXPECT_NEAR(p["value"], 300, 0.9);
    }
  }
  std::map<std::string, nlohmann::json> views;
  for (const auto& view : json["views"]) views[view["file"]] = view;
  EXPECT_THAT(views["wall.png"]["reason"].get<std::string>(), HasSubstr("no grid of holes"));
  EXPECT_THAT(views["view_3_again.png"]["reason"].get<std::string>(), HasSubstr("view_3.png"));
  EXPECT_EQ(views["view_0.png"]["used"], true);
  EXPECT_EQ(views["view_0.png"]["circles_are"], "darker");
  EXPECT_EQ(views["view_0.png"]["points"].size(), 35u);
  EXPECT_TRUE(views["view_0.png"]["reason"].is_null());
  EXPECT_NEAR(views["view_0.png"]["circle_radius"], 0.012, 0.001);
  EXPECT_THAT(o.err, HasSubstr("rejected: wall.png: "));

  // OpenCV itself reads the file.
  cv::FileStorage file(out() + "/camera.yaml", cv::FileStorage::READ);
  cv::Mat matrix;
  file["camera_matrix"] >> matrix;
  EXPECT_NEAR(matrix.at<double>(0, 0), json["camera_matrix"][0], 1e-9);

  const std::string report = read_text(out() + "/report.html");
  for (const char* part : {"Residuals", "Where the target was seen", "Distortion", "Parameters",
                           "Lens models", "Views", "view_3_again.png", "data:image/jpeg;base64,"})
    EXPECT_THAT(report, HasSubstr(part));
  EXPECT_EQ(report.find("src=\"http"), std::string::npos);

  const Outcome map = watersky("map '" + small_flight().string() + "' -o '" + out("map") +
                               "' --camera '" + out() + "/camera.yaml' --no-mosaic");
  EXPECT_EQ(map.status, 0) << map.err;
}

TEST_F(CalibrateCamera, TakesPatternsAndSaysInWordsWhatItFound) {
  const Outcome o = calibrate("'" + images().string() + "/view_?.png'", "--size 7x5");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("from 9 of 9 views of circles 7x5"));
  EXPECT_THAT(o.out, HasSubstr("fx"));
  EXPECT_THAT(o.out, HasSubstr("--camera " + out() + "/camera.yaml"));
  // What stands there is replaced only on request, and only if it is ours.
  expect_one_line_error(calibrate(folder()), 1);
  EXPECT_EQ(calibrate(folder(), "--target holes --overwrite --quiet").status, 0);
  write_text(out() + "/calibration.json", "{}");
  expect_one_line_error(calibrate(folder(), "--target holes --overwrite"), 1);
}

TEST_F(CalibrateCamera, WhatTheImagesDoNotTellIsOneLineAndStatusOne) {
  const std::string one = (images() / "view_0.png").string();
  const Outcome few = calibrate("'" + one + "'", "--target holes");
  expect_one_line_error(few, 1);
  EXPECT_THAT(few.err, HasSubstr("4 are needed"));
  const Outcome same =
      calibrate("'" + one + "' '" + one + "' '" + one + "' '" + one + "'", "--target holes");
  expect_one_line_error(same, 1);
  EXPECT_THAT(same.err, HasSubstr("at one place"));
  const Outcome size = calibrate(folder(), "--target holes --size 20x20");
  expect_one_line_error(size, 1);
  EXPECT_THAT(size.err, HasSubstr("7x5"));
  expect_one_line_error(calibrate(folder(), "--target chessboard"), 1);
  expect_one_line_error(calibrate("/no/such/folder/'*.png'"), 1);
  expect_one_line_error(calibrate("/no/such/image.png"), 1);
  write_text(folder_.path() / "letter.png", "dear");
  expect_one_line_error(calibrate("'" + (folder_.path() / "letter.png").string() + "'"), 1);
  EXPECT_FALSE(fs::exists(out()));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1)
      << "no temporary folder stays";
}

TEST_F(CalibrateCamera, WrongCallsAreStatusTwo) {
  EXPECT_EQ(watersky("calibrate").status, 2);
  EXPECT_EQ(watersky("calibrate camera " + folder()).status, 2);  // no -o
  EXPECT_EQ(watersky("calibrate camera -o '" + out() + "'").status, 2);
  for (const char* options : {"--target poster", "--size 9", "--size 2x2", "--spacing-m 0",
                              "--spacing-m nan", "--lens wide", "--min-views 2"})
    EXPECT_EQ(calibrate(folder(), options).status, 2) << options;
}

}  // namespace
}  // namespace watersky::test
