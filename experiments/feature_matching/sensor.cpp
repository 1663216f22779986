// SPDX-License-Identifier: MIT
#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "study.hpp"
#include "watersky/io/image_file.hpp"

namespace watersky::study {

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? std::nan("") : sum / static_cast<double>(values.size());
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Result<std::vector<cv::Mat>> read_pictures(const std::filesystem::path& folder, int width_px) {
  WATERSKY_TRY(const auto files, list_images(folder));
  if (files.empty())
    return Error{ErrorCode::NotFound, folder.string() + ": holds no image (.jpg, .png or .tif)"};
  std::vector<cv::Mat> pictures;
  for (const auto& file : files) {
    WATERSKY_TRY(cv::Mat picture, image_loader(file)({.color = false}));
    if (picture.depth() == CV_16U) cv::normalize(picture, picture, 0, 255, cv::NORM_MINMAX, CV_8U);
    if (picture.cols > width_px) {
      const double scale = static_cast<double>(width_px) / picture.cols;
      cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

cv::Mat view_of(const cv::Mat& picture, const Eigen::Matrix3d& picture_from_view, cv::Size size) {
  cv::Matx33d m;
  for (int i = 0; i < 9; ++i) m.val[i] = picture_from_view(i / 3, i % 3);
  cv::Mat out;
  cv::warpPerspective(picture, out, m, size, cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                      cv::BORDER_REFLECT_101);
  return out;
}

cv::Mat fixed_pattern(cv::Size size, std::uint64_t seed) {
  constexpr double kPixels = 1.0, kColumns = 0.5;
  cv::RNG rng(seed);
  cv::Mat pixels(size, CV_32F), columns(1, size.width, CV_32F);
  rng.fill(pixels, cv::RNG::NORMAL, 0.0, kPixels);
  rng.fill(columns, cv::RNG::NORMAL, 0.0, kColumns);
  return pixels + cv::repeat(columns, size.height, 1);
}

cv::Mat seen_by_sensor(const cv::Mat& level, double contrast, const cv::Mat& pattern,
                       double noise_sigma, std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat noise(level.size(), CV_32F), value, out;
  rng.fill(noise, cv::RNG::NORMAL, 0.0, noise_sigma);
  level.convertTo(value, CV_32F);
  const double level_mean = cv::mean(value)[0];
  value = (value - level_mean) * contrast + level_mean + noise;
  if (!pattern.empty()) value += pattern;
  value.convertTo(out, CV_8U);
  return out;
}

}  // namespace watersky::study
