// SPDX-License-Identifier: MIT
#include "watersky/camera/calibration_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <random>

#include "support/matchers.hpp"

namespace watersky {
namespace {

using test::fails_with;
using test::succeeds;

const cv::Mat kMatrix =
    (cv::Mat_<double>(3, 3) << 501.25, 0, 320.125, 0, 499.75, 241.0625, 0, 0, 1);
const cv::Mat kFive = (cv::Mat_<double>(5, 1) << -0.21, 0.043, 1.5e-3, -7e-4, 0.0125);

void expect_is_the_camera(const Result<CameraModel>& camera, LensModel lens = LensModel::Pinhole) {
  ASSERT_TRUE(succeeds(camera));
  EXPECT_EQ(camera->lens(), lens);
  EXPECT_EQ(camera->width_px(), 640);
  EXPECT_EQ(camera->height_px(), 480);
  EXPECT_EQ(camera->camera_matrix()(0, 0), 501.25);
  EXPECT_EQ(camera->camera_matrix()(1, 1), 499.75);
  EXPECT_EQ(camera->camera_matrix()(0, 2), 320.125);
  EXPECT_EQ(camera->camera_matrix()(1, 2), 241.0625);
  if (lens == LensModel::Pinhole)
    EXPECT_EQ(camera->distortion(),
              (std::vector{-0.21, 0.043, 1.5e-3, -7e-4, 0.0125, 0.0, 0.0, 0.0}));
  else
    EXPECT_EQ(camera->distortion(), (std::vector{-0.02, 0.004, -1e-3, 1e-4}));
}

/// A calibration as cv::FileStorage itself writes it.
template <class Fill>
std::string written_by_opencv(const std::string& ending, const Fill& fill) {
  cv::FileStorage file(ending, cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  fill(file);
  return file.releaseAndGetString();
}

TEST(CalibrationFile, ReadsWhatOpenCvWritesAsYamlAndXml) {
  for (const std::string ending : {".yaml", ".yml", ".xml"}) {
    const std::string text = written_by_opencv(ending, [](cv::FileStorage& file) {
      file << "image_width" << 640 << "image_height" << 480 << "camera_matrix" << kMatrix
           << "distortion_coefficients" << kFive;
    });
    expect_is_the_camera(parse_calibration(text, "camera" + ending));
  }
}

// The spelling of A.2.3 and of OpenCV's calibration sample, which adds much that we do not need.
TEST(CalibrationFile, ReadsTheOldSpellingOfOpenCvsCalibrationSample) {
  for (const std::string ending : {".yml", ".xml"}) {
    const std::string text = written_by_opencv(ending, [](cv::FileStorage& file) {
      file << "calibration_Time"
           << "Thu Apr  2 10:11:12 2015"
           << "nrOfFrames" << 25 << "image_Width" << 640 << "image_Height" << 480 << "board_Width"
           << 9 << "flagValue" << 6 << "Camera_Matrix" << kMatrix << "Distortion_Coefficients"
           << kFive << "Avg_Reprojection_Error" << 0.123 << "Image_points"
           << cv::Mat::zeros(25, 54, CV_32FC2);
    });
    expect_is_the_camera(parse_calibration(text, "out_camera_data" + ending));
  }
}

TEST(CalibrationFile, ReadsRosCameraInfo) {
  const std::string text = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [501.25, 0, 320.125, 0, 499.75, 241.0625, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.21, 0.043, 0.0015, -0.0007, 0.0125]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [501.25, 0, 320.125, 0, 0, 499.75, 241.0625, 0, 0, 0, 1, 0]
)";
  expect_is_the_camera(parse_calibration(text, "head_camera.yaml"));
  expect_is_the_camera(parse_calibration("---\n" + text, "head_camera.yaml"));
  expect_is_the_camera(parse_calibration("# a comment\n" + text, "head_camera.yaml"));
}

TEST(CalibrationFile, ReadsWhatPeoplesEditorsMakeOfIt) {
  std::string text = written_by_opencv(".yaml", [](cv::FileStorage& file) {
    file << "image_width" << 640 << "image_height" << 480 << "camera_matrix" << kMatrix
         << "distortion_coefficients" << kFive;
  });
  expect_is_the_camera(parse_calibration("\xEF\xBB\xBF" + text, "camera.yaml"));  // Windows' mark
  expect_is_the_camera(parse_calibration("# ours\n" + text, "camera.yaml"));
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  expect_is_the_camera(parse_calibration(crlf, "camera.yaml"));
  expect_is_the_camera(parse_calibration(text, "camera"));  // no ending: YAML
}

TEST(CalibrationFile, AnXmlEndingMayBeInCapitals) {
  const std::string text = written_by_opencv(".xml", [](cv::FileStorage& file) {
    file << "image_width" << 640 << "image_height" << 480 << "camera_matrix" << kMatrix
         << "distortion_coefficients" << kFive;
  });
  expect_is_the_camera(parse_calibration(text, "CAMERA.XML"));
}

TEST(CalibrationFile, TellsFisheyeByAnyOfItsNames) {
  const cv::Mat four = (cv::Mat_<double>(4, 1) << -0.02, 0.004, -1e-3, 1e-4);
  for (const auto& [key, value] : {std::pair{"camera_model", "fisheye"},
                                   {"distortion_model", "equidistant"},
                                   {"fisheye_model", ""}}) {
    const std::string text = written_by_opencv(".yaml", [&](cv::FileStorage& file) {
      file << "image_width" << 640 << "image_height" << 480;
      if (*value)
        file << key << value;
      else
        file << key << 1;
      file << "camera_matrix" << kMatrix << "distortion_coefficients" << four;
    });
    expect_is_the_camera(parse_calibration(text, "camera.yaml"), LensModel::Fisheye);
  }
}

TEST(CalibrationFile, FormatsWhatItReadsBackExactly) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const bool round = i % 2 == 0;
    Eigen::Matrix3d a;
    a << 700 + 300 * unit(rng), 0, 320 + unit(rng), 0, 700 + 300 * unit(rng), 240 + unit(rng), 0, 0,
        1;
    std::vector<double> k(round ? 4 : 8);
    for (double& c : k) c = 0.3 * unit(rng) * std::pow(10, 4 * unit(rng) - 4);
    const auto camera =
        CameraModel::make(round ? LensModel::Fisheye : LensModel::Pinhole, 640, 480, a, k).value();
    const std::string text = format_calibration(camera);
    const auto back = parse_calibration(text, "camera.yaml");
    ASSERT_TRUE(succeeds(back));
    EXPECT_EQ(back->camera_matrix(), camera.camera_matrix());
    EXPECT_EQ(back->distortion(), camera.distortion());
    EXPECT_EQ(back->lens(), camera.lens());
    EXPECT_EQ(back->width_px(), 640);
    EXPECT_EQ(back->height_px(), 480);

    cv::FileStorage opencv(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    cv::Mat matrix;
    opencv["camera_matrix"] >> matrix;
    ASSERT_EQ(matrix.size(), cv::Size(3, 3));
    EXPECT_EQ(matrix.at<double>(1, 2), a(1, 2));
  }
}

std::string yaml(const std::string& width, const std::string& matrix, const std::string& distortion,
                 const std::string& more = "") {
  return "%YAML:1.0\n---\nimage_width: " + width + "\nimage_height: 480\ncamera_matrix: " + matrix +
         "\ndistortion_coefficients: " + distortion + "\n" + more;
}

TEST(CalibrationFile, NamesTheFileAndTheFieldAtFault) {
  const std::string good = "[ 500., 0., 320., 0., 500., 240., 0., 0., 1. ]",
                    none = "[ 0., 0., 0., 0. ]";
  ASSERT_TRUE(succeeds(parse_calibration(yaml("640", good, none), "c.yaml")));
  const auto code = ErrorCode::InvalidInput;
  const auto fails = [&](const std::string& text, std::string_view field) {
    return fails_with(parse_calibration(text, "dir/c.yaml"), code, {"dir/c.yaml", field});
  };
  EXPECT_TRUE(fails("", "c.yaml"));
  EXPECT_TRUE(fails("%YAML:1.0\n---\n", "camera_matrix"));
  EXPECT_TRUE(fails(yaml("640", good, none, "image_width: 320\n"), "image_width"));
  EXPECT_TRUE(fails("just words\n", "c.yaml"));
  EXPECT_TRUE(fails("- 1\n- 2\n", "c.yaml"));
  EXPECT_TRUE(fails(std::string("image_width: 640\0", 17), "not a text file"));
  EXPECT_TRUE(fails(yaml("640", good, none).substr(0, 60), "c.yaml"));
  EXPECT_TRUE(fails("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n", "camera_matrix"));
  EXPECT_TRUE(
      fails("%YAML:1.0\n---\nimage_width: 640\ncamera_matrix: " + good + "\n", "image_height"));
  EXPECT_TRUE(fails(yaml("wide", good, none), "image_width"));
  EXPECT_TRUE(fails(yaml("640.5", good, none), "image_width"));
  EXPECT_TRUE(fails(yaml("-640", good, none), "image_width"));
  EXPECT_TRUE(fails(yaml("0", good, none), "image_width"));
  EXPECT_TRUE(fails(yaml("99999999999999999999", good, none), "image_width"));
  EXPECT_TRUE(fails(yaml("[640]", good, none), "image_width"));
  EXPECT_TRUE(fails(yaml("640", "[ 1., 2. ]", none), "camera_matrix"));
  EXPECT_TRUE(fails(yaml("640", "7", none), "camera_matrix"));
  EXPECT_TRUE(fails(yaml("640", "{ rows: 3 }", none), "camera_matrix"));
  EXPECT_TRUE(
      fails(yaml("640", "[ 500., 0., 320., 0., five, 240., 0., 0., 1. ]", none), "camera_matrix"));
  EXPECT_TRUE(
      fails(yaml("640", "[ .Nan, 0., 320., 0., 500., 240., 0., 0., 1. ]", none), "camera_matrix"));
  EXPECT_TRUE(
      fails(yaml("640", "[ -500., 0., 320., 0., 500., 240., 0., 0., 1. ]", none), "camera_matrix"));
  EXPECT_TRUE(
      fails(yaml("640", "[ 500., 3., 320., 0., 500., 240., 0., 0., 1. ]", none), "camera_matrix"));
  EXPECT_TRUE(fails(yaml("640", good, "[ 0.1, 0.2 ]"), "distortion_coefficients"));
  EXPECT_TRUE(fails(yaml("640", good, "[ .Inf, 0., 0., 0. ]"), "distortion_coefficients"));
  EXPECT_TRUE(fails(yaml("640", good, "none"), "distortion_coefficients"));
  EXPECT_TRUE(fails(yaml("640", good, none, "camera_model: kaleidoscope\n"), "kaleidoscope"));
  EXPECT_TRUE(fails(yaml("640", good, none, "camera_model: 3\n"), "camera_model"));
  EXPECT_TRUE(fails("<?xml version=\"1.0\"?>\n<opencv_storage><image_width>640", "c.yaml"));
  EXPECT_TRUE(fails_with(parse_calibration("<opencv_storage>", "c.xml"), code, {"c.xml"}));
  EXPECT_TRUE(fails_with(parse_calibration("", "c.xml"), code, {"c.xml"}));
}

TEST(CalibrationFile, AMessageStaysOneShortLineWhateverTheFileHolds) {
  for (const std::string& junk :
       {std::string("camera_matrix: \x01\x02\n\xff\xfe: {"), std::string(300, '{'),
        "camera_model: \"" + std::string(5000, 'x') + "\\n\"\n"}) {
    const auto camera = parse_calibration(
        yaml("640", "[ 500., 0., 320., 0., 500., 240., 0., 0., 1. ]", "[ 0., 0., 0., 0. ]", junk),
        "c.yaml");
    EXPECT_TRUE(fails_with(camera, ErrorCode::InvalidInput, {"c.yaml"}));
    ASSERT_FALSE(camera.ok());
    EXPECT_LT(camera.error().message.size(), 400u);
  }
}

// Parsers descend once for each bracket.
TEST(CalibrationFile, RefusesNestingThatWouldOverflowTheStack) {
  const auto repeat = [](const std::string& s, int n) {
    std::string out;
    for (int i = 0; i < n; ++i) out += s;
    return out;
  };
  const auto code = ErrorCode::InvalidInput;
  EXPECT_TRUE(
      fails_with(parse_calibration("a: " + std::string(500000, '['), "c.yaml"), code, {"c.yaml"}));
  EXPECT_TRUE(
      fails_with(parse_calibration("a: " + repeat("{ b: ", 200000), "c.yaml"), code, {"c.yaml"}));
  EXPECT_TRUE(fails_with(parse_calibration("{\"a\": " + std::string(500000, '['), "c.yaml"), code,
                         {"c.yaml"}));
  std::string indented;
  for (int i = 0; i < 1300; ++i) indented += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_TRUE(fails_with(parse_calibration(indented, "c.yaml"), code, {"c.yaml"}));
  EXPECT_TRUE(fails_with(
      parse_calibration("<?xml version=\"1.0\"?>\n<opencv_storage>\n" + repeat("<a>", 300000),
                        "c.xml"),
      code, {"c.xml"}));
  EXPECT_TRUE(
      fails_with(parse_calibration("a: " + repeat("- ", 400000), "c.yaml"), code, {"c.yaml"}));
}

// Every mutation is either read or refused in one line.
TEST(CalibrationFile, SurvivesDamage) {
  const std::string xml = written_by_opencv(".xml", [](cv::FileStorage& file) {
    file << "image_width" << 640 << "image_height" << 480 << "camera_matrix" << kMatrix
         << "distortion_coefficients" << kFive;
  });
  const std::string text = format_calibration(parse_calibration(xml, "c.xml").value());
  std::mt19937 rng(1);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(rng);
  };
  for (int i = 0; i < 6000; ++i) {
    const bool as_xml = i % 2 == 0;
    std::string damaged = as_xml ? xml : text;
    for (std::size_t n = below(4) + 1; n > 0; --n) {
      const std::size_t at = below(damaged.size());
      switch (below(4)) {
        case 0: damaged[at] = static_cast<char>(below(255) + 1); break;
        case 1: damaged.erase(at, below(20) + 1); break;
        case 2: damaged.insert(at, damaged.substr(below(damaged.size()), 30)); break;
        default: damaged.resize(std::max<std::size_t>(at, 1)); break;
      }
    }
    const auto camera = parse_calibration(damaged, as_xml ? "c.xml" : "c.yaml");
    if (!camera) {
      EXPECT_TRUE(fails_with(camera, ErrorCode::InvalidInput, {as_xml ? "c.xml" : "c.yaml"}))
          << damaged;
    }
  }
}

TEST(CalibrationFile, SaysWhenTheFileIsNotThere) {
  EXPECT_TRUE(fails_with(read_calibration("no/such/camera.yaml"), ErrorCode::NotFound,
                         {"no/such/camera.yaml"}));
  EXPECT_TRUE(fails_with(read_calibration(std::filesystem::temp_directory_path()),
                         ErrorCode::InvalidInput,
                         {std::filesystem::temp_directory_path().string()}));
}

TEST(CalibrationFile, ReadsAFileAndRefusesOneThatNeverEnds) {
  const auto path = std::filesystem::temp_directory_path() / "watersky_calibration_file_test.yaml";
  const auto camera =
      parse_calibration(
          yaml("640", "[ 500., 0., 320., 0., 500., 240., 0., 0., 1. ]", "[ 0., 0., 0., 0. ]"),
          "c.yaml")
          .value();
  std::ofstream(path) << format_calibration(camera);
  EXPECT_TRUE(succeeds(read_calibration(path)));
  std::filesystem::remove(path);
  if (std::filesystem::exists("/dev/zero")) {
    EXPECT_TRUE(fails_with(read_calibration("/dev/zero"), ErrorCode::InvalidInput, {"/dev/zero"}));
  }
}

}  // namespace
}  // namespace watersky
