// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/known_points_file.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

std::string joined(std::initializer_list<double> numbers) {
  std::string out;
  for (const double x : numbers) out += (out.empty() ? "" : ",") + format_number(x);
  return out;
}

std::string degrees_text(const Eigen::Quaterniond& q) {
  const YawPitchRoll a = yaw_pitch_roll(q);
  return joined({a.roll.degrees(), a.pitch.degrees(), a.yaw.degrees()});
}

/// Quoted for YAML: in double quotes only these need an escape.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

struct SeaLines {
  double above_datum_m = 0.0;
  bool follows_geoid = false;
};

/// A sea level is a function of place; the file knows two kinds. Which one it is shows where the
/// flight was. Unsupported when it is neither.
Result<SeaLines> describe_sea(const Flight& flight) {
  const Geodetic& origin = flight.datum.origin();
  WATERSKY_TRY(const double at_datum_m, flight.sea_level->height_ellipsoid_m(origin));
  SeaLines out{at_datum_m - origin.height_ellipsoid_m, false};
  constexpr double kSame_m = 1e-3;
  double off_ellipsoid_m = 0, off_geoid_m = 0;
  std::vector<Geodetic> places;
  // A degree away the geoid has its own slope even where the flight is short.
  for (const double step_deg : {-0.5, 0.5}) {
    Geodetic p = origin;
    p.latitude = Angle::degrees(std::clamp(origin.latitude.degrees() + step_deg, -89.9, 89.9));
    places.push_back(p);
  }
  const auto& poses = flight.trajectory.poses();
  for (std::size_t i = 0; i < poses.size(); i += 1 + poses.size() / 50)
    places.push_back(flight.datum.geodetic(poses[i].world_from_body.origin()));
  for (const Geodetic& p : places) {
    WATERSKY_TRY(const double h, flight.sea_level->height_ellipsoid_m(p));
    off_ellipsoid_m = std::max(off_ellipsoid_m, std::abs(h - at_datum_m));
  }
  if (off_ellipsoid_m < kSame_m) return out;
  WATERSKY_TRY(const double geoid_at_datum_m,
               egm96_above_ellipsoid_m(origin.latitude, origin.longitude));
  for (const Geodetic& p : places) {
    WATERSKY_TRY(const double h, flight.sea_level->height_ellipsoid_m(p));
    WATERSKY_TRY(const double n, egm96_above_ellipsoid_m(p.latitude, p.longitude));
    off_geoid_m = std::max(off_geoid_m, std::abs((h - at_datum_m) - (n - geoid_at_datum_m)));
  }
  if (off_geoid_m > kSame_m)
    return Error{ErrorCode::Unsupported,
                 "the sea level follows neither the ellipsoid nor the geoid; a flight folder "
                 "cannot hold it"};
  out.follows_geoid = true;
  return out;
}

Result<std::string> flight_yaml(const Flight& f) {
  const Geodetic& o = f.datum.origin();
  const YawPitchRoll mount =
      yaw_pitch_roll(f.mount.rotation * forward_right_down_from_camera().conjugate());
  const Eigen::Vector3d& arm = f.mount.lever_arm_m;
  std::string y = "camera: camera.yaml\n";
  if (!f.calibration.description.empty())
    y += "camera_source: " + quoted(f.calibration.description) + "\n";
  if (f.calibration.focal_sigma_px > 0)
    y += "camera_focal_sigma_px: " + format_number(f.calibration.focal_sigma_px) + "\n";
  // An assumed mount is not written down as if somebody had measured it.
  if (!f.mount.assumed) {
    y += "mount: {roll_deg: " + format_number(mount.roll.degrees()) +
         ", pitch_deg: " + format_number(mount.pitch.degrees()) +
         ", yaw_deg: " + format_number(mount.yaw.degrees()) + ", x_m: " + format_number(arm.x()) +
         ", y_m: " + format_number(arm.y()) + ", z_m: " + format_number(arm.z());
    if (f.mount.sigma_rad > 0)
      y += ", sigma_deg: " + format_number(Angle::radians(f.mount.sigma_rad).degrees());
    y += "}\n";
  }
  y += "datum: {lat_deg: " + format_number(o.latitude.degrees()) +
       ", lon_deg: " + format_number(o.longitude.degrees()) +
       ", height_ellipsoid_m: " + format_number(o.height_ellipsoid_m) +
       ", x_azimuth_deg: " + format_number(f.datum.x_azimuth().degrees()) + "}\n";
  if (f.sea_level) {
    WATERSKY_TRY(const SeaLines sea, describe_sea(f));
    y += "sea_above_datum_m: " + format_number(sea.above_datum_m) + "\n";
    if (f.sea_level->sigma_m > 0)
      y += "sea_above_datum_sigma_m: " + format_number(f.sea_level->sigma_m) + "\n";
    if (sea.follows_geoid) y += "sea_follows: geoid\n";
  }
  if (f.readout_s > 0) y += "readout_s: " + format_number(f.readout_s) + "\n";
  if (f.delay_s) y += "delay_s: " + format_number(*f.delay_s) + "\n";
  if (f.gimbal_reference)
    y += std::string("gimbal_frame: ") +
         (*f.gimbal_reference == GimbalReference::Body ? "body" : "north") + "\n";
  return y;
}

std::string poses_csv(const std::map<Time, StampedPose>& poses) {
  const bool sigma = std::any_of(poses.begin(), poses.end(),
                                 [](const auto& p) { return p.second.sigma.has_value(); });
  std::string out = "time_s,north_m,east_m,down_m,qw,qx,qy,qz";
  if (sigma)
    out += ",sigma_north_m,sigma_east_m,sigma_down_m,sigma_roll_deg,sigma_pitch_deg,sigma_yaw_deg";
  out += "\n";
  for (const auto& [time, pose] : poses) {
    const Eigen::Vector3d& p = pose.world_from_body.origin().v;
    const Eigen::Quaterniond& q = pose.world_from_body.rotation();
    out +=
        format_time_seconds(time) + "," + joined({p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
    if (sigma) {
      const PoseSigma s = pose.sigma.value_or(PoseSigma{});
      const Eigen::Vector3d a = s.roll_pitch_yaw_rad / Angle::degrees(1).radians();
      const Eigen::Vector3d& m = s.position_north_east_down_m;
      out += "," + joined({m.x(), m.y(), m.z(), a.x(), a.y(), a.z()});
    }
    out += "\n";
  }
  return out;
}

/// "video.mp4#120" → "video.mp4_120": one plain file name.
std::string plain_stem(const std::string& frame_name) {
  const std::string file = fs::path(frame_name).filename().string();
  const std::string extension = lower_extension(file);
  std::string stem = extension == ".jpg" || extension == ".jpeg" || extension == ".png" ||
                             extension == ".tif" || extension == ".tiff"
                         ? fs::path(file).stem().string()
                         : file;
  for (char& c : stem)
    if (c == '#' || c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20) c = '_';
  return stem.empty() ? "frame" : stem;
}

Result<std::vector<std::uint8_t>> encoded(const cv::Mat& image, bool jpeg,
                                          const WriteFlightOptions& options,
                                          const std::string& name) {
  std::vector<std::uint8_t> bytes;
  try {
    // Compression 1: a third larger and six times faster than the default.
    const bool done =
        jpeg ? cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, options.jpeg_quality})
             : cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1});
    if (done) return bytes;
  } catch (const cv::Exception&) {  // told below
  }
  return Error{ErrorCode::Unsupported, name + ": cannot be encoded as an image"};
}

class FolderWriter {
 public:
  FolderWriter(const Flight& flight, fs::path folder, const WriteFlightOptions& options)
      : flight_(flight), folder_(std::move(folder)), options_(options) {
    for (const StampedPose& p : flight.trajectory.poses()) poses_.emplace(p.time, p);
    for (const StampedRotation& r : flight.gimbal.rotations()) gimbal_.emplace(r.time, r.rotation);
    counters_ = std::any_of(flight.frames.begin(), flight.frames.end(),
                            [](const ImageFrame& f) { return f.counter.has_value(); });
    frames_csv_ =
        counters_ ? "file,captured_s,received_s,counter\n" : "file,captured_s,received_s\n";
  }

  Result<std::vector<LeftOut>> write(const Progress& progress) {
    std::error_code ec;
    fs::create_directories(folder_ / "images", ec);
    if (ec)
      return Error{ErrorCode::Io, folder_.string() + ": cannot be made (" + ec.message() + ")"};
    for (std::size_t i = 0; i < flight_.frames.size(); ++i) {
      report(progress, "writing images", i, flight_.frames.size());
      WATERSKY_CHECK(write_frame(flight_.frames[i]));
    }
    report(progress, "writing images", flight_.frames.size(), flight_.frames.size());
    WATERSKY_TRY(const std::string yaml, flight_yaml(flight_));
    WATERSKY_CHECK(write_file(folder_ / "flight.yaml", yaml));
    WATERSKY_CHECK(write_file(folder_ / "camera.yaml", format_calibration(flight_.camera)));
    WATERSKY_CHECK(write_file(folder_ / "frames.csv", frames_csv_));
    WATERSKY_CHECK(write_file(folder_ / "poses.csv", poses_csv(poses_)));
    if (!flight_.anchors.empty()) {
      WATERSKY_CHECK(write_file(folder_ / kAnchorsFile,
                                format_anchors_csv(flight_.anchors, [&](const std::string& frame) {
                                  const auto found = file_of_.find(frame);
                                  return found == file_of_.end() ? std::nullopt
                                                                 : std::optional(found->second);
                                })));
      const std::string tracks = format_anchor_tracks_csv(flight_.anchors);
      if (!tracks.empty()) WATERSKY_CHECK(write_file(folder_ / kAnchorTracksFile, tracks));
    }
    if (!flight_.ranges.empty())
      WATERSKY_CHECK(write_file(folder_ / kRangesFile, format_range_csv(flight_.ranges)));
    if (flight_.gimbal_reference) {
      std::string csv = "time_s,roll_deg,pitch_deg,yaw_deg\n";
      for (const auto& [time, q] : gimbal_)
        csv += format_time_seconds(time) + "," + degrees_text(q) + "\n";
      WATERSKY_CHECK(write_file(folder_ / "gimbal.csv", csv));
    }
    for (const CompanionFile& companion : options_.companions) {
      WATERSKY_TRY(const std::string bytes, companion.bytes(left_out_));
      WATERSKY_CHECK(write_file(folder_ / companion.name, bytes));
    }
    return left_out_;
  }

 private:
  Status write_frame(const ImageFrame& frame) {
    const bool own = frame.own_pose.has_value() || frame.own_gimbal.has_value();
    if (own && !frame.captured_at) {
      left_out_.push_back({frame.name, "its time is not known, and poses.csv goes by time"});
      return {};
    }
    const bool keep = options_.images == StoredImages::Keep && is_image_file(frame.file);
    // One that is kept is decoded only to see that it can be.
    const ImageRequest request =
        keep ? ImageRequest{.color = false, .reduction = 8} : ImageRequest{};
    auto image = frame.load ? frame.load(request)
                            : Result<cv::Mat>(Error{ErrorCode::NotFound, "it has no image"});
    if (!image) {
      left_out_.push_back({frame.name, image.error().message});
      return {};
    }
    const bool jpeg = options_.images != StoredImages::Png && image->depth() == CV_8U;
    const std::string stem = plain_stem(frame.name),
                      extension = keep   ? frame.file.extension().string()
                                  : jpeg ? ".jpg"
                                         : ".png";
    std::string file = stem + extension;
    for (int k = 2; !files_.insert(file).second; ++k)
      file = stem + "_" + std::to_string(k) + extension;
    std::vector<std::uint8_t> bytes;
    if (keep) {
      WATERSKY_TRY(bytes, read_bytes(frame.file));
    } else {
      WATERSKY_TRY(bytes, encoded(*image, jpeg, options_, frame.name));
    }
    WATERSKY_CHECK(write_file(folder_ / "images" / file,
                              {reinterpret_cast<const char*>(bytes.data()), bytes.size()}));

    file_of_.emplace(frame.name, file);
    std::optional<Time> captured = frame.captured_at;
    if (own) {
      while (own_times_.contains(*captured)) *captured += std::chrono::microseconds(1);
      own_times_.insert(*captured);
    }
    if (frame.own_pose) poses_.insert_or_assign(*captured, *frame.own_pose);
    if (frame.own_gimbal) gimbal_.insert_or_assign(*captured, *frame.own_gimbal);
    const auto cell = [](const std::optional<Time>& t) {
      return t ? format_time_seconds(*t) : std::string();
    };
    frames_csv_ += csv_cell(file) + "," + cell(captured) + "," + cell(frame.received_at);
    if (counters_)
      frames_csv_ += "," + (frame.counter ? std::to_string(*frame.counter) : std::string());
    frames_csv_ += "\n";
    return {};
  }

  const Flight& flight_;
  fs::path folder_;
  WriteFlightOptions options_;
  bool counters_ = false;
  std::string frames_csv_;
  std::map<Time, StampedPose> poses_;
  std::map<Time, Eigen::Quaterniond> gimbal_;
  std::set<Time> own_times_;
  std::set<std::string> files_;
  std::map<std::string, std::string> file_of_;  ///< by the name of the frame
  std::vector<LeftOut> left_out_;
};

}  // namespace

Result<std::vector<LeftOut>> write_flight_folder(const Flight& flight, const fs::path& folder,
                                                 const WriteFlightOptions& options,
                                                 const Progress& progress) {
  std::error_code ec;
  if (!options.replace && fs::exists(folder, ec))
    return Error{ErrorCode::Exists,
                 folder.string() + ": is there already; remove it or name another folder"};
  WATERSKY_TRY(PartialFolder partial, PartialFolder::beside(folder));
  auto left_out = FolderWriter(flight, partial.path(), options).write(progress);
  if (left_out) WATERSKY_CHECK(partial.publish());
  return left_out;
}

}  // namespace watersky
