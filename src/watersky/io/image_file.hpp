// SPDX-License-Identifier: MIT
#pragma once
/// Image files as a flight's frames: JPEG through libjpeg-turbo, PNG and TIFF (8 and 16 bit)
/// through OpenCV. Pixels come as they were stored: EXIF orientation is not applied.
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "watersky/flight/flight.hpp"

namespace watersky {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

/// Whether the name ends as one that we read: .jpg .jpeg .png .tif .tiff, in either case.
[[nodiscard]] bool is_image_file(const std::filesystem::path& file);

/// The images in `folder` by name, without those in folders below it.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_images(
    const std::filesystem::path& folder);

/// The size from the file's header; nothing is decoded.
[[nodiscard]] Result<ImageSize> probe_image_size(const std::filesystem::path& file);

/// Decodes an image in memory; the format is recognised by its first bytes. `name` stands in
/// errors. A JPEG that ends early or is damaged is InvalidInput, never half a picture.
///
/// A reduced JPEG is decoded from the low frequencies alone. Where 8x8 blocks reduced do not
/// tile the image exactly it is resampled, so that it always covers the whole field, as
/// CameraModel::scaled_to expects. A gray JPEG is decoded from its luma alone.
[[nodiscard]] Result<cv::Mat> decode_image(std::span<const std::uint8_t> bytes,
                                           const ImageRequest& request, const std::string& name);

/// The same, but a FLIR radiometric JPEG (flir.hpp) gives its 16-bit counts, in full size, where
/// they are of the picture's size.
[[nodiscard]] Result<cv::Mat> load_image(std::span<const std::uint8_t> bytes,
                                         const ImageRequest& request, const std::string& name);

/// InvalidInput, saying both, when an image that was asked for thus is of another size.
[[nodiscard]] Status check_image_size(const cv::Mat& image, const ImageRequest& request,
                                      const ImageSize& expected, const std::string& name);

/// load_image() of `file` anew at each call; with `expected` its size is checked.
[[nodiscard]] ImageLoader image_loader(const std::filesystem::path& file,
                                       std::optional<ImageSize> expected = std::nullopt);

}  // namespace watersky
