// SPDX-License-Identifier: MIT
#include "watersky/products/detail/picture.hpp"

#include <cpl_string.h>
#include <gdal_priv.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/io/gdal_session.hpp"

namespace watersky::detail {

namespace {

std::string data_uri(const char* type, const void* bytes, std::size_t size) {
  char* base64 = CPLBase64Encode(static_cast<int>(size), static_cast<const GByte*>(bytes));
  std::string uri = std::string("data:") + type + ";base64," + base64;
  CPLFree(base64);
  return uri;
}

// OpenCV cannot write a PNG with a palette, which is a quarter of the size and of the time.
Result<std::string> png(const cv::Mat& index, const GDALColorTable* colors) {
  GdalSession gdal;
  const DatasetPtr source(GetGDALDriverManager()->GetDriverByName("MEM")->Create(
      "", index.cols, index.rows, 1, GDT_Byte, nullptr));
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("PNG");
  if (!source || !driver) return gdal.error("report picture");
  GDALRasterBand* band = source->GetRasterBand(1);
  cv::Mat cells = index;
  if (band->RasterIO(GF_Write, 0, 0, cells.cols, cells.rows, cells.data, cells.cols, cells.rows,
                     GDT_Byte, 1, static_cast<GSpacing>(cells.step[0]), nullptr) != CE_None)
    return gdal.error("report picture");
  if (colors) band->SetColorTable(const_cast<GDALColorTable*>(colors));  // GDAL copies it
  CPLStringList options;
  options.SetNameValue("ZLEVEL", "1");
  const MemoryFile file(".png");
  DatasetPtr copy(driver->CreateCopy(file.name().c_str(), source.get(), FALSE, options.List(),
                                     nullptr, nullptr));
  copy.reset();
  if (gdal.failed() || file.bytes().empty()) return gdal.error("report picture");
  return data_uri("image/png", file.bytes().data(), file.bytes().size());
}

}  // namespace

Result<std::string> png_data_uri(const cv::Mat& index, Ramp ramp) {
  GDALColorTable colors;
  const GDALColorEntry transparent{0, 0, 0, 0};
  colors.SetColorEntry(0, &transparent);
  for (int i = 1; i < 256; ++i) {
    const Rgb c = color_at(ramp, (i - 1) / 254.0);
    const GDALColorEntry entry{c.red, c.green, c.blue, 255};
    colors.SetColorEntry(i, &entry);
  }
  return png(index, &colors);
}

Result<std::string> mask_data_uri(const cv::Mat& mask) { return png(mask, nullptr); }

std::string jpeg_data_uri(const std::string& jpeg) {
  return data_uri("image/jpeg", jpeg.data(), jpeg.size());
}

Result<std::string> jpeg_data_uri(const cv::Mat& bgra) {
  cv::Mat bgr;
  cv::cvtColor(bgra, bgr, cv::COLOR_BGRA2BGR);
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, 82}))
    return Error{ErrorCode::Io, "report picture: OpenCV could not encode a JPEG"};
  return data_uri("image/jpeg", bytes.data(), bytes.size());
}

}  // namespace watersky::detail
