// SPDX-License-Identifier: MIT
#include "watersky/io/exif.hpp"

#include <cpl_conv.h>
#include <cpl_minixml.h>
#include <libexif/exif-data.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>

#include "watersky/io/csv.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/gdal_session.hpp"
#include "watersky/io/image_file.hpp"

namespace watersky {

namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::string_view kExifHead{"Exif\0\0", 6};
constexpr std::string_view kXmpHead{"http://ns.adobe.com/xap/1.0/\0", 29};
constexpr int kTagOffsetTimeOriginal = 0x9011;

bool begins_with(Bytes bytes, std::string_view head) {
  return bytes.size() >= head.size() &&
         std::equal(head.begin(), head.end(), bytes.begin(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

/// The whole number that begins `text`, of exactly `digits` digits.
std::optional<int> digits_at(std::string_view text, std::size_t at, std::size_t digits) {
  if (at + digits > text.size()) return std::nullopt;
  int x = 0;
  for (std::size_t i = at; i < at + digits; ++i) {
    if (text[i] < '0' || text[i] > '9') return std::nullopt;
    x = x * 10 + (text[i] - '0');
  }
  return x;
}

/// libexif's view of an APP1 segment.
class Exif {
 public:
  explicit Exif(Bytes segment)
      : data_(exif_data_new_from_data(segment.data(), static_cast<unsigned>(segment.size()))) {}

  [[nodiscard]] std::optional<std::string> text(ExifIfd ifd, int tag) const {
    const ExifEntry* e = entry(ifd, tag);
    if (!e || e->format != EXIF_FORMAT_ASCII) return std::nullopt;
    std::string s(reinterpret_cast<const char*>(e->data), e->size);
    s = s.substr(0, s.find('\0'));
    while (!s.empty() && s.back() == ' ') s.pop_back();
    if (s.empty()) return std::nullopt;
    return s;
  }

  [[nodiscard]] std::optional<double> number(ExifIfd ifd, int tag, std::size_t index = 0) const {
    const ExifEntry* e = entry(ifd, tag);
    if (!e) return std::nullopt;
    const std::size_t size = exif_format_get_size(e->format);
    if (size == 0 || index >= e->components || (index + 1) * size > e->size) return std::nullopt;
    const unsigned char* at = e->data + index * size;
    const ExifByteOrder order = exif_data_get_byte_order(data_.get());
    double x = 0;
    switch (e->format) {
      case EXIF_FORMAT_BYTE: x = at[0]; break;
      case EXIF_FORMAT_SHORT: x = exif_get_short(at, order); break;
      case EXIF_FORMAT_LONG: x = exif_get_long(at, order); break;
      case EXIF_FORMAT_RATIONAL: {
        const ExifRational r = exif_get_rational(at, order);
        x = static_cast<double>(r.numerator) / static_cast<double>(r.denominator);
        break;
      }
      case EXIF_FORMAT_SRATIONAL: {
        const ExifSRational r = exif_get_srational(at, order);
        x = static_cast<double>(r.numerator) / static_cast<double>(r.denominator);
        break;
      }
      default: return std::nullopt;
    }
    if (!std::isfinite(x)) return std::nullopt;
    return x;
  }

 private:
  struct Unref {
    void operator()(ExifData* d) const { exif_data_unref(d); }
  };
  [[nodiscard]] const ExifEntry* entry(ExifIfd ifd, int tag) const {
    if (!data_) return nullptr;
    const ExifEntry* e = exif_content_get_entry(data_->ifd[ifd], static_cast<ExifTag>(tag));
    return e && e->data ? e : nullptr;
  }
  std::unique_ptr<ExifData, Unref> data_;
};

std::optional<double> positive(std::optional<double> x) { return x && *x > 0 ? x : std::nullopt; }

/// Degrees, minutes, seconds and a letter.
std::optional<Angle> gps_angle(const Exif& exif, int value_tag, int reference_tag, char negative,
                               double limit_deg) {
  const auto d = exif.number(EXIF_IFD_GPS, value_tag, 0);
  const auto m = exif.number(EXIF_IFD_GPS, value_tag, 1);
  const auto s = exif.number(EXIF_IFD_GPS, value_tag, 2);
  const auto reference = exif.text(EXIF_IFD_GPS, reference_tag);
  if (!d || !reference) return std::nullopt;
  const double deg = *d + m.value_or(0) / 60 + s.value_or(0) / 3600;
  if (!(deg >= 0 && deg <= limit_deg)) return std::nullopt;
  return Angle::degrees(reference->front() == negative ? -deg : deg);
}

std::optional<Time> gps_time(const Exif& exif) {
  const auto date = exif.text(EXIF_IFD_GPS, EXIF_TAG_GPS_DATE_STAMP);
  const auto h = exif.number(EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP, 0);
  const auto m = exif.number(EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP, 1);
  const auto s = exif.number(EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP, 2);
  if (!date || !h || !m || !s) return std::nullopt;
  const auto day = parse_exif_time(*date + " 00:00:00");
  const double second_of_day = *h * 3600 + *m * 60 + *s;
  if (!day || !(second_of_day >= 0 && second_of_day < 86401)) return std::nullopt;
  // Rationals of a microsecond and coarser: rounded there, a double carries them exactly.
  return *day + std::chrono::microseconds(std::llround(second_of_day * 1e6));
}

void read_exif(Bytes segment, PhotoMetadata& out) {
  const Exif exif(segment);
  out.make = exif.text(EXIF_IFD_0, EXIF_TAG_MAKE).value_or("");
  out.model = exif.text(EXIF_IFD_0, EXIF_TAG_MODEL).value_or("");
  out.focal_length_mm = positive(exif.number(EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH));
  out.focal_length_35mm_mm =
      positive(exif.number(EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM));
  if (const auto x = positive(exif.number(EXIF_IFD_EXIF, EXIF_TAG_FOCAL_PLANE_X_RESOLUTION))) {
    const double unit =
        exif.number(EXIF_IFD_EXIF, EXIF_TAG_FOCAL_PLANE_RESOLUTION_UNIT).value_or(2);
    const double mm = unit == 2 ? 25.4 : unit == 3 ? 10.0 : unit == 4 ? 1.0 : 0.0;
    if (mm > 0) out.focal_plane_px_per_mm = *x / mm;
  }

  out.latitude = gps_angle(exif, EXIF_TAG_GPS_LATITUDE, EXIF_TAG_GPS_LATITUDE_REF, 'S', 90);
  out.longitude = gps_angle(exif, EXIF_TAG_GPS_LONGITUDE, EXIF_TAG_GPS_LONGITUDE_REF, 'W', 180);
  if (!out.latitude || !out.longitude) out.latitude = out.longitude = std::nullopt;
  // Receivers without a fix write 0 N 0 E.
  if (out.latitude && out.latitude->radians() == 0 && out.longitude->radians() == 0)
    out.latitude = out.longitude = std::nullopt;
  if (auto altitude = exif.number(EXIF_IFD_GPS, EXIF_TAG_GPS_ALTITUDE)) {
    if (exif.number(EXIF_IFD_GPS, EXIF_TAG_GPS_ALTITUDE_REF).value_or(0) == 1)
      altitude = -*altitude;
    out.gps_altitude_m = altitude;
  }
  if (const auto direction = exif.number(EXIF_IFD_GPS, EXIF_TAG_GPS_IMG_DIRECTION);
      direction &&
      exif.text(EXIF_IFD_GPS, EXIF_TAG_GPS_IMG_DIRECTION_REF).value_or("T").front() == 'T')
    out.image_direction = Angle::degrees(*direction);
  out.gps_time = gps_time(exif);

  if (const auto taken = exif.text(EXIF_IFD_EXIF, EXIF_TAG_DATE_TIME_ORIGINAL))
    out.taken_local = parse_exif_time(
        *taken, exif.text(EXIF_IFD_EXIF, EXIF_TAG_SUB_SEC_TIME_ORIGINAL).value_or(""));
  if (const auto offset = exif.text(EXIF_IFD_EXIF, kTagOffsetTimeOriginal))
    out.utc_offset = parse_utc_offset(*offset);
}

using Properties = std::map<std::string, std::string, std::less<>>;

/// Every drone-dji property, written as an attribute or as an element.
void collect(const CPLXMLNode* node, Properties& out, int depth) {
  constexpr int kDeepest = 64;
  constexpr std::string_view kPrefix = "drone-dji:";
  for (; node && depth < kDeepest; node = node->psNext) {
    const std::string_view name = node->pszValue ? node->pszValue : "";
    const CPLXMLNode* child = node->psChild;
    if ((node->eType == CXT_Attribute || node->eType == CXT_Element) && name.starts_with(kPrefix) &&
        child && child->eType == CXT_Text && child->pszValue)
      out.try_emplace(std::string(name.substr(kPrefix.size())), child->pszValue);
    if (node->eType == CXT_Element) collect(child, out, depth + 1);
  }
}

void read_xmp(Bytes segment, PhotoMetadata& out) {
  const std::string text(reinterpret_cast<const char*>(segment.data()), segment.size());
  const GdalSession quiet;
  const std::unique_ptr<CPLXMLNode, decltype(&CPLDestroyXMLNode)> tree(
      CPLParseXMLString(text.c_str()), &CPLDestroyXMLNode);
  Properties properties;
  collect(tree.get(), properties, 0);

  const auto number = [&](std::string_view key) -> std::optional<double> {
    const auto it = properties.find(key);
    return it == properties.end() ? std::nullopt : parse_number(it->second);
  };
  const auto angles = [&](const std::string& who) -> std::optional<YawPitchRoll> {
    const auto yaw = number(who + "YawDegree");
    const auto pitch = number(who + "PitchDegree");
    const auto roll = number(who + "RollDegree");
    const auto turns = [](double x) { return std::abs(x) <= 720; };
    if (!yaw || !pitch || !roll || !turns(*yaw) || !turns(*pitch) || !turns(*roll))
      return std::nullopt;
    return YawPitchRoll{Angle::degrees(*yaw), Angle::degrees(*pitch), Angle::degrees(*roll)};
  };
  out.gimbal = angles("Gimbal");
  out.flight = angles("Flight");
  out.relative_altitude_m = number("RelativeAltitude");
  out.absolute_altitude_m = number("AbsoluteAltitude");
  out.calibrated_focal_px = positive(number("CalibratedFocalLength"));
  out.rtk_sigma_north_m = positive(number("RtkStdLat"));
  out.rtk_sigma_east_m = positive(number("RtkStdLon"));
  out.rtk_sigma_height_m = positive(number("RtkStdHgt"));
  // RtkFlag 50 is a fixed solution, 34 a float one; newer cameras name the kind of altitude.
  const auto type = properties.find("AltitudeType");
  out.altitude_is_ellipsoidal = type != properties.end()
                                    ? type->second == "RtkAlt"
                                    : number("RtkFlag") == 50.0 || number("RtkFlag") == 34.0;
  out.dewarped = number("DewarpFlag") == 1.0;
  if (const auto it = properties.find("DewarpData"); it != properties.end()) {
    std::string_view rest = it->second;
    if (const auto semicolon = rest.find(';'); semicolon != std::string_view::npos)
      rest.remove_prefix(semicolon + 1);
    while (!rest.empty() && out.dewarp.size() < 10) {
      const auto comma = std::min(rest.find(','), rest.size());
      const auto x = parse_number(rest.substr(0, comma));
      if (!x) break;
      out.dewarp.push_back(*x);
      rest.remove_prefix(std::min(comma + 1, rest.size()));
    }
    if (out.dewarp.size() != 9) out.dewarp.clear();
  }
}

}  // namespace

std::optional<Time> PhotoMetadata::utc() const {
  if (taken_local && utc_offset) return *taken_local - *utc_offset;
  return gps_time;
}

std::string PhotoMetadata::camera_name() const {
  if (model.empty()) return make;
  const bool said = make.empty() || lower(model).starts_with(lower(make));
  return said ? model : make + " " + model;
}

std::optional<Time> parse_exif_time(std::string_view text, std::string_view fraction) {
  using namespace std::chrono;
  const auto y = digits_at(text, 0, 4), mo = digits_at(text, 5, 2), d = digits_at(text, 8, 2);
  const auto h = digits_at(text, 11, 2), mi = digits_at(text, 14, 2), s = digits_at(text, 17, 2);
  if (!y || !mo || !d || !h || !mi || !s || *y < 1900 || *y > 2200) return std::nullopt;
  const year_month_day date{year(*y), month(static_cast<unsigned>(*mo)),
                            day(static_cast<unsigned>(*d))};
  if (!date.ok() || *h > 23 || *mi > 59 || *s > 60) return std::nullopt;
  Duration part{0};
  std::int64_t unit = 100'000'000;
  for (const char c : fraction) {
    if (c < '0' || c > '9') break;
    part += Duration(unit * (c - '0'));
    unit /= 10;
  }
  return Time(sys_days(date)) + hours(*h) + minutes(*mi) + std::chrono::seconds(*s) + part;
}

std::optional<Duration> parse_utc_offset(std::string_view text) {
  if (text == "Z" || text == "z") return Duration{0};
  if (text.empty() || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const auto h = digits_at(text, 1, 2);
  const auto m = digits_at(text, text.size() > 3 && text[3] == ':' ? 4 : 3, 2);
  if (!h || !m || *h > 14 || *m > 59) return std::nullopt;
  const Duration offset = std::chrono::hours(*h) + std::chrono::minutes(*m);
  return text[0] == '-' ? -offset : offset;
}

Result<PhotoMetadata> parse_photo_metadata(Bytes bytes) {
  const Error more{ErrorCode::OutOfRange, "ends within its header"};
  if (bytes.size() < 4) return more;
  if (bytes[0] != 0xFF || bytes[1] != 0xD8) return Error{ErrorCode::InvalidInput, "is not a JPEG"};
  PhotoMetadata out;
  bool exif_seen = false, xmp_seen = false;
  std::size_t at = 2;
  while (true) {
    if (at + 4 > bytes.size()) return more;
    if (bytes[at] != 0xFF) return Error{ErrorCode::InvalidInput, "has a damaged JPEG header"};
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD7)) {
      at += 2;
      continue;
    }
    if (marker == 0xD9 || marker == 0xDA || marker == 0x00)
      return Error{ErrorCode::InvalidInput, "is a JPEG without an image size"};
    const std::size_t length = static_cast<std::size_t>(bytes[at + 2]) << 8 | bytes[at + 3];
    if (length < 2) return Error{ErrorCode::InvalidInput, "has a damaged JPEG header"};
    if (at + 2 + length > bytes.size()) return more;
    const Bytes body = bytes.subspan(at + 4, length - 2);
    if (marker == 0xE1 && !exif_seen && begins_with(body, kExifHead)) {
      exif_seen = true;
      read_exif(body, out);
    } else if (marker == 0xE1 && !xmp_seen && begins_with(body, kXmpHead)) {
      xmp_seen = true;
      read_xmp(body.subspan(kXmpHead.size()), out);
    } else if (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 &&
               marker != 0xCC) {
      if (body.size() < 6) return Error{ErrorCode::InvalidInput, "has a damaged JPEG header"};
      out.height_px = body[1] << 8 | body[2];
      out.width_px = body[3] << 8 | body[4];
      if (out.width_px == 0 || out.height_px == 0)
        return Error{ErrorCode::InvalidInput, "is a JPEG without an image size"};
      return out;
    }
    at += 2 + length;
  }
}

Result<PhotoMetadata> read_photo_metadata(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    return Error{ErrorCode::NotFound, file.string() + ": cannot be opened; is the path right?"};
  // Metadata and previews of DJI's cameras end within 200 kB; others put more there.
  constexpr std::size_t kFirst = std::size_t{1} << 18, kMost = std::size_t{1} << 25;
  std::vector<std::uint8_t> head;
  for (std::size_t wanted = kFirst; wanted <= kMost; wanted *= 4) {
    const std::size_t have = head.size();
    head.resize(wanted);
    in.read(reinterpret_cast<char*>(head.data() + have),
            static_cast<std::streamsize>(wanted - have));
    head.resize(have + static_cast<std::size_t>(in.gcount()));
    if (head.size() >= 2 && (head[0] != 0xFF || head[1] != 0xD8)) {
      WATERSKY_TRY(const ImageSize size, probe_image_size(file));
      PhotoMetadata out;
      out.width_px = size.width_px;
      out.height_px = size.height_px;
      return out;
    }
    auto parsed = parse_photo_metadata(head);
    if (parsed) return parsed;
    if (parsed.error().code != ErrorCode::OutOfRange || head.size() < wanted)
      return Error{ErrorCode::InvalidInput, file.string() + ": " + parsed.error().message};
  }
  return Error{ErrorCode::InvalidInput, file.string() + ": has a JPEG header without end"};
}

}  // namespace watersky
