// SPDX-License-Identifier: MIT
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "study.hpp"
#include "watersky/io/image_file.hpp"

namespace watersky::study {

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
  const double mean = cv::mean(value)[0];
  value = (value - mean) * contrast + mean + noise;
  if (!pattern.empty()) value += pattern;
  value.convertTo(out, CV_8U);
  return out;
}

}  // namespace watersky::study
