// SPDX-License-Identifier: MIT
#include "watersky/camera/calibration_file.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <boost/property_tree/xml_parser.hpp>
#include <cctype>
#include <charconv>
#include <fstream>
#include <map>
#include <opencv2/core/persistence.hpp>
#include <optional>
#include <sstream>

namespace watersky {

namespace {

// cv::FileStorage is not asked to read: the parsers of OpenCV 4.6 crash on damaged files and
// refuse the indentation of ROS. yaml-cpp and Boost take all that OpenCV writes.

constexpr std::size_t kMaxBytes = 1 << 20;

Error bad(const std::string& message) { return {ErrorCode::InvalidInput, message}; }

/// Foreign text as a message can hold it: one line, not too long.
std::string shown(std::string text) {
  constexpr std::size_t kMost = 120;
  if (text.size() > kMost) text = text.substr(0, kMost - 3) + "...";
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return text;
}

/// What a field holds: words, and whether they stood in a list. Matrices are their data.
struct Field {
  std::vector<std::string> words;
  bool list = false;
};
using Fields = std::map<std::string, Field>;

Status add(Fields& fields, const std::string& name, Field field) {
  if (fields.emplace(name, std::move(field)).second) return {};
  return bad("field " + shown(name) + " stands there twice");
}

Result<Fields> read_yaml(const std::string& text) {
  // OpenCV's own first line, %YAML:1.0, is no YAML.
  std::string body;
  std::istringstream lines(text.rfind("\xEF\xBB\xBF", 0) == 0 ? text.substr(3) : text);
  for (std::string line; std::getline(lines, line); body += '\n')
    if (line.rfind("%YAML", 0) != 0) body += line;

  const YAML::Node root = YAML::Load(body);
  Fields fields;
  if (!root.IsMap()) return fields;
  for (const auto& entry : root) {
    if (!entry.first.IsScalar()) continue;
    const YAML::Node node = entry.second.IsMap() ? entry.second["data"] : entry.second;
    Field field;
    if (node && node.IsScalar()) field.words.push_back(node.Scalar());
    if (node && node.IsSequence()) {
      field.list = true;
      for (const auto& item : node)
        field.words.push_back(item.IsScalar() ? item.Scalar() : "a list");
    }
    WATERSKY_CHECK(add(fields, entry.first.Scalar(), std::move(field)));
  }
  return fields;
}

/// Boost's parser descends once for each element inside another.
bool nested_deeper_than(int limit, const std::string& xml) {
  int depth = 0;
  for (std::size_t i = 0; i + 1 < xml.size(); ++i) {
    if (xml[i] == '<' && xml[i + 1] != '?' && xml[i + 1] != '!')
      depth += xml[i + 1] == '/' ? -1 : 1;
    if (xml[i] == '/' && xml[i + 1] == '>') --depth;
    if (depth > limit) return true;
  }
  return false;
}

Result<Fields> read_xml(const std::string& text) {
  if (nested_deeper_than(50, text)) return bad("its elements are nested too deep");
  std::istringstream stream(text);
  boost::property_tree::ptree tree;
  boost::property_tree::read_xml(stream, tree, boost::property_tree::xml_parser::no_comments);
  const auto root = tree.get_child_optional("opencv_storage");
  if (!root) return bad("element opencv_storage is missing; is this an OpenCV calibration file?");
  Fields fields;
  for (const auto& [name, node] : *root) {
    if (name == "<xmlattr>") continue;
    const auto data = node.get_child_optional("data");
    std::istringstream words((data ? *data : node).data());
    Field field;
    for (std::string word; words >> word;) field.words.push_back(word);
    field.list = data.has_value() || field.words.size() > 1;
    WATERSKY_CHECK(add(fields, name, std::move(field)));
  }
  return fields;
}

const Field* first_of(const Fields& fields, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const auto it = fields.find(name); it != fields.end()) return &it->second;
  return nullptr;
}

template <class Number>
std::optional<Number> parse(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  Number number{};
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, number);
  if (error != std::errc() || stop != end) return std::nullopt;
  return number;
}

Result<std::vector<double>> numbers(const Field& field, const std::string& name) {
  if (!field.list) return bad("field " + name + " holds no list of numbers");
  std::vector<double> out;
  for (const std::string& word : field.words) {
    const auto number = parse<double>(word);
    if (!number)
      return bad("field " + name + " holds \"" + shown(word) + "\", which is not a number");
    out.push_back(*number);
  }
  return out;
}

Result<int> whole_number(const Fields& fields, std::initializer_list<const char*> names) {
  const std::string name = *names.begin();
  const Field* field = first_of(fields, names);
  if (!field) return bad("field " + name + " is missing");
  const auto number =
      field->list || field->words.size() != 1 ? std::nullopt : parse<int>(field->words[0]);
  if (!number) return bad("field " + name + " is not a whole number");
  return *number;
}

Result<LensModel> lens_of(const Fields& fields) {
  if (const Field* model = first_of(fields, {"camera_model", "distortion_model"})) {
    const std::string name = model->words.size() == 1 ? model->words[0] : "";
    if (name == "fisheye" || name == "equidistant") return LensModel::Fisheye;
    if (name != "pinhole" && name != "plumb_bob" && name != "rational_polynomial")
      return bad("camera_model \"" + shown(name) + "\" is not known; use pinhole or fisheye");
  }
  if (const Field* flag = first_of(fields, {"fisheye_model"}))
    if (flag->words.size() == 1 && flag->words[0] != "0") return LensModel::Fisheye;
  return LensModel::Pinhole;
}

Result<CameraModel> camera_from(const Fields& fields) {
  const Field* matrix_field = first_of(fields, {"camera_matrix", "Camera_Matrix"});
  if (!matrix_field)
    return bad("field camera_matrix is missing; is this an OpenCV calibration file?");
  WATERSKY_TRY(const std::vector<double> m, numbers(*matrix_field, "camera_matrix"));
  if (m.size() != 9)
    return bad("field camera_matrix must hold 9 numbers, holds " + std::to_string(m.size()));
  WATERSKY_TRY(const int width, whole_number(fields, {"image_width", "image_Width"}));
  WATERSKY_TRY(const int height, whole_number(fields, {"image_height", "image_Height"}));
  std::vector<double> distortion;
  if (const Field* field = first_of(
          fields, {"distortion_coefficients", "Distortion_Coefficients", "distortion_coeffs"})) {
    WATERSKY_TRY(distortion, numbers(*field, "distortion_coefficients"));
  }
  WATERSKY_TRY(const LensModel lens, lens_of(fields));

  Eigen::Matrix3d matrix;
  matrix << m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8];
  return CameraModel::make(lens, width, height, matrix, std::move(distortion));
}

bool names_xml(const std::string& name) {
  std::string ending = std::filesystem::path(name).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".xml";
}

}  // namespace

Result<CameraModel> parse_calibration(const std::string& text, const std::string& name) {
  if (text.size() > kMaxBytes) return bad(name + ": larger than a calibration file can be");
  if (text.find('\0') != std::string::npos) return bad(name + ": not a text file");
  try {
    const Result<Fields> fields = names_xml(name) ? read_xml(text) : read_yaml(text);
    if (!fields) return fields.error().at(name);
    Result<CameraModel> camera = camera_from(*fields);
    if (!camera) return camera.error().at(name);
    return camera;
  } catch (const std::exception& e) {
    return bad(name + ": not a valid OpenCV calibration file (" + shown(e.what()) + ")");
  }
}

Result<CameraModel> read_calibration(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return Error{ErrorCode::NotFound, path.string() + ": cannot be opened; is the path right?"};
  std::string text(kMaxBytes + 1, ' ');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse_calibration(text, path.string());
}

std::string format_calibration(const CameraModel& camera) {
  cv::FileStorage file(
      ".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
  const auto& a = camera.camera_matrix();
  file << "image_width" << camera.width_px() << "image_height" << camera.height_px();
  file << "camera_model" << (camera.lens() == LensModel::Fisheye ? "fisheye" : "pinhole");
  file << "camera_matrix"
       << cv::Mat((cv::Mat_<double>(3, 3) << a(0, 0), a(0, 1), a(0, 2), a(1, 0), a(1, 1), a(1, 2),
                   a(2, 0), a(2, 1), a(2, 2)));
  cv::Mat k(1, static_cast<int>(camera.distortion().size()), CV_64F);
  for (int i = 0; i < k.cols; ++i)
    k.at<double>(i) = camera.distortion()[static_cast<std::size_t>(i)];
  file << "distortion_coefficients" << k;
  return file.releaseAndGetString();
}

}  // namespace watersky
