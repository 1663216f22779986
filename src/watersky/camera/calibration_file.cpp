// SPDX-License-Identifier: MIT
#include "watersky/camera/calibration_file.hpp"

#include <fstream>
#include <opencv2/core/persistence.hpp>
#include <sstream>

namespace watersky {

namespace {

Error bad(const std::string& message) { return {ErrorCode::InvalidInput, message}; }

cv::FileNode first_of(const cv::FileStorage& file, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (cv::FileNode node = file[name]; !node.empty()) return node;
  return {};
}

/// The numbers of an OpenCV matrix, or of ROS's plain {rows, cols, data} mapping.
Result<std::vector<double>> numbers(const cv::FileNode& node, const std::string& field) {
  cv::FileNode list = node;
  if (node.isMap()) list = node["data"];
  if (!list.isSeq()) return bad("field " + field + " holds no list of numbers");
  if (list.size() > 64) return bad("field " + field + " has too many numbers");
  std::vector<double> out;
  for (const auto& item : list) {
    if (!item.isInt() && !item.isReal()) return bad("field " + field + " holds something that is not a number");
    out.push_back(item.real());
  }
  return out;
}

Result<int> positive_int(const cv::FileStorage& file, std::initializer_list<const char*> names) {
  const cv::FileNode node = first_of(file, names);
  if (!node.isInt()) return bad(std::string("field ") + *names.begin() + " (a whole number) is missing");
  return static_cast<int>(node);
}

Result<CameraModel> from_storage(const cv::FileStorage& file) {
  const cv::FileNode matrix_node = first_of(file, {"camera_matrix", "Camera_Matrix"});
  if (matrix_node.empty()) return bad("field camera_matrix is missing; is this an OpenCV calibration file?");
  WATERSKY_TRY(const std::vector<double> m, numbers(matrix_node, "camera_matrix"));
  if (m.size() != 9) return bad("field camera_matrix must hold 9 numbers, holds " + std::to_string(m.size()));
  WATERSKY_TRY(const int width, positive_int(file, {"image_width", "image_Width"}));
  WATERSKY_TRY(const int height, positive_int(file, {"image_height", "image_Height"}));

  std::vector<double> distortion;
  if (const cv::FileNode node = first_of(
          file, {"distortion_coefficients", "Distortion_Coefficients", "distortion_coeffs"});
      !node.empty()) {
    WATERSKY_TRY(distortion, numbers(node, "distortion_coefficients"));
  }

  LensModel lens = LensModel::Pinhole;
  std::string name;
  if (const cv::FileNode node = first_of(file, {"camera_model", "distortion_model"}); node.isString())
    name = static_cast<std::string>(node);
  if (name == "fisheye" || name == "equidistant") {
    lens = LensModel::Fisheye;
  } else if (!name.empty() && name != "pinhole" && name != "plumb_bob" && name != "rational_polynomial") {
    return bad("camera_model \"" + name + "\" is not known; use pinhole or fisheye");
  }
  if (const cv::FileNode node = file["fisheye_model"]; node.isInt() && static_cast<int>(node) != 0)
    lens = LensModel::Fisheye;

  Eigen::Matrix3d matrix;
  matrix << m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8];
  return CameraModel::make(lens, width, height, matrix, std::move(distortion));
}

}  // namespace

Result<CameraModel> parse_calibration(const std::string& text, const std::string& name) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  if (text.size() > kMaxBytes) return bad(name + ": larger than a calibration file can be");
  if (text.find('\0') != std::string::npos) return bad(name + ": not a text file");
  try {
    const bool xml = name.size() > 4 && name.substr(name.size() - 4) == ".xml";
    std::string body = text;
    // ROS and people write YAML without the directive that cv::FileStorage insists on.
    if (!xml && body.rfind("%YAML", 0) != 0) body = "%YAML:1.0\n---\n" + body;
    cv::FileStorage file(body, cv::FileStorage::READ | cv::FileStorage::MEMORY |
                                   (xml ? cv::FileStorage::FORMAT_XML : cv::FileStorage::FORMAT_YAML));
    if (!file.isOpened()) return bad(name + ": cannot be read as an OpenCV calibration file");
    Result<CameraModel> model = from_storage(file);
    if (!model) return model.error().at(name);
    return model;
  } catch (const std::exception& e) {
    std::string why = e.what();
    for (char& c : why)
      if (c == '\n' || c == '\r') c = ' ';
    return bad(name + ": not a valid OpenCV " + "calibration file (" + why + ")");
  }
}

Result<CameraModel> read_calibration(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::NotFound, path.string() + ": cannot be opened; is the path right?"};
  std::ostringstream text;
  text << file.rdbuf();
  return parse_calibration(text.str(), path.string());
}

std::string format_calibration(const CameraModel& camera) {
  cv::FileStorage file(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY |
                                    cv::FileStorage::FORMAT_YAML);
  const auto& a = camera.camera_matrix();
  file << "image_width" << camera.width_px() << "image_height" << camera.height_px();
  file << "camera_model" << (camera.lens() == LensModel::Fisheye ? "fisheye" : "pinhole");
  file << "camera_matrix"
       << cv::Mat((cv::Mat_<double>(3, 3) << a(0, 0), a(0, 1), a(0, 2), a(1, 0), a(1, 1), a(1, 2),
                   a(2, 0), a(2, 1), a(2, 2)));
  cv::Mat k(1, static_cast<int>(camera.distortion().size()), CV_64F);
  for (int i = 0; i < k.cols; ++i) k.at<double>(i) = camera.distortion()[static_cast<std::size_t>(i)];
  file << "distortion_coefficients" << k;
  return file.releaseAndGetString();
}

}  // namespace watersky
