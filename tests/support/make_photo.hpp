// SPDX-License-Identifier: MIT
#pragma once
/// Photographs for tests, written byte by byte as the EXIF and XMP standards say, independently of
/// the code that reads them.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <vector>

#include "support/real_data.hpp"
#include "support/temporary_folder.hpp"

namespace watersky::test {

using Bytes = std::vector<std::uint8_t>;

struct Photo {
  int width_px = 64;
  int height_px = 48;
  int channels = 3;
  std::string make = "DJI", model = "FC300S";
  std::string taken, subsec, offset;  ///< "2016:06:23 16:31:59", "48", "+02:00"
  double focal_mm = 0;
  int focal_35mm_mm = 0;
  std::optional<double> latitude_deg, longitude_deg, altitude_m;
  std::string gps_date;                    ///< "2016:06:23", with gps_second
  double gps_second = 0;                   ///< of the day
  std::map<std::string, std::string> dji;  ///< drone-dji properties
  bool dji_as_elements = false;
  bool big_endian = false;
};

namespace make_photo_detail {

struct Entry {
  std::uint16_t tag, type;
  std::uint32_t count;
  Bytes value;
};

class TiffWriter {
 public:
  explicit TiffWriter(bool big_endian) : big_(big_endian) {}
  [[nodiscard]] Bytes u16(std::uint32_t x) const { return number(x, 2); }
  [[nodiscard]] Bytes u32(std::uint32_t x) const { return number(x, 4); }

  [[nodiscard]] static Entry ascii(std::uint16_t tag, const std::string& s) {
    Bytes b(s.begin(), s.end());
    b.push_back(0);
    return {tag, 2, static_cast<std::uint32_t>(b.size()), b};
  }
  [[nodiscard]] Entry short_entry(std::uint16_t tag, std::uint32_t x) const {
    return {tag, 3, 1, u16(x)};
  }
  [[nodiscard]] Entry long_entry(std::uint16_t tag, std::uint32_t x) const {
    return {tag, 4, 1, u32(x)};
  }
  [[nodiscard]] Entry rationals(std::uint16_t tag,
                                const std::vector<std::pair<double, std::uint32_t>>& xs) const {
    Entry e{tag, 5, static_cast<std::uint32_t>(xs.size()), {}};
    for (const auto& [x, denominator] : xs) {
      append(e.value, u32(static_cast<std::uint32_t>(x * denominator + 0.5)));
      append(e.value, u32(denominator));
    }
    return e;
  }
  /// An IFD that begins at `offset`, its long values right behind it.
  [[nodiscard]] Bytes ifd(const std::vector<Entry>& entries, std::uint32_t offset) const {
    Bytes head = u16(static_cast<std::uint32_t>(entries.size())), tail;
    const auto values_at = static_cast<std::uint32_t>(offset + 2 + 12 * entries.size() + 4);
    for (const Entry& e : entries) {
      append(head, u16(e.tag));
      append(head, u16(e.type));
      append(head, u32(e.count));
      if (e.value.size() <= 4) {
        Bytes inline_value = e.value;
        inline_value.resize(4);
        append(head, inline_value);
      } else {
        append(head, u32(values_at + static_cast<std::uint32_t>(tail.size())));
        append(tail, e.value);
        if (tail.size() % 2) tail.push_back(0);
      }
    }
    append(head, u32(0));
    append(head, tail);
    return head;
  }
  static void append(Bytes& to, const Bytes& from) {
    to.insert(to.end(), from.begin(), from.end());
  }

 private:
  [[nodiscard]] Bytes number(std::uint32_t x, int size) const {
    Bytes b;
    for (int i = 0; i < size; ++i)
      b.push_back(static_cast<std::uint8_t>(x >> (8 * (big_ ? size - 1 - i : i))));
    return b;
  }
  bool big_;
};

inline Bytes exif_segment(const Photo& p) {
  const TiffWriter w(p.big_endian);
  std::vector<Entry> zeroth, exif, gps;
  if (!p.make.empty()) zeroth.push_back(TiffWriter::ascii(0x010F, p.make));
  if (!p.model.empty()) zeroth.push_back(TiffWriter::ascii(0x0110, p.model));
  if (!p.taken.empty()) exif.push_back(TiffWriter::ascii(0x9003, p.taken));
  if (!p.offset.empty()) exif.push_back(TiffWriter::ascii(0x9011, p.offset));
  if (!p.subsec.empty()) exif.push_back(TiffWriter::ascii(0x9291, p.subsec));
  if (p.focal_mm > 0) exif.push_back(w.rationals(0x920A, {{p.focal_mm, 100}}));
  if (p.focal_35mm_mm > 0)
    exif.push_back(w.short_entry(0xA405, static_cast<std::uint32_t>(p.focal_35mm_mm)));
  const auto dms = [&](std::uint16_t tag, double deg, char positive, char negative) {
    gps.push_back(TiffWriter::ascii(tag, std::string(1, deg < 0 ? negative : positive)));
    const double a = deg < 0 ? -deg : deg;
    const double d = static_cast<int>(a), m = static_cast<int>((a - d) * 60);
    gps.push_back(w.rationals(static_cast<std::uint16_t>(tag + 1),
                              {{d, 1}, {m, 1}, {((a - d) * 60 - m) * 60, 1000000}}));
  };
  if (p.latitude_deg) dms(1, *p.latitude_deg, 'N', 'S');
  if (p.longitude_deg) dms(3, *p.longitude_deg, 'E', 'W');
  if (p.altitude_m) {
    gps.push_back({5, 1, 1, {static_cast<std::uint8_t>(*p.altitude_m < 0)}});
    gps.push_back(w.rationals(6, {{*p.altitude_m < 0 ? -*p.altitude_m : *p.altitude_m, 1000}}));
  }
  if (!p.gps_date.empty()) {
    const int h = static_cast<int>(p.gps_second / 3600),
              m = static_cast<int>(p.gps_second / 60) % 60;
    gps.push_back(w.rationals(7, {{h, 1}, {m, 1}, {p.gps_second - h * 3600 - m * 60, 1000}}));
    gps.push_back(TiffWriter::ascii(29, p.gps_date));
  }

  Bytes tiff = p.big_endian ? Bytes{'M', 'M', 0, 42} : Bytes{'I', 'I', 42, 0};
  TiffWriter::append(tiff, w.u32(8));
  // The two pointers are one entry each: sizes are known once they are in.
  std::vector<Entry> with_pointers = zeroth;
  with_pointers.push_back(w.long_entry(0x8769, 0));
  with_pointers.push_back(w.long_entry(0x8825, 0));
  const auto exif_at = static_cast<std::uint32_t>(8 + w.ifd(with_pointers, 8).size());
  const Bytes exif_bytes = w.ifd(exif, exif_at);
  const auto gps_at = static_cast<std::uint32_t>(exif_at + exif_bytes.size());
  with_pointers[with_pointers.size() - 2] = w.long_entry(0x8769, exif_at);
  with_pointers.back() = w.long_entry(0x8825, gps_at);
  TiffWriter::append(tiff, w.ifd(with_pointers, 8));
  TiffWriter::append(tiff, exif_bytes);
  TiffWriter::append(tiff, w.ifd(gps, gps_at));
  Bytes out = {'E', 'x', 'i', 'f', 0, 0};
  TiffWriter::append(out, tiff);
  return out;
}

inline Bytes xmp_segment(const Photo& p) {
  std::string attributes, elements;
  for (const auto& [key, value] : p.dji) {
    if (p.dji_as_elements)
      elements += "<drone-dji:" + key + ">" + value + "</drone-dji:" + key + ">\n";
    else
      attributes += " drone-dji:" + key + "=\"" + value + "\"\n";
  }
  const std::string xml =
      "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
      "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">"
      "<rdf:Description rdf:about=\"DJI Meta Data\" "
      "xmlns:drone-dji=\"http://www.dji.com/drone-dji/1.0/\"" +
      attributes + ">" + elements + "</rdf:Description></rdf:RDF></x:xmpmeta><?xpacket end=\"w\"?>";
  Bytes out;
  for (const char c : std::string("http://ns.adobe.com/xap/1.0/"))
    out.push_back(static_cast<std::uint8_t>(c));
  out.push_back(0);
  out.insert(out.end(), xml.begin(), xml.end());
  return out;
}

}  // namespace make_photo_detail

/// A small picture with a gradient, or `pixels`.
inline Bytes make_photo(const Photo& p, const cv::Mat& pixels = {}) {
  cv::Mat image = pixels;
  if (image.empty()) {
    image.create(p.height_px, p.width_px, CV_MAKETYPE(CV_8U, p.channels));
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols * p.channels; ++u)
        image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>((u * 2 + v * 3) % 256);
  }
  Bytes jpeg;
  cv::imencode(".jpg", image, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95});
  Bytes out(jpeg.begin(), jpeg.begin() + 2);
  for (const Bytes& body :
       {make_photo_detail::exif_segment(p), make_photo_detail::xmp_segment(p)}) {
    out.insert(out.end(), {0xFF, 0xE1, static_cast<std::uint8_t>((body.size() + 2) >> 8),
                           static_cast<std::uint8_t>((body.size() + 2) & 0xFF)});
    out.insert(out.end(), body.begin(), body.end());
  }
  out.insert(out.end(), jpeg.begin() + 2, jpeg.end());
  return out;
}

inline void write(const std::filesystem::path& file, const Bytes& bytes) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}
inline void write(const std::filesystem::path& file, const std::string& text) {
  write(file, Bytes(text.begin(), text.end()));
}

}  // namespace watersky::test
