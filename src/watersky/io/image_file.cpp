// SPDX-License-Identifier: MIT
#include "watersky/io/image_file.hpp"

#include <gdal.h>
#include <turbojpeg.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/io/exif.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/flir.hpp"
#include "watersky/io/gdal_session.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

/// Beyond this a size is a damaged header rather than a camera.
constexpr std::int64_t kMaxPixels = std::int64_t{1} << 29;

Error bad(const std::string& name, const std::string& what) {
  return {ErrorCode::InvalidInput, name + ": " + what};
}

bool is_jpeg(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

struct TurboJpeg {
  TurboJpeg() : handle(tjInitDecompress()) {}
  ~TurboJpeg() {
    if (handle) tjDestroy(handle);
  }
  TurboJpeg(const TurboJpeg&) = delete;
  TurboJpeg& operator=(const TurboJpeg&) = delete;
  tjhandle handle;
};

/// The message of libjpeg-turbo's last call without its function's name, on one line.
std::string turbo_message(tjhandle handle) {
  std::string text = tjGetErrorStr2(handle);
  if (const auto colon = text.find("(): "); colon != std::string::npos)
    text = text.substr(colon + 4);
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

Result<cv::Mat> decode_jpeg(std::span<const std::uint8_t> bytes, const ImageRequest& request,
                            const std::string& name) {
  const TurboJpeg turbo;
  if (!turbo.handle) return Error{ErrorCode::Io, name + ": libjpeg-turbo cannot be started"};
  const auto size = static_cast<unsigned long>(bytes.size());
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  if (tjDecompressHeader3(turbo.handle, bytes.data(), size, &width, &height, &subsampling,
                          &colorspace) != 0)
    return bad(name, "is not a readable JPEG (" + turbo_message(turbo.handle) + ")");
  if (static_cast<std::int64_t>(width) * height > kMaxPixels)
    return bad(name, "claims " + std::to_string(width) + "x" + std::to_string(height) + " pixels");

  const int reduction = request.reduction;
  const tjscalingfactor scale{1, reduction};
  const int cols = TJSCALED(width, scale);
  const int rows = TJSCALED(height, scale);
  const bool color = request.color && subsampling != TJSAMP_GRAY;
  cv::Mat image(rows, cols, color ? CV_8UC3 : CV_8UC1);
  // From a quarter on, chroma comes out of its own reduced blocks at the size that is wanted, and
  // the plain way of upsampling loses nothing while it decodes a sixth faster.
  const int flags = reduction >= 4 ? TJFLAG_FASTUPSAMPLE | TJFLAG_FASTDCT : 0;
  if (tjDecompress2(turbo.handle, bytes.data(), size, image.data, cols,
                    static_cast<int>(image.step), rows, color ? TJPF_BGR : TJPF_GRAY, flags) != 0) {
    const std::string why = turbo_message(turbo.handle);
    // Cameras pad their files with bytes that mean nothing; every other warning means pixels
    // that were made up.
    const bool harmless = tjGetErrorCode(turbo.handle) == TJERR_WARNING &&
                          why.find("extraneous bytes before marker") != std::string::npos;
    if (!harmless) return bad(name, "is damaged or cut short (" + why + ")");
  }
  return image;
}

Result<cv::Mat> decode_other(std::span<const std::uint8_t> bytes, const ImageRequest& request,
                             const std::string& name) {
  cv::Mat image;
  try {
    const cv::Mat buffer(
        1, static_cast<int>(bytes.size()), CV_8UC1,
        const_cast<std::uint8_t*>(bytes.data()));  // NOLINT: cv::Mat has no const view
    image = cv::imdecode(buffer, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& e) {
    std::string why = e.err;
    for (char& c : why)
      if (c == '\n' || c == '\r') c = ' ';
    return bad(name, "cannot be decoded (" + why + ")");
  }
  if (image.empty()) return bad(name, "cannot be decoded; is it a whole JPEG, PNG or TIFF?");
  if (image.depth() != CV_8U && image.depth() != CV_16U)
    return Error{ErrorCode::Unsupported,
                 name + ": has pixels that are neither 8 nor 16 bit; convert it"};
  if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  if (image.channels() == 2) cv::extractChannel(image, image, 0);
  if (image.channels() != 1 && image.channels() != 3)
    return Error{ErrorCode::Unsupported, name + ": has " + std::to_string(image.channels()) +
                                             " bands; convert it to one or three"};
  if (!request.color && image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  return image;
}

}  // namespace

bool is_image_file(const fs::path& file) {
  const std::string e = lower_extension(file);
  return e == ".jpg" || e == ".jpeg" || e == ".png" || e == ".tif" || e == ".tiff";
}

Result<std::vector<fs::path>> list_images(const fs::path& folder) {
  return files_with_extension(folder, {".jpg", ".jpeg", ".png", ".tif", ".tiff"});
}

Result<ImageSize> probe_image_size(const fs::path& file) {
  std::array<std::uint8_t, 24> head{};
  {
    std::ifstream in(file, std::ios::binary);
    if (!in)
      return Error{ErrorCode::NotFound, file.string() + ": cannot be opened; is the path right?"};
    in.read(reinterpret_cast<char*>(head.data()), head.size());
    if (in.gcount() < 8) return bad(file.string(), "is too short for an image");
  }
  if (is_jpeg(head)) {
    WATERSKY_TRY(const PhotoMetadata metadata, read_photo_metadata(file));
    return ImageSize{metadata.width_px, metadata.height_px};
  }
  const auto be32 = [&](std::size_t at) {
    return static_cast<int>(static_cast<std::uint32_t>(head[at]) << 24 | head[at + 1] << 16 |
                            head[at + 2] << 8 | head[at + 3]);
  };
  ImageSize size;
  if (head[0] == 0x89 && head[1] == 'P' && head[2] == 'N' && head[3] == 'G') {
    size = {be32(16), be32(20)};
  } else {
    const GdalSession quiet;
    GDALAllRegister();
    GDALDatasetH dataset =
        GDALOpenEx(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr);
    if (!dataset) return bad(file.string(), "is not an image that can be read");
    size = {GDALGetRasterXSize(dataset), GDALGetRasterYSize(dataset)};
    GDALClose(dataset);
  }
  if (size.width_px <= 0 || size.height_px <= 0 ||
      static_cast<std::int64_t>(size.width_px) * size.height_px > kMaxPixels)
    return bad(file.string(), "has a size that no camera has");
  return size;
}

Result<cv::Mat> decode_image(std::span<const std::uint8_t> bytes, const ImageRequest& request,
                             const std::string& name) {
  const int r = request.reduction;
  if (r != 1 && r != 2 && r != 4 && r != 8)
    return Error{ErrorCode::Usage,
                 "an image can be reduced by 1, 2, 4 or 8, not " + std::to_string(r)};
  if (bytes.empty()) return bad(name, "is empty");
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    return bad(name, "is larger than 2 GB");
  return is_jpeg(bytes) ? decode_jpeg(bytes, request, name) : decode_other(bytes, request, name);
}

namespace {

/// Whether counts cover the very picture they came with: a lens model fits one size.
bool has_size_of(const cv::Mat& counts, std::span<const std::uint8_t> jpeg) {
  const auto metadata = parse_photo_metadata(jpeg);
  return metadata && metadata->width_px == counts.cols && metadata->height_px == counts.rows;
}

}  // namespace

Result<cv::Mat> load_image(std::span<const std::uint8_t> bytes, const ImageRequest& request,
                           const std::string& name) {
  WATERSKY_TRY(auto flir, find_flir_image(bytes, name));
  if (flir && has_size_of(flir->counts, bytes)) return std::move(flir->counts);
  return decode_image(bytes, request, name);
}

Status check_image_size(const cv::Mat& image, const ImageRequest& request,
                        const ImageSize& expected, const std::string& name) {
  const auto fits = [&](int got, int full) {
    return got == full || std::abs(got * request.reduction - full) < request.reduction;
  };
  if (fits(image.cols, expected.width_px) && fits(image.rows, expected.height_px)) return {};
  return bad(name, "is " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
                       ", but the flight's camera has " + std::to_string(expected.width_px) + "x" +
                       std::to_string(expected.height_px) + " pixels");
}

ImageLoader image_loader(const fs::path& file, std::optional<ImageSize> expected) {
  return [file, expected](const ImageRequest& request) -> Result<cv::Mat> {
    WATERSKY_TRY(const auto bytes, read_bytes(file));
    WATERSKY_TRY(cv::Mat image, load_image(bytes, request, file.string()));
    if (expected) WATERSKY_CHECK(check_image_size(image, request, *expected, file.string()));
    return image;
  };
}

}  // namespace watersky
