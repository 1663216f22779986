// SPDX-License-Identifier: MIT
#include "watersky/io/known_points_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "watersky/geodesy/projection.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/detail/csv_checks.hpp"
#include "watersky/io/files.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

constexpr double kFarthest_m = 1e5;   ///< of a height, and a range
constexpr double kMostSigma_m = 1e4;  ///< worse than that is no knowledge
constexpr double kMost_px = 1e6;

Error bad(const std::string& message) { return {ErrorCode::InvalidInput, message}; }

/// With the folder in front, where there is one.
Error in_folder_of(const fs::path& file, const Error& error) {
  return file.has_parent_path() ? error.at(file.parent_path().string()) : error;
}

bool empty_at(const CsvTable& table, std::size_t row, const std::optional<std::size_t>& column) {
  return !column || table.cell(row, *column).find_first_not_of(" \t") == std::string::npos;
}

/// A cell within limits.
Result<double> number_in(const CsvTable& table, std::size_t row, std::size_t column, double low,
                         double high) {
  WATERSKY_TRY(const double x, table.number(row, column));
  if (x < low || x > high)
    return bad(table.place(row) + ": " + table.columns()[column] + " is " + format_number(x) +
               "; it must be from " + format_number(low) + " to " + format_number(high));
  return x;
}

Result<double> sigma_at(const CsvTable& table, std::size_t row, std::size_t column) {
  WATERSKY_TRY(const double x, number_in(table, row, column, 0, kMostSigma_m));
  if (!(x > 0))
    return bad(table.place(row) + ": " + table.columns()[column] +
               " is 0; nothing is known exactly, give one sigma or leave the cell empty");
  return x;
}

/// lat_deg, lon_deg and a height above ellipsoid or sea; nullopt when all are empty.
Result<std::optional<AnchorPlace>> place_at(const CsvTable& table, std::size_t row) {
  const auto lat = table.column("lat_deg"), lon = table.column("lon_deg"),
             ellipsoid = table.column("height_ellipsoid_m"),
             sea = table.column("height_above_sea_m");
  const bool over_ellipsoid = !empty_at(table, row, ellipsoid),
             over_sea = !empty_at(table, row, sea);
  if (over_ellipsoid && over_sea)
    return bad(table.place(row) +
               ": has both height_ellipsoid_m and height_above_sea_m; keep one of them");
  if (empty_at(table, row, lat) && empty_at(table, row, lon)) {
    if (over_ellipsoid || over_sea)
      return bad(table.place(row) + ": has a height but no lat_deg and lon_deg; add them");
    return std::optional<AnchorPlace>{};
  }
  AnchorPlace place;
  WATERSKY_TRY(const double lat_deg, number_in(table, row, *lat, -90, 90));
  WATERSKY_TRY(const double lon_deg, number_in(table, row, *lon, -360, 360));
  place.latitude = Angle::degrees(lat_deg);
  place.longitude = Angle::degrees(lon_deg);
  if (over_ellipsoid || over_sea) {
    WATERSKY_TRY(place.height_m,
                 number_in(table, row, over_sea ? *sea : *ellipsoid, -kFarthest_m, kFarthest_m));
    place.above = over_sea ? HeightAbove::Sea : HeightAbove::Ellipsoid;
  }
  return std::optional(place);
}

bool same(const AnchorPlace& a, const AnchorPlace& b) {
  return a.latitude.degrees() == b.latitude.degrees() &&
         a.longitude.degrees() == b.longitude.degrees() && a.height_m == b.height_m &&
         a.above == b.above;
}

/// The anchor of that name, made where there is none.
Anchor& named(std::vector<Anchor>& anchors, std::map<std::string, std::size_t>& index,
              const std::string& name) {
  const auto [found, is_new] = index.try_emplace(name, anchors.size());
  if (is_new) {
    anchors.emplace_back();
    anchors.back().name = name;
  }
  return anchors[found->second];
}

std::map<std::string, std::size_t> index_of(const std::vector<Anchor>& anchors) {
  std::map<std::string, std::size_t> index;
  for (std::size_t k = 0; k < anchors.size(); ++k) index.emplace(anchors[k].name, k);
  return index;
}

/// Names stand in reports and are written again: on one line.
Status check_name(const std::string& text, const std::string& place) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20)
      return bad(place + ": has a control character in a name; remove it");
  return {};
}

Result<std::string> name_at(const CsvTable& table, std::size_t row) {
  const std::size_t column = *table.column("anchor");
  if (empty_at(table, row, column))
    return bad(table.place(row) + ": names no anchor; any name will do");
  WATERSKY_CHECK(check_name(table.cell(row, column), table.place(row)));
  return table.cell(row, column);
}

/// "height_ellipsoid_m,height_above_sea_m" of a place.
std::string height_cells(const AnchorPlace& place) {
  const std::string height = format_number(place.height_m);
  if (place.above == HeightAbove::Ellipsoid) return height + ",";
  return "," + (place.height_m == 0.0 ? std::string() : height);
}

std::string place_cells(const AnchorPlace& place) {
  return format_number(place.latitude.degrees()) + "," + format_number(place.longitude.degrees()) +
         "," + height_cells(place);
}

}  // namespace

Result<std::vector<Anchor>> parse_anchors_csv(std::string_view text, const std::string& name,
                                              std::vector<std::string>& notes) {
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, name));
  WATERSKY_CHECK(table.require({"anchor", "frame", "u_px", "v_px"}));
  if (table.column("lat_deg").has_value() != table.column("lon_deg").has_value())
    return bad(name + ": has one of lat_deg and lon_deg but not both; add the other");
  detail::note_unknown(table,
                       table.unknown_columns({"anchor", "lat_deg", "lon_deg", "height_ellipsoid_m",
                                              "height_above_sea_m", "sigma_m", "sigma_height_m",
                                              "frame", "u_px", "v_px", "sigma_px"}),
                       notes);
  const auto u = table.column("u_px"), v = table.column("v_px"),
             sigma_px = table.column("sigma_px"), frame = table.column("frame"),
             sigma = table.column("sigma_m"), sigma_height = table.column("sigma_height_m");
  std::vector<Anchor> anchors;
  std::map<std::string, std::size_t> index;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    WATERSKY_TRY(const std::string anchor_name, name_at(table, row));
    Anchor& anchor = named(anchors, index, anchor_name);
    WATERSKY_TRY(const std::optional<AnchorPlace> place, place_at(table, row));
    if (place && anchor.place && !same(*place, *anchor.place))
      return bad(table.place(row) + ": puts " + anchor.name +
                 " elsewhere than a line before; name them differently, or give the positions of "
                 "one that moves in " +
                 kAnchorTracksFile);
    if (place) anchor.place = place;
    if (!empty_at(table, row, sigma)) {
      WATERSKY_TRY(anchor.sigma_m, sigma_at(table, row, *sigma));
      anchor.sigma_height_m = anchor.sigma_m;
    }
    if (!empty_at(table, row, sigma_height)) {
      WATERSKY_TRY(anchor.sigma_height_m, sigma_at(table, row, *sigma_height));
    }
    if (empty_at(table, row, frame)) {
      if (!empty_at(table, row, u) || !empty_at(table, row, v))
        return bad(table.place(row) + ": has a pixel but names no frame; add it");
      continue;
    }
    AnchorSighting sighting;
    sighting.frame = table.cell(row, *frame);
    WATERSKY_CHECK(check_name(sighting.frame, table.place(row)));
    for (const AnchorSighting& s : anchor.sightings)
      if (s.frame == sighting.frame)
        return bad(table.place(row) + ": " + anchor.name + " is marked twice in " + s.frame +
                   "; remove one line");
    WATERSKY_TRY(sighting.px.u, number_in(table, row, *u, -kMost_px, kMost_px));
    WATERSKY_TRY(sighting.px.v, number_in(table, row, *v, -kMost_px, kMost_px));
    if (!empty_at(table, row, sigma_px)) {
      WATERSKY_TRY(sighting.sigma_px, sigma_at(table, row, *sigma_px));
    }
    anchor.sightings.push_back(std::move(sighting));
  }
  return anchors;
}

Status parse_anchor_tracks_csv(std::string_view text, const std::string& name,
                               std::vector<Anchor>& anchors, std::vector<std::string>& notes) {
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, name));
  WATERSKY_CHECK(table.require({"anchor", "time_s", "lat_deg", "lon_deg"}));
  detail::note_unknown(table,
                       table.unknown_columns({"anchor", "time_s", "lat_deg", "lon_deg",
                                              "height_ellipsoid_m", "height_above_sea_m"}),
                       notes);
  auto index = index_of(anchors);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    WATERSKY_TRY(const std::string anchor_name, name_at(table, row));
    Anchor& anchor = named(anchors, index, anchor_name);
    if (anchor.place)
      return bad(table.place(row) + ": " + anchor.name +
                 " has a fixed place as well; remove either that or its track");
    WATERSKY_TRY(const Time time, table.time(row, *table.column("time_s")));
    WATERSKY_TRY(const std::optional<AnchorPlace> place, place_at(table, row));
    if (!place) return bad(table.place(row) + ": says no place; fill lat_deg and lon_deg");
    if (!anchor.track.empty()) {
      if (time <= anchor.track.back().time)
        return bad(table.place(row) + ": is not later than the line of " + anchor.name +
                   " before it; sort the lines by time and remove what is twice");
      if (place->above != anchor.track.back().place.above)
        return bad(table.place(row) + ": gives the height of " + anchor.name +
                   " above something else than the line before; keep to one");
    }
    anchor.track.push_back({time, *place});
  }
  return {};
}

Status check_anchors(const std::vector<Anchor>& anchors, const std::string& name) {
  for (const Anchor& anchor : anchors)
    if (!anchor.place && anchor.track.empty())
      return bad(name + ": " + anchor.name +
                 " has no place; fill lat_deg and lon_deg, or give its positions in " +
                 kAnchorTracksFile);
  return {};
}

namespace {

/// What the first line of a gcp_list.txt says; no projection: longitude and latitude.
Result<std::optional<Projection>> gcp_system(const std::string& header, const std::string& place) {
  const Error unsupported{
      ErrorCode::Unsupported,
      place + ": \"" + header.substr(0, 60) +
          "\" is none of EPSG:4326, EPSG:326zz, EPSG:327zz, WGS84 UTM zzN, +proj=utm +zone=zz; "
          "convert the points to EPSG:4326"};
  const std::string text = lower(header);
  const auto utm = [&](std::string_view digits, bool south) -> Result<std::optional<Projection>> {
    int zone = 0;
    const auto [end, ec] = std::from_chars(digits.data(), digits.data() + digits.size(), zone);
    if (ec != std::errc{} || end != digits.data() + digits.size() || zone < 1 || zone > 60)
      return unsupported;
    WATERSKY_TRY(Projection projection,
                 Projection::from_text("EPSG:" + std::to_string((south ? 32700 : 32600) + zone)));
    return std::optional(std::move(projection));
  };
  if (text == "epsg:4326") return std::optional<Projection>{};
  for (const bool south : {false, true})
    if (const std::string epsg = south ? "epsg:327" : "epsg:326";
        text.starts_with(epsg) && text.size() == epsg.size() + 2)
      return utm(std::string_view(text).substr(epsg.size()), south);
  if (text.starts_with("wgs84 utm ") && (text.ends_with('n') || text.ends_with('s')))
    return utm(std::string_view(text).substr(10, text.size() - 11), text.ends_with('s'));
  if (text.find("+proj=utm") != std::string::npos &&
      (text.find("wgs84") != std::string::npos || text.find("+ellps") == std::string::npos)) {
    const std::size_t at = text.find("+zone=");
    if (at == std::string::npos) return unsupported;
    const std::size_t from = at + 6;
    const std::size_t to = std::min(text.find_first_not_of("0123456789", from), text.size());
    return utm(std::string_view(text).substr(from, to - from),
               text.find("+south") != std::string::npos);
  }
  return unsupported;
}

/// Words between blanks, as OpenDroneMap splits a line.
std::vector<std::string> words_of(std::string_view line) {
  constexpr const char* kBlank = " \t\r";
  std::vector<std::string> words;
  for (std::size_t at = line.find_first_not_of(kBlank); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
    words.emplace_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlank, end);
  }
  return words;
}

}  // namespace

Result<std::vector<Anchor>> parse_gcp_list(std::string_view text, const std::string& name,
                                           std::vector<std::string>& notes) {
  constexpr double kOpenDroneMapSigma_m = 0.1;  // --gcp-accuracy of OpenDroneMap
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::optional<std::optional<Projection>> system;
  std::vector<Anchor> anchors;
  std::map<std::string, std::size_t> index;
  bool with_heights = false;
  std::size_t line_number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::vector<std::string> words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string place = name + ":" + std::to_string(++line_number);
    if (words.empty() || words[0].starts_with('#')) continue;
    if (!system) {
      std::string header;
      for (const std::string& word : words) header += (header.empty() ? "" : " ") + word;
      WATERSKY_TRY(system, gcp_system(header, place));
      continue;
    }
    if (words.size() < 6)
      return bad(place + ": has " + std::to_string(words.size()) +
                 " words; a point is x y z u v image, and a name if you like");
    for (const std::string& word : words) WATERSKY_CHECK(check_name(word, place));
    double number[5];
    for (std::size_t k = 0; k < 5; ++k) {
      const bool no_height = k == 2 && lower(words[k]) == "nan";
      const auto x = no_height ? std::optional(std::nan("")) : parse_number(words[k]);
      if (!x)
        return bad(place + ": " + std::string(1, "xyzuv"[k]) + " is \"" + words[k].substr(0, 40) +
                   "\", not a number; correct or remove the line");
      number[k] = *x;
    }
    AnchorPlace at;
    if (*system) {
      const auto found = (*system)->inverse({number[0], number[1]});
      if (!found)
        return bad(place + ": lies outside its UTM zone; x is the easting, y the northing");
      at.latitude = found->latitude;
      at.longitude = found->longitude;
    } else {
      if (std::abs(number[0]) > 360 || std::abs(number[1]) > 90)
        return bad(place + ": is no place on the Earth; x is the longitude, y the latitude");
      at.longitude = Angle::degrees(number[0]);
      at.latitude = Angle::degrees(number[1]);
    }
    if (!std::isnan(number[2])) {
      if (std::abs(number[2]) > kFarthest_m) return bad(place + ": its height z is not metres");
      at.height_m = number[2];
      at.above = HeightAbove::Ellipsoid;
      with_heights = true;
    }
    if (std::abs(number[3]) > kMost_px || std::abs(number[4]) > kMost_px)
      return bad(place + ": u v is no pixel of a picture");
    // Points without a name are told apart by where they are.
    const std::string key =
        words.size() > 6 ? words[6] : words[0] + " " + words[1] + " " + words[2];
    Anchor& anchor = named(anchors, index, key);
    if (anchor.place && !same(*anchor.place, at))
      return bad(place + ": puts " + anchor.name +
                 " elsewhere than a line before; name the points differently");
    anchor.place = at;
    anchor.sigma_m = anchor.sigma_height_m = kOpenDroneMapSigma_m;
    for (const AnchorSighting& s : anchor.sightings)
      if (s.frame == words[5])
        return bad(place + ": " + anchor.name + " is marked twice in " + s.frame +
                   "; remove one line");
    anchor.sightings.push_back({words[5], {number[3], number[4]}, 1.0});
  }
  if (!system) return bad(name + ": is empty; its first line must name the system of coordinates");
  if (with_heights)
    notes.push_back(name +
                    ": its heights were taken as above the ellipsoid; NaN would put a point at the "
                    "sea");
  return anchors;
}

Result<std::vector<RangeSample>> parse_range_csv(std::string_view text, const std::string& name,
                                                 std::vector<std::string>& notes) {
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, name));
  WATERSKY_CHECK(table.require({"time_s", "range_m"}));
  detail::note_unknown(table, table.unknown_columns({"time_s", "range_m", "sigma_m"}), notes);
  const auto sigma = table.column("sigma_m");
  std::vector<RangeSample> out;
  out.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    RangeSample sample;
    WATERSKY_TRY(sample.time, table.time(row, *table.column("time_s")));
    if (row > 0) WATERSKY_CHECK(detail::times_must_rise(table, row, out.back().time, sample.time));
    WATERSKY_TRY(sample.range_m, number_in(table, row, *table.column("range_m"), 0.0, kFarthest_m));
    if (!empty_at(table, row, sigma)) {
      WATERSKY_TRY(sample.sigma_m, sigma_at(table, row, *sigma));
    }
    out.push_back(sample);
  }
  return out;
}

std::string format_anchors_csv(
    const std::vector<Anchor>& anchors,
    const std::function<std::optional<std::string>(const std::string& frame)>& file_of) {
  std::string out =
      "anchor,lat_deg,lon_deg,height_ellipsoid_m,height_above_sea_m,sigma_m,sigma_height_m,frame,"
      "u_px,v_px,sigma_px\n";
  for (const Anchor& anchor : anchors) {
    const std::string start =
        csv_cell(anchor.name) + "," + (anchor.place ? place_cells(*anchor.place) : ",,,") + "," +
        format_number(anchor.sigma_m) + "," + format_number(anchor.sigma_height_m) + ",";
    bool written = false;
    for (const AnchorSighting& s : anchor.sightings)
      if (const auto file = file_of(s.frame)) {
        out += start + csv_cell(*file) + "," + format_number(s.px.u) + "," + format_number(s.px.v) +
               "," + format_number(s.sigma_px) + "\n";
        written = true;
      }
    if (!written) out += start + ",,,\n";
  }
  return out;
}

std::string format_anchor_tracks_csv(const std::vector<Anchor>& anchors) {
  std::string out;
  for (const Anchor& anchor : anchors)
    for (const AnchorFix& fix : anchor.track) {
      if (out.empty())
        out = "anchor,time_s,lat_deg,lon_deg,height_ellipsoid_m,height_above_sea_m\n";
      out += csv_cell(anchor.name) + "," + format_time_seconds(fix.time) + "," +
             place_cells(fix.place) + "\n";
    }
  return out;
}

std::string format_range_csv(const std::vector<RangeSample>& ranges) {
  std::string out = "time_s,range_m,sigma_m\n";
  for (const RangeSample& r : ranges)
    out += format_time_seconds(r.time) + "," + format_number(r.range_m) + "," +
           (r.sigma_m > 0 ? format_number(r.sigma_m) : std::string()) + "\n";
  return out;
}

Result<std::vector<Anchor>> read_anchors(const fs::path& file, std::vector<std::string>& notes) {
  WATERSKY_TRY(const std::string text, read_text(file));
  const std::string name = file.filename().string();
  const auto in_folder = [&](const Error& e) { return in_folder_of(file, e); };
  if (lower_extension(file) == ".txt") {
    auto anchors = parse_gcp_list(text, name, notes);
    if (!anchors) return in_folder(anchors.error());
    return anchors;
  }
  auto anchors = parse_anchors_csv(text, name, notes);
  if (!anchors) return in_folder(anchors.error());
  std::error_code ignored;
  const fs::path tracks = file.parent_path() / kAnchorTracksFile;
  if (fs::exists(tracks, ignored)) {
    WATERSKY_TRY(const std::string tracks_text, read_text(tracks));
    const Status read = parse_anchor_tracks_csv(tracks_text, kAnchorTracksFile, *anchors, notes);
    if (!read) return in_folder(read.error());
  }
  if (const Status good = check_anchors(*anchors, name); !good) return in_folder(good.error());
  return anchors;
}

Result<std::vector<RangeSample>> read_ranges(const fs::path& file,
                                             std::vector<std::string>& notes) {
  WATERSKY_TRY(const std::string text, read_text(file));
  auto ranges = parse_range_csv(text, file.filename().string(), notes);
  if (!ranges) return in_folder_of(file, ranges.error());
  return ranges;
}

Status read_known_points(const fs::path& folder, const std::optional<fs::path>& anchors_file,
                         const std::optional<fs::path>& range_file, Flight& flight) {
  const auto there = [&](const char* name) -> std::optional<fs::path> {
    std::error_code ignored;
    return fs::is_regular_file(folder / name, ignored) ? std::optional(folder / name)
                                                       : std::nullopt;
  };
  std::optional<fs::path> anchors = anchors_file;
  if (!anchors) anchors = there(kAnchorsFile);
  if (!anchors) anchors = there(kGcpListFile);
  if (anchors) {
    WATERSKY_TRY(flight.anchors, read_anchors(*anchors, flight.notes));
  }
  const auto ranges = range_file ? range_file : there(kRangesFile);
  if (ranges) {
    WATERSKY_TRY(flight.ranges, read_ranges(*ranges, flight.notes));
  }
  return {};
}

}  // namespace watersky
