// SPDX-License-Identifier: MIT
/// `watersky register A B`: the homography from one picture to another.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "cli.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/registration/homography.hpp"
#include "watersky/registration/registration.hpp"

namespace watersky::cli {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
  std::string a, b, out;
  std::string method{name_of(RegistrationMethod::Klt)};
};

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json rows_of(const Eigen::Matrix<double, 8, 8>& matrix) {
  if (!matrix.allFinite()) return nullptr;
  json rows = json::array();
  for (int i = 0; i < 8; ++i) {
    json row = json::array();
    for (int k = 0; k < 8; ++k) row.push_back(matrix(i, k));
    rows.push_back(std::move(row));
  }
  return rows;
}

json to_json(const Options& options, const Registration& found, double seconds) {
  json result{{"registered", found.fit.has_value()},
              {"method", options.method},
              {"homography", nullptr},
              {"covariance", nullptr},
              {"covariance_of", {"h11", "h12", "h13", "h21", "h22", "h23", "h31", "h32"}},
              {"corner_covariance_px2", nullptr},
              {"corner_sigma_px", nullptr},
              {"reason", nullptr},
              {"matches", found.matches.size()},
              {"inliers", found.inliers},
              {"mean_reprojection_px", number(found.mean_reprojection_px)},
              {"inlier_mean_reprojection_px", number(found.inlier_mean_px)},
              {"correlation", number(found.correlation)},
              {"overlap", number(found.overlap)},
              {"seconds", seconds}};
  if (!found.start.empty()) result["start"] = found.start;
  if (!found.fit) {
    result["reason"] = found.reason;
    return result;
  }
  json h = json::array();
  for (int i = 0; i < 9; ++i) h.push_back(found.fit->b_from_a(i / 3, i % 3));
  result["homography"] = std::move(h);
  result["covariance"] = rows_of(found.fit->covariance);
  result["corner_covariance_px2"] = rows_of(found.fit->corner_covariance);
  result["corner_sigma_px"] = number(found.fit->corner_sigma_px);
  return result;
}

void print(const Options& options, const Registration& found, cv::Size a_size,
           const Common& common) {
  char line[200];
  if (!found.fit) {
    say(common, "not registered (" + options.method + "): " + found.reason);
  } else {
    const auto& h = found.fit->b_from_a;
    say(common, "registered (" + options.method + "), pixels of A to pixels of B:");
    for (int i = 0; i < 3; ++i) {
      std::snprintf(line, sizeof line, "  %14.8g %14.8g %14.8g", h(i, 0), h(i, 1), h(i, 2));
      say(common, line);
    }
    const cv::Point2d middle((a_size.width - 1) / 2.0, (a_size.height - 1) / 2.0);
    const cv::Point2d moved = watersky::apply(h, middle) - middle;
    std::snprintf(line, sizeof line,
                  "  the middle moves by %.2f, %.2f px; the corners are known to %.2f px", moved.x,
                  moved.y, found.fit->corner_sigma_px);
    say(common, line);
  }
  std::snprintf(line, sizeof line, "  %zu matches, %zu inliers; mean reprojection %.2f px (%.2f)",
                found.matches.size(), found.inliers, found.mean_reprojection_px,
                found.inlier_mean_px);
  if (std::isfinite(found.mean_reprojection_px)) say(common, line);
  if (std::isfinite(found.correlation)) {
    std::snprintf(line, sizeof line, "  overlap %.0f %%, in which the pictures correlate to %.2f",
                  100 * found.overlap, found.correlation);
    say(common, line);
  }
}

VerbResult run(const Options& options, const Common& common) {
  const auto method = registration_method(options.method);
  WATERSKY_TRY(const auto registrar, make_registrar(*method));
  WATERSKY_TRY(const cv::Mat a, image_loader(options.a)({.color = false}));
  WATERSKY_TRY(const cv::Mat b, image_loader(options.b)({.color = false}));
  const auto start = std::chrono::steady_clock::now();
  WATERSKY_TRY(const RegistrationFrame frame_a, registrar->prepare(a));
  WATERSKY_TRY(const RegistrationFrame frame_b, registrar->prepare(b));
  WATERSKY_TRY(const Registration found, registrar->align(frame_a, frame_b));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  print(options, found, a.size(), common);
  if (!options.out.empty()) {
    std::vector<unsigned char> bytes;
    if (!cv::imencode(fs::path(options.out).extension().string(), draw_matches(a, b, found), bytes))
      return Error{ErrorCode::Io, options.out + ": cannot be encoded"};
    WATERSKY_CHECK(
        write_file(options.out, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
    say(common, "  " + options.out + ": the matches");
  }
  return to_json(options, found, seconds);
}

}  // namespace

void add_register(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App& verb = add_verb(app, "register",
                            "Find the homography from pixels of one picture to those of another",
                            [options](const Common& common) { return run(*options, common); });
  verb.add_option("A", options->a, "the picture to start from: JPEG, PNG, TIFF, 8 or 16 bit")
      ->required();
  verb.add_option("B", options->b, "the picture to arrive at")->required();
  std::vector<std::string> methods;
  for (const RegistrationMethod m : registration_methods()) methods.emplace_back(name_of(m));
  verb.add_option("--method", options->method,
                  "klt is ours; the others are the thesis's procedure (surf only where OpenCV has "
                  "it)")
      ->check(CLI::IsMember(methods))
      ->capture_default_str();
  verb.add_option("-o,--out", options->out, "write a picture of the matches: .png or .jpg")
      ->check([](const std::string& path) {
        const std::string e = lower_extension(path);
        return e == ".png" || e == ".jpg" || e == ".jpeg" ? std::string()
                                                          : path + " ends in neither .png nor .jpg";
      });
}

}  // namespace watersky::cli
