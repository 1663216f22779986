// SPDX-License-Identifier: MIT
#include "watersky/io/mask_file.hpp"

#include <opencv2/core.hpp>

namespace watersky {

namespace fs = std::filesystem;

Result<cv::Mat> read_mask(const fs::path& file, ImageSize expected) {
  WATERSKY_TRY(const cv::Mat image, image_loader(file)(ImageRequest{}));
  if (image.depth() != CV_8U)
    return Error{ErrorCode::Unsupported,
                 file.string() + ": a mask has 8 bits a pixel, this one has 16; save it as 8 bit"};
  cv::Mat values = image;
  if (image.channels() == 3) {
    std::vector<cv::Mat> channels;
    cv::split(image, channels);
    if (cv::norm(channels[0], channels[1], cv::NORM_INF) > 0.0 ||
        cv::norm(channels[0], channels[2], cv::NORM_INF) > 0.0)
      return Error{ErrorCode::InvalidInput,
                   file.string() +
                       ": a mask has one channel whose values are classes, this one has colours; "
                       "save the classes as gray values"};
    values = channels[0];
  }
  if (values.cols != expected.width_px || values.rows != expected.height_px)
    return Error{ErrorCode::InvalidInput,
                 file.string() + ": the mask has " + std::to_string(values.cols) + "x" +
                     std::to_string(values.rows) + " pixels, its image " +
                     std::to_string(expected.width_px) + "x" + std::to_string(expected.height_px) +
                     "; give a mask of the image's size"};
  return values;
}

Result<cv::Mat> ice_in_mask(const cv::Mat& values, MaskValues meaning, PondIs pond) {
  constexpr unsigned char kPond = 0, kIce = 1, kOcean = 2;
  if (meaning == MaskValues::Binary) return cv::Mat(values != 0);
  bool has_255 = false;
  for (int y = 0; y < values.rows; ++y)
    for (int x = 0; x < values.cols; ++x) has_255 = has_255 || values.ptr(y)[x] == 255;
  const bool binary = meaning == MaskValues::Auto && has_255;
  for (int y = 0; y < values.rows; ++y)
    for (int x = 0; x < values.cols; ++x) {
      const unsigned char value = values.ptr(y)[x];
      if (binary ? value == 0 || value == 255 : value <= kOcean) continue;
      return Error{ErrorCode::InvalidInput,
                   "value " + std::to_string(value) + " in row " + std::to_string(y) + ", column " +
                       std::to_string(x) + " is no class: " +
                       (binary ? "with 255 in it this is a binary mask, 0 water and 255 ice; a "
                                 "picture that was compressed with losses is no mask"
                               : "0 is melt pond, 1 sea ice, 2 ocean; for 0 water and anything "
                                 "else ice say --truth-values binary")};
    }
  if (binary) return cv::Mat(values != 0);
  cv::Mat ice = values == kIce;
  if (pond == PondIs::Ice) ice.setTo(255, values == kPond);
  return ice;
}

Result<fs::path> find_mask(const fs::path& image, const std::vector<fs::path>& masks,
                           bool only_image) {
  std::vector<fs::path> found;
  std::string looked;
  std::error_code ignored;
  for (const fs::path& mask : masks) {
    looked += (looked.empty() ? "" : ", ") + mask.string();
    if (!fs::is_directory(mask, ignored)) {
      if (mask.stem() == image.stem()) found.push_back(mask);
      continue;
    }
    if (fs::is_regular_file(mask / image.filename(), ignored)) {
      found.push_back(mask / image.filename());
      continue;
    }
    WATERSKY_TRY(const auto files, list_images(mask));
    for (const fs::path& file : files)
      if (file.stem() == image.stem()) found.push_back(file);
  }
  if (found.size() == 1) return found.front();
  if (found.size() > 1)
    return Error{ErrorCode::InvalidInput, image.string() + ": " + found[0].string() + " and " +
                                              found[1].string() +
                                              " could both be its mask; give one"};
  if (only_image && masks.size() == 1 && fs::is_regular_file(masks[0], ignored)) return masks[0];
  return Error{ErrorCode::NotFound, image.string() + ": there is no mask for it in " + looked +
                                        "; a mask has the name of its image"};
}

}  // namespace watersky
