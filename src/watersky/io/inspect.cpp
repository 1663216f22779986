// SPDX-License-Identifier: MIT
#include "watersky/io/inspect.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/camera_table.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/detail/inspect_logs.hpp"
#include "watersky/io/detail/logged.hpp"
#include "watersky/io/detail/message_inspection.hpp"
#include "watersky/io/exif.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/message_flight.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/io/video.hpp"
#include "watersky/store/map_file.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::add_place;
using detail::add_rate;
using detail::add_time;

std::string size_text(int width_px, int height_px) {
  return std::to_string(width_px) + "x" + std::to_string(height_px);
}

Result<Inspection> inspect_image(const fs::path& file) {
  WATERSKY_TRY(const PhotoMetadata m, read_photo_metadata(file));
  Inspection out;
  out.kind = "photograph";
  out.counts["frames"] = 1;
  out.facts["size"] = size_text(m.width_px, m.height_px);
  if (!m.camera_name().empty()) out.facts["camera"] = m.camera_name();
  const auto number = [&](const char* name, const std::optional<double>& x) {
    if (x) out.facts[name] = format_number(*x);
  };
  number("focal_length_mm", m.focal_length_mm);
  number("relative_altitude_m", m.relative_altitude_m);
  number("absolute_altitude_m", m.absolute_altitude_m ? m.absolute_altitude_m : m.gps_altitude_m);
  const auto angles = [&](const char* name, const std::optional<YawPitchRoll>& a) {
    if (a)
      out.facts[name] = format_number(a->roll.degrees()) + ", " +
                        format_number(a->pitch.degrees()) + ", " + format_number(a->yaw.degrees());
  };
  angles("gimbal_roll_pitch_yaw_deg", m.gimbal);
  angles("flight_roll_pitch_yaw_deg", m.flight);
  if (m.latitude) add_place(out, m.latitude->degrees(), m.longitude->degrees());
  if (const auto utc = m.utc()) {
    add_time(out, *utc);
  } else if (m.taken_local) {
    add_time(out, *m.taken_local);
    out.notes.emplace_back("the camera's clock names no time zone: its time may not be UTC");
  }
  if (const auto intrinsics = intrinsics_from(m))
    out.facts["intrinsics"] = intrinsics->source.description;
  else
    out.notes.push_back(intrinsics.error().message);
  return out;
}

Result<Inspection> inspect_video(const fs::path& file) {
  WATERSKY_TRY(const VideoInfo info, probe_video(file));
  Inspection out;
  out.kind = "video";
  out.counts["frames"] = info.frames.size();
  out.counts["key_frames"] = static_cast<std::size_t>(std::count_if(
      info.frames.begin(), info.frames.end(), [](const VideoFrame& f) { return f.key; }));
  if (info.frames.size() > 1) out.rates_hz["frames"] = info.rate_hz();
  out.facts["size"] = size_text(info.width_px, info.height_px);
  out.facts["codec"] = info.codec;
  out.facts["duration_s"] = format_number(info.duration_s());
  if (info.rotation_deg != 0) out.facts["shown_rotated_deg"] = format_number(info.rotation_deg);
  if (info.creation_time) {
    add_time(out, *info.creation_time);
    add_time(out, *info.creation_time + info.after_first(info.frames.size() - 1));
    out.notes.emplace_back(
        "the times are by the container's creation_time: good to a second at best, and some "
        "cameras write "
        "the end or their local time there");
  } else {
    out.notes.emplace_back("the container does not say when the video begins");
  }
  if (info.frames_promised > info.frames.size())
    out.notes.push_back("cut short: of " + std::to_string(info.frames_promised) + " frames " +
                        std::to_string(info.frames.size()) + " are there");
  return out;
}

Result<Inspection> inspect_calibration(const fs::path& file) {
  WATERSKY_TRY(const CameraModel camera, read_calibration(file));
  Inspection out;
  out.kind = "calibration";
  out.facts["size"] = size_text(camera.width_px(), camera.height_px());
  out.facts["lens"] = camera.lens() == LensModel::Fisheye ? "fisheye" : "pinhole";
  out.facts["focal_px"] = format_number(camera.focal_px());
  out.facts["distorts"] = camera.distorts() ? "yes" : "no";
  return out;
}

Result<Inspection> inspect_csv(const fs::path& file) {
  WATERSKY_TRY(const std::string text, read_text(file));
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, file.string()));
  Inspection out;
  out.kind = "csv";
  out.counts["rows"] = table.rows();
  std::string columns;
  for (const std::string& c : table.columns()) columns += (columns.empty() ? "" : ",") + c;
  out.facts["columns"] = columns;
  if (const auto column = table.column("time_s")) {
    for (std::size_t row = 0; row < table.rows(); ++row) {
      WATERSKY_TRY(const Time t, table.time(row, *column));
      add_time(out, t);
    }
    if (out.first) add_rate(out, "rows", table.rows(), *out.first, *out.last);
  }
  return out;
}

Result<Inspection> inspect_recording(const fs::path& folder) {
  WATERSKY_TRY(const RecordingKind kind, recording_kind(folder));
  // Nothing is mapped here: photographs of an unknown camera are told of all the same.
  auto flight = read_flight(folder);
  ReadOptions any_focal;
  any_focal.focal_px = 1000.0;
  std::string no_intrinsics;
  if (!flight && flight.error().code == ErrorCode::NotFound) {
    if (auto again = read_flight(folder, any_focal)) {
      no_intrinsics = flight.error().message;
      flight = std::move(again);
    }
  }
  if (!flight) return flight.error();

  Inspection out;
  out.kind = kind == RecordingKind::FlightFolder         ? "flight_folder"
             : kind == RecordingKind::PhotographsWithLog ? "photographs_with_log"
             : kind == RecordingKind::VideoWithLog       ? "video_with_log"
                                                         : "photographs";
  out.counts["frames"] = flight->frames.size();
  out.counts["left_out"] = flight->left_out.size();
  const auto& poses = flight->trajectory.poses();
  out.counts["poses"] = poses.size();
  if (flight->gimbal_reference) out.counts["gimbal_attitudes"] = flight->gimbal.rotations().size();
  const auto add_pose = [&](const StampedPose& pose) {
    const Geodetic g = flight->datum.geodetic(pose.world_from_body.origin());
    add_place(out, g.latitude.degrees(), g.longitude.degrees());
  };
  std::optional<Time> first_frame, last_frame;
  std::size_t timed = 0;
  for (const ImageFrame& frame : flight->frames) {
    if (frame.own_pose) {
      add_pose(*frame.own_pose);
      ++out.counts["poses"];
    }
    const auto time = frame.captured_at ? frame.captured_at : frame.received_at;
    if (!time) continue;
    ++timed;
    first_frame = first_frame ? std::min(*first_frame, *time) : *time;
    last_frame = last_frame ? std::max(*last_frame, *time) : *time;
    add_time(out, *time);
  }
  if (first_frame) add_rate(out, "frames", timed, *first_frame, *last_frame);
  for (const StampedPose& pose : poses) {
    add_pose(pose);
    add_time(out, pose.time);
  }
  if (!poses.empty()) add_rate(out, "poses", poses.size(), poses.front().time, poses.back().time);
  out.facts["size"] = size_text(flight->camera.width_px(), flight->camera.height_px());
  out.facts["intrinsics"] = no_intrinsics.empty() ? flight->calibration.description : "not known";
  out.facts["sea_level"] =
      flight->sea_level ? flight->sea_level->description : "not known; give --sea-level";
  out.notes = flight->notes;
  if (!no_intrinsics.empty()) out.notes.push_back(no_intrinsics);
  for (const LeftOut& l : flight->left_out) out.notes.push_back(l.file + ": left out, " + l.reason);
  return out;
}

Result<Inspection> inspect_map(const fs::path& path) {
  WATERSKY_TRY(const MapFile map, MapFile::open(disk(), path));
  Inspection out;
  out.kind = "map";
  std::size_t seen = 0;
  for (const TileItem& item : map.tiles().items()) seen += item.seen_cells;
  out.counts["tiles"] = map.tiles().items().size();
  out.counts["sources"] = map.tiles().sources().size();
  out.counts["cells_seen_by_sources"] = seen;
  const auto number = [](double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", x);
    return std::string(text);
  };
  out.facts["cell_m"] = number(map.header().cell_m);
  if (map.header().half_life_s > 0) out.facts["half_life_s"] = number(map.header().half_life_s);
  out.facts["projection"] = map.header().projection;
  out.facts["overview_levels"] = std::to_string(map.levels());
  for (const MapSource& source : map.tiles().sources()) {
    out.notes.push_back("of " + source.name + ", source " + source.id);
    for (const auto& time : {source.first, source.last})
      if (time) add_time(out, *time);
  }
  const auto projection = Projection::from_text(map.header().wkt);
  if (!projection) {
    out.notes.push_back(projection.error().message);
    return out;
  }
  const double tile_m = kTileCells * map.header().cell_m;
  for (const TileIndex& index : map.tiles().tiles())
    for (const int corner : {0, 1, 2, 3}) {
      const auto place =
          projection->inverse({map.header().anchor_easting_m + (index.column + corner % 2) * tile_m,
                               map.header().anchor_northing_m - (index.row + corner / 2) * tile_m});
      if (place) add_place(out, place->latitude.degrees(), place->longitude.degrees());
    }
  return out;
}

}  // namespace

void GeographicExtent::add(double latitude_deg, double longitude_deg) {
  south_deg = std::min(south_deg, latitude_deg);
  north_deg = std::max(north_deg, latitude_deg);
  west_deg = std::min(west_deg, longitude_deg);
  east_deg = std::max(east_deg, longitude_deg);
}

Result<Inspection> inspect(const fs::path& path) {
  std::error_code ec;
  if (!fs::exists(path, ec))
    return Error{ErrorCode::NotFound, path.string() + ": there is no such file or folder"};
  const std::string extension = lower_extension(path);
  auto out =
      fs::is_directory(path, ec)   ? inspect_recording(path)
      : extension == ".tlog"       ? detail::inspect_tlog(path)
      : extension == ".bin"        ? detail::inspect_dataflash(path)
      : detail::is_log_file(path)  ? detail::inspect_lsf(path)
      : is_message_recording(path) ? detail::inspect_messages(path)
      : is_image_file(path)        ? inspect_image(path)
      : is_video_file(path)        ? inspect_video(path)
      : extension == ".csv"        ? inspect_csv(path)
      : extension == ".wsmap"      ? inspect_map(path)
      : extension == ".yaml" || extension == ".yml" || extension == ".xml"
          ? inspect_calibration(path)
          : Result<Inspection>(
                Error{ErrorCode::Unsupported,
                      path.string() +
                          ": is nothing that we can read; give a flight folder, a folder of "
                          "photographs, an image, a video, an autopilot log (" +
                          detail::kLogKinds +
                          "), an MCAP file, a ROS 1 bag, a map (.wsmap), a calibration or a .csv"});
  if (out) out->name = fs::absolute(path).lexically_normal().filename().string();
  return out;
}

nlohmann::json to_json(const Inspection& inspection) {
  nlohmann::json json;
  json["kind"] = inspection.kind;
  json["name"] = inspection.name;
  json["counts"] = inspection.counts;
  json["rates_hz"] = inspection.rates_hz;
  json["time"] = nullptr;
  if (inspection.first)
    json["time"] = {{"first", to_iso8601(*inspection.first)},
                    {"last", to_iso8601(*inspection.last)},
                    {"first_s", to_seconds(*inspection.first)},
                    {"last_s", to_seconds(*inspection.last)},
                    {"span_s", to_seconds(*inspection.last - *inspection.first)}};
  json["extent"] = nullptr;
  if (const auto& e = inspection.extent)
    json["extent"] = {{"south_deg", e->south_deg},
                      {"west_deg", e->west_deg},
                      {"north_deg", e->north_deg},
                      {"east_deg", e->east_deg}};
  json["facts"] = inspection.facts;
  json["notes"] = inspection.notes;
  return json;
}

}  // namespace watersky
