// SPDX-License-Identifier: MIT
#pragma once
/// Files of known points: anchors.csv with anchor_tracks.csv, OpenDroneMap's gcp_list.txt, and
/// range.csv. Errors name file, line and remedy.
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/flight/flight.hpp"

namespace watersky {

constexpr const char* kAnchorsFile = "anchors.csv";
constexpr const char* kAnchorTracksFile = "anchor_tracks.csv";
constexpr const char* kGcpListFile = "gcp_list.txt";
constexpr const char* kRangesFile = "range.csv";

/// anchors.csv: anchor,lat_deg,lon_deg[,height_ellipsoid_m][,height_above_sea_m][,sigma_m]
/// [,sigma_height_m],frame,u_px,v_px[,sigma_px], a line a sighting. The place may be left empty but
/// in an anchor's first line, and is empty for anchors that move; without a height an anchor lies
/// at the sea's surface. A line without a frame only says where an anchor is.
[[nodiscard]] Result<std::vector<Anchor>> parse_anchors_csv(std::string_view text,
                                                            const std::string& name,
                                                            std::vector<std::string>& notes);

/// anchor_tracks.csv: anchor,time_s,lat_deg,lon_deg[,height_ellipsoid_m][,height_above_sea_m].
/// Times must rise anchor by anchor. Anchors that were never sighted are added.
[[nodiscard]] Status parse_anchor_tracks_csv(std::string_view text, const std::string& name,
                                             std::vector<Anchor>& anchors,
                                             std::vector<std::string>& notes);

/// InvalidInput naming the first anchor that has neither a place nor a track.
[[nodiscard]] Status check_anchors(const std::vector<Anchor>& anchors, const std::string& name);

/// gcp_list.txt of OpenDroneMap and WebODM: a line with the system of coordinates (EPSG:4326,
/// EPSG:326zz or 327zz, "WGS84 UTM 33N", "+proj=utm +zone=33 …"), then `x y z u v image [name]`
/// separated by blanks. Heights are taken as above the ellipsoid, NaN as at the sea; the file knows
/// no sigma: 0.1 m as OpenDroneMap assumes. Unsupported for other systems of coordinates.
[[nodiscard]] Result<std::vector<Anchor>> parse_gcp_list(std::string_view text,
                                                         const std::string& name,
                                                         std::vector<std::string>& notes);

/// range.csv: time_s,range_m[,sigma_m]. Times must rise.
[[nodiscard]] Result<std::vector<RangeSample>> parse_range_csv(std::string_view text,
                                                               const std::string& name,
                                                               std::vector<std::string>& notes);

/// parse_anchors_csv and parse_anchor_tracks_csv undo them. `file_of` gives the name under which a
/// frame is written, or nothing where it was not: its sightings are left out then.
[[nodiscard]] std::string format_anchors_csv(
    const std::vector<Anchor>& anchors,
    const std::function<std::optional<std::string>(const std::string& frame)>& file_of);
/// Empty where no anchor moves.
[[nodiscard]] std::string format_anchor_tracks_csv(const std::vector<Anchor>& anchors);
[[nodiscard]] std::string format_range_csv(const std::vector<RangeSample>& ranges);

/// A .txt is read as a gcp_list.txt, anything else as an anchors.csv with the tracks beside it.
[[nodiscard]] Result<std::vector<Anchor>> read_anchors(const std::filesystem::path& file,
                                                       std::vector<std::string>& notes);
[[nodiscard]] Result<std::vector<RangeSample>> read_ranges(const std::filesystem::path& file,
                                                           std::vector<std::string>& notes);

/// Fills a flight's anchors and ranges from the files given or, without them, from those in
/// `folder`, where there are any.
[[nodiscard]] Status read_known_points(const std::filesystem::path& folder,
                                       const std::optional<std::filesystem::path>& anchors_file,
                                       const std::optional<std::filesystem::path>& range_file,
                                       Flight& flight);

}  // namespace watersky
