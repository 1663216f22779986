// SPDX-License-Identifier: MIT
#include "watersky/io/flir.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <vector>

namespace watersky {
namespace {

using Bytes = std::span<const std::uint8_t>;

// The FFF file (ExifTool's FLIR tags): a header of 0x40 bytes, then a directory of records of
// 0x20 bytes each. Byte order is that in which the version reads 100 to 199.
constexpr std::size_t kHeaderSize = 0x40, kVersionAt = 0x14, kDirectoryAt = 0x18, kEntriesAt = 0x1c;
constexpr std::size_t kEntrySize = 0x20, kRecordOffsetAt = 0x0c, kRecordSizeAt = 0x10;
constexpr unsigned kRawData = 0x01, kCameraInfo = 0x20;
/// A record's first word is 2 in its own byte order; then the size.
constexpr std::size_t kWidthAt = 2, kHeightAt = 4, kPixelsAt = 0x20;
constexpr std::size_t kPlanckR1At = 0x58, kPlanckBAt = 0x5c, kPlanckFAt = 0x60, kModelAt = 0xd4,
                      kModelSize = 32, kPlanckOAt = 0x308, kPlanckR2At = 0x30c;
constexpr std::size_t kMostEntries = 1024;
constexpr unsigned kMostSide_px = 16384;

struct Reader {
  Bytes bytes;
  bool big = false;

  [[nodiscard]] bool has(std::size_t at, std::size_t size) const {
    return at <= bytes.size() && size <= bytes.size() - at;
  }
  [[nodiscard]] unsigned u16(std::size_t at) const {
    const unsigned a = bytes[at], b = bytes[at + 1];
    return big ? a << 8 | b : b << 8 | a;
  }
  [[nodiscard]] std::uint32_t u32(std::size_t at) const {
    const std::uint32_t a = u16(at), b = u16(at + 2);
    return big ? a << 16 | b : b << 16 | a;
  }
  [[nodiscard]] double f32(std::size_t at) const {
    return static_cast<double>(std::bit_cast<float>(u32(at)));
  }
  /// Of a record whose first word is 2.
  [[nodiscard]] static Reader record(Bytes bytes) {
    Reader reader{bytes, false};
    reader.big = bytes.size() >= 2 && reader.u16(0) != 2;
    return reader;
  }
};

Error bad(const std::string& name, const std::string& what) {
  return {ErrorCode::InvalidInput, name + ": its FLIR thermal data " + what};
}

bool begins(Bytes bytes, std::string_view head) {
  return bytes.size() >= head.size() && std::memcmp(bytes.data(), head.data(), head.size()) == 0;
}

/// The FLIR chunks of a JPEG in their order, joined; empty when there are none.
Result<std::vector<std::uint8_t>> join_chunks(Bytes jpeg, const std::string& name) {
  std::vector<Bytes> chunks;
  std::size_t seen = 0, at = 2;
  while (at + 4 <= jpeg.size() && jpeg[at] == 0xFF) {
    const unsigned marker = jpeg[at + 1];
    if (marker == 0xFF) {
      ++at;
      continue;
    }
    if (marker == 0xD9 || marker == 0xDA || marker == 0x00) break;
    const std::size_t size = std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3];
    if (size < 2 || at + 2 + size > jpeg.size()) break;
    const Bytes body = jpeg.subspan(at + 4, size - 2);
    // "FLIR\0", a version, the chunk's number, the last chunk's number.
    if (marker == 0xE1 && body.size() > 8 && begins(body, {"FLIR\0", 5})) {
      const std::size_t number = body[6], last = body[7];
      if (chunks.empty()) chunks.resize(last + 1);
      if (last + 1 != chunks.size() || number > last || !chunks[number].empty())
        return bad(name, "is not numbered as its own count says");
      chunks[number] = body.subspan(8);
      ++seen;
    }
    at += 2 + size;
  }
  if (seen != chunks.size()) return bad(name, "lacks a part; was the file cut or edited?");
  std::vector<std::uint8_t> joined;
  for (const Bytes chunk : chunks) joined.insert(joined.end(), chunk.begin(), chunk.end());
  return joined;
}

Result<cv::Mat> read_counts(Bytes bytes, const std::string& name) {
  const Reader record = Reader::record(bytes);
  if (!record.has(0, kPixelsAt)) return bad(name, "ends within its raw image");
  const unsigned width = record.u16(kWidthAt), height = record.u16(kHeightAt);
  if (width == 0 || height == 0 || width > kMostSide_px || height > kMostSide_px)
    return bad(name, "claims " + std::to_string(width) + "x" + std::to_string(height) + " pixels");
  const Bytes pixels = bytes.subspan(kPixelsAt);
  const cv::Size size(static_cast<int>(width), static_cast<int>(height));
  cv::Mat counts;
  if (begins(pixels, "\x89PNG")) {
    // The header's own size first: a decoder must not be led to make more room.
    const Reader png{pixels, true};
    if (!png.has(0, 24) || png.u32(16) != width || png.u32(20) != height)
      return bad(name, "holds a PNG of another size");
    try {
      const cv::Mat buffer(1, static_cast<int>(pixels.size()), CV_8UC1,
                           const_cast<std::uint8_t*>(pixels.data()));  // NOLINT: cv::Mat
      counts = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
      counts.release();
    }
    if (counts.type() != CV_16UC1 || counts.size() != size)
      return bad(name, "holds a PNG that is damaged or not 16 bit");
    // FLIR writes them the wrong way round: the order in which neighbours differ less is right,
    // for the low byte of a count is all but random and as the high one would tear the picture.
    cv::Mat swapped(size, CV_16U);
    std::transform(counts.begin<std::uint16_t>(), counts.end<std::uint16_t>(),
                   swapped.begin<std::uint16_t>(),
                   [](std::uint16_t c) { return static_cast<std::uint16_t>(c << 8 | c >> 8); });
    const auto roughness = [](const cv::Mat& m) {
      return m.cols < 2 ? 0.0
                        : cv::norm(m.colRange(1, m.cols), m.colRange(0, m.cols - 1), cv::NORM_L1);
    };
    return roughness(swapped) < roughness(counts) ? swapped : counts;
  }
  if (pixels.size() < std::size_t{width} * height * 2)
    return bad(name, "ends within its raw image");
  counts.create(size, CV_16U);
  const Reader raw{pixels, record.big};
  std::size_t at = 0;
  for (int y = 0; y < counts.rows; ++y)
    for (int x = 0; x < counts.cols; ++x, at += 2)
      counts.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(raw.u16(at));
  return counts;
}

void read_camera(Bytes bytes, FlirImage& image) {
  const Reader record = Reader::record(bytes);
  if (record.has(kModelAt, kModelSize)) {
    const auto* text = reinterpret_cast<const char*>(bytes.data() + kModelAt);
    image.camera.assign(text, ::strnlen(text, kModelSize));
    std::erase_if(image.camera, [](char c) { return c < ' ' || c > '~'; });
  }
  if (!record.has(kPlanckR2At, 4)) return;
  const PlanckThermalScale scale{
      .r1 = record.f32(kPlanckR1At),
      .b = record.f32(kPlanckBAt),
      .f = record.f32(kPlanckFAt),
      .o = static_cast<double>(static_cast<std::int32_t>(record.u32(kPlanckOAt))),
      .r2 = record.f32(kPlanckR2At)};
  // Constants that make a temperature at all; files that lack them hold zeros.
  if (scale.r1 > 0 && scale.b > 0 && scale.r2 > 0 && std::isfinite(scale.r1) &&
      std::isfinite(scale.b) && std::isfinite(scale.f) && std::isfinite(scale.r2))
    image.scale = scale;
}

}  // namespace

Result<std::optional<FlirImage>> find_flir_image(Bytes jpeg, const std::string& name) {
  if (jpeg.size() < 4 || jpeg[0] != 0xFF || jpeg[1] != 0xD8) return std::optional<FlirImage>();
  WATERSKY_TRY(const std::vector<std::uint8_t> joined, join_chunks(jpeg, name));
  if (joined.empty()) return std::optional<FlirImage>();

  Reader fff{joined, true};
  if (!fff.has(0, kHeaderSize) || !(begins(joined, {"FFF\0", 4}) || begins(joined, {"AFF\0", 4})))
    return bad(name, "is no FFF file");
  const auto version_fits = [&] { return fff.u32(kVersionAt) / 100 == 1; };
  if (!version_fits()) fff.big = false;
  if (!version_fits()) return bad(name, "is of a version that is not known");
  const std::size_t directory = fff.u32(kDirectoryAt), entries = fff.u32(kEntriesAt);
  if (entries > kMostEntries || !fff.has(directory, entries * kEntrySize))
    return bad(name, "ends within its directory");

  FlirImage image;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + i * kEntrySize;
    const unsigned type = fff.u16(entry);
    if (type != kRawData && type != kCameraInfo) continue;
    const std::size_t offset = fff.u32(entry + kRecordOffsetAt),
                      size = fff.u32(entry + kRecordSizeAt);
    if (!fff.has(offset, size)) return bad(name, "ends within a record");
    const Bytes record = fff.bytes.subspan(offset, size);
    if (type == kCameraInfo) {
      read_camera(record, image);
    } else if (image.counts.empty()) {
      WATERSKY_TRY(image.counts, read_counts(record, name));
    }
  }
  if (image.counts.empty()) return std::optional<FlirImage>();
  return std::optional<FlirImage>(std::move(image));
}

}  // namespace watersky
