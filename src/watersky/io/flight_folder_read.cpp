// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/detail/csv_checks.hpp"
#include "watersky/io/detail/flight_description.hpp"
#include "watersky/io/detail/photos.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/known_points_file.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::note_unknown;
using detail::times_must_rise;

Error bad(const std::string& message) { return {ErrorCode::InvalidInput, message}; }

constexpr double kFar_m = 1e7;

/// The cells of named columns as numbers.
template <std::size_t N>
Result<std::array<double, N>> numbers(const CsvTable& table, std::size_t row,
                                      const std::array<std::size_t, N>& columns) {
  std::array<double, N> out{};
  for (std::size_t i = 0; i < N; ++i) {
    WATERSKY_TRY(out[i], table.number(row, columns[i]));
  }
  return out;
}

template <std::size_t N>
std::array<std::size_t, N> columns_of(const CsvTable& table,
                                      const std::array<const char*, N>& names) {
  std::array<std::size_t, N> out{};
  for (std::size_t i = 0; i < N; ++i) out[i] = table.column(names[i]).value_or(0);
  return out;
}

constexpr std::array kLocal = {"north_m", "east_m", "down_m", "qw", "qx", "qy", "qz"};
constexpr std::array kGeodetic = {"lat_deg",  "lon_deg",   "height_ellipsoid_m",
                                  "roll_deg", "pitch_deg", "yaw_deg"};
constexpr std::array kSigma = {"sigma_north_m",  "sigma_east_m",    "sigma_down_m",
                               "sigma_roll_deg", "sigma_pitch_deg", "sigma_yaw_deg"};

Result<Geodetic> place_at(const CsvTable& table, std::size_t row) {
  WATERSKY_TRY(const auto v,
               numbers(table, row,
                       columns_of(table, std::array{"lat_deg", "lon_deg", "height_ellipsoid_m"})));
  if (std::abs(v[0]) > 90 || std::abs(v[1]) > 360)
    return bad(table.place(row) + ": is no place on the Earth; lat_deg is from -90 to 90");
  return Geodetic{Angle::degrees(v[0]), Angle::degrees(v[1]), v[2]};
}

/// One row's pose in World.
Result<Rigid3<World, Body>> pose_at(const CsvTable& table, std::size_t row, bool local,
                                    const Datum& datum) {
  if (local) {
    WATERSKY_TRY(const auto v, numbers(table, row, columns_of(table, kLocal)));
    const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
    constexpr double kRounding = 1e-3;
    if (std::abs(q.norm() - 1) > kRounding)
      return bad(table.place(row) + ": qw, qx, qy, qz are no rotation (their length is " +
                 format_number(q.norm()) + ", not 1)");
    return Rigid3<World, Body>(q, Point<World>{{v[0], v[1], v[2]}});
  }
  WATERSKY_TRY(const Geodetic place, place_at(table, row));
  WATERSKY_TRY(
      const auto v,
      numbers(table, row, columns_of(table, std::array{"roll_deg", "pitch_deg", "yaw_deg"})));
  const Eigen::Quaterniond ned_from_body =
      rotation_from({Angle::degrees(v[2]), Angle::degrees(v[1]), Angle::degrees(v[0])});
  return Rigid3<World, Body>(datum.world_from_ned_rotation(place) * ned_from_body,
                             datum.world(place));
}

}  // namespace

Result<std::optional<Geodetic>> first_place_of_poses_csv(std::string_view text,
                                                         const std::string& name) {
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, name));
  if (!table.column("lat_deg") || !table.column("lon_deg") || !table.column("height_ellipsoid_m") ||
      table.rows() == 0)
    return std::optional<Geodetic>{};
  WATERSKY_TRY(const Geodetic place, place_at(table, 0));
  return std::optional(place);
}

Result<std::vector<StampedPose>> parse_poses_csv(std::string_view text, const std::string& name,
                                                 const Datum& datum,
                                                 std::vector<std::string>& notes) {
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, name));
  WATERSKY_CHECK(table.require({"time_s"}));
  const bool local = table.column("north_m").has_value();
  if (local && table.column("lat_deg"))
    return bad(name + ": has both north_m and lat_deg; keep one of the two forms");
  for (const char* column : local ? std::vector<const char*>(kLocal.begin(), kLocal.end())
                                  : std::vector<const char*>(kGeodetic.begin(), kGeodetic.end()))
    WATERSKY_CHECK(table.require({column}));
  std::size_t sigmas = 0;
  for (const char* column : kSigma) sigmas += table.column(column) ? 1 : 0;
  if (sigmas != 0 && sigmas != kSigma.size())
    return bad(name + ": has some sigma columns but not all six (sigma_north_m … sigma_yaw_deg)");
  std::vector<std::string> unknown = table.unknown_columns({"time_s",
                                                            "north_m",
                                                            "east_m",
                                                            "down_m",
                                                            "qw",
                                                            "qx",
                                                            "qy",
                                                            "qz",
                                                            "lat_deg",
                                                            "lon_deg",
                                                            "height_ellipsoid_m",
                                                            "roll_deg",
                                                            "pitch_deg",
                                                            "yaw_deg",
                                                            "sigma_north_m",
                                                            "sigma_east_m",
                                                            "sigma_down_m",
                                                            "sigma_roll_deg",
                                                            "sigma_pitch_deg",
                                                            "sigma_yaw_deg"});
  note_unknown(table, std::move(unknown), notes);

  const std::size_t time_column = *table.column("time_s");
  std::vector<StampedPose> poses;
  poses.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    StampedPose& pose = poses.emplace_back();
    WATERSKY_TRY(pose.time, table.time(row, time_column));
    if (row > 0) WATERSKY_CHECK(times_must_rise(table, row, poses[row - 1].time, pose.time));
    WATERSKY_TRY(pose.world_from_body, pose_at(table, row, local, datum));
    if (pose.world_from_body.origin().v.cwiseAbs().maxCoeff() > kFar_m)
      return bad(table.place(row) + ": lies more than 10000 km from the datum");
    if (sigmas > 0) {
      WATERSKY_TRY(const auto s, numbers(table, row, columns_of(table, kSigma)));
      if (std::any_of(s.begin(), s.end(), [](double x) { return x < 0; }))
        return bad(table.place(row) + ": has a negative sigma");
      const double rad = Angle::degrees(1).radians();
      pose.sigma = PoseSigma{{s[0], s[1], s[2]}, {s[3] * rad, s[4] * rad, s[5] * rad}};
    }
  }
  return poses;
}

Result<std::vector<StampedRotation>> parse_gimbal_csv(std::string_view text,
                                                      const std::string& name) {
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, name));
  WATERSKY_CHECK(table.require({"time_s", "roll_deg", "pitch_deg", "yaw_deg"}));
  const auto columns = columns_of(table, std::array{"roll_deg", "pitch_deg", "yaw_deg"});
  std::vector<StampedRotation> out;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    WATERSKY_TRY(const Time time, table.time(row, *table.column("time_s")));
    if (row > 0) WATERSKY_CHECK(times_must_rise(table, row, out.back().time, time));
    WATERSKY_TRY(const auto v, numbers(table, row, columns));
    out.push_back(
        {time, rotation_from({Angle::degrees(v[2]), Angle::degrees(v[1]), Angle::degrees(v[0])})});
  }
  return out;
}

namespace {

/// frames.csv and its images; `camera` may be scaled to fit them.
Status read_frames(const fs::path& folder, CameraModel& camera, const std::string& calibration,
                   Flight& flight, const Progress& progress) {
  WATERSKY_TRY(const std::string text, read_text(folder / "frames.csv"));
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, "frames.csv"));
  WATERSKY_CHECK(table.require({"file"}));
  const auto captured = table.column("captured_s"), received = table.column("received_s"),
             counter = table.column("counter");
  if (!captured && !received)
    return bad("frames.csv: has neither captured_s nor received_s; add one");
  note_unknown(table, table.unknown_columns({"file", "captured_s", "received_s", "counter"}),
               flight.notes);

  const std::size_t file_column = *table.column("file");
  std::optional<std::pair<std::string, ImageSize>> first;
  std::set<std::string> seen;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    report(progress, "reading frames", row, table.rows());
    const std::string& name = table.cell(row, file_column);
    if (name.empty()) return bad(table.place(row) + ": names no file");
    if (!seen.insert(name).second)
      return bad(table.place(row) + ": " + name + " is listed twice; remove one line");
    ImageFrame frame;
    frame.name = name;
    const auto cell_time =
        [&](const std::optional<std::size_t>& column) -> Result<std::optional<Time>> {
      if (!column || table.cell(row, *column).empty()) return std::optional<Time>{};
      WATERSKY_TRY(const Time t, table.time(row, *column));
      return std::optional(t);
    };
    WATERSKY_TRY(frame.captured_at, cell_time(captured));
    WATERSKY_TRY(frame.received_at, cell_time(received));
    if (counter && !table.cell(row, *counter).empty()) {
      WATERSKY_TRY(const double n, table.number(row, *counter));
      if (n < 0 || n > 9e15 || n != std::floor(n))
        return bad(table.place(row) + ": counter is not a whole number");
      frame.counter = static_cast<std::uint64_t>(n);
    }

    fs::path path = folder / "images" / name;
    std::error_code ignored;
    if (!fs::exists(path, ignored)) path = folder / name;
    const auto size = probe_image_size(path);
    if (!size) {
      flight.left_out.push_back({name, size.error().message});
      continue;
    }
    if (!first) {
      first = {name, *size};
      WATERSKY_TRY(camera, detail::fitted_to(camera, size->width_px, size->height_px, calibration,
                                             name, flight.notes));
    } else if (*size != first->second) {
      const auto shown = [](const std::string& n, const ImageSize& s) {
        return n + " (" + std::to_string(s.width_px) + "x" + std::to_string(s.height_px) + ")";
      };
      return bad(table.place(row) + ": two cameras are mixed, " +
                 shown(first->first, first->second) + " and " + shown(name, *size) +
                 "; give each camera a flight folder of its own");
    }
    frame.load = image_loader(path, *size);
    frame.file = path;
    flight.frames.push_back(std::move(frame));
  }
  if (table.rows() == 0) return bad("frames.csv: lists no frame");
  return {};
}

}  // namespace

Result<Flight> read_flight_folder(const fs::path& folder, const ReadOptions& options,
                                  const Progress& progress) {
  const auto in_folder = [&](const Error& e) { return e.at(folder.string()); };
  WATERSKY_TRY(const std::string yaml, read_text(folder / "flight.yaml"));
  const auto description = parse_flight_yaml(yaml, "flight.yaml");
  if (!description) return in_folder(description.error());
  const FlightDescription& d = *description;
  if (options.camera_file && options.focal_px)
    return Error{ErrorCode::Usage, "--camera and --focal-px exclude each other; give one"};
  if (options.log)
    return Error{
        ErrorCode::Usage,
        folder.string() + ": is a flight folder and has its poses; --log does not go with it"};

  const fs::path calibration = options.camera_file.value_or(folder / d.camera);
  WATERSKY_TRY(CameraModel camera, read_calibration(calibration));
  if (options.focal_px) {
    WATERSKY_TRY(Intrinsics given, intrinsics_from_focal_px(*options.focal_px, camera.width_px(),
                                                            camera.height_px()));
    camera = given.camera;
  }

  WATERSKY_TRY(const std::string poses_text, read_text(folder / "poses.csv"));
  std::optional<Geodetic> origin = d.datum;
  std::vector<std::string> notes;
  if (!origin) {
    const auto place = first_place_of_poses_csv(poses_text, "poses.csv");
    if (!place) return in_folder(place.error());
    if (!*place)
      return in_folder(
          Error{ErrorCode::NotFound,
                "flight.yaml names no datum, and poses.csv is relative to one; add it"});
    origin = *place;
    notes.emplace_back("flight.yaml names no datum: the first pose is taken for it");
  }

  const std::string shown = options.camera_file ? calibration.string() : d.camera;
  WATERSKY_TRY(Flight flight,
               detail::described_flight(d, resolved(folder).filename().string(),
                                        Datum(*origin, d.datum_x_azimuth), camera, options));
  flight.notes.insert(flight.notes.begin(), notes.begin(), notes.end());

  auto poses = parse_poses_csv(poses_text, "poses.csv", flight.datum, flight.notes);
  if (!poses) return in_folder(poses.error());
  WATERSKY_TRY(flight.trajectory, Trajectory::make(std::move(*poses)));

  std::error_code ignored;
  if (fs::exists(folder / "gimbal.csv", ignored)) {
    if (!d.gimbal_frame)
      return in_folder(Error{
          ErrorCode::NotFound,
          "gimbal.csv is there, but flight.yaml does not say gimbal_frame: body or north; add it"});
    WATERSKY_TRY(const std::string text, read_text(folder / "gimbal.csv"));
    auto rotations = parse_gimbal_csv(text, "gimbal.csv");
    if (!rotations) return in_folder(rotations.error());
    WATERSKY_TRY(flight.gimbal, RotationTrack::make(std::move(*rotations)));
  } else if (d.gimbal_frame) {
    return in_folder(
        Error{ErrorCode::NotFound, "flight.yaml names a gimbal_frame, but there is no gimbal.csv"});
  }

  if (const Status frames = read_frames(folder, flight.camera, shown, flight, progress); !frames)
    return in_folder(frames.error());
  WATERSKY_CHECK(read_known_points(folder, options.anchors_file, options.range_file, flight));
  return flight;
}

}  // namespace watersky
