// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/detail/flight_description.hpp"
#include "watersky/io/detail/stored_image.hpp"
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
    WATERSKY_TRY(const std::string yaml, detail::flight_yaml(flight_));
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
    const bool keep = options_.images == StoredImages::Keep && detail::has_own_bytes(frame);
    // One that is kept is decoded only to see that it can be.
    const ImageRequest request =
        keep ? ImageRequest{.color = false, .reduction = 8} : ImageRequest{};
    auto image = frame.load ? frame.load(request)
                            : Result<cv::Mat>(Error{ErrorCode::NotFound, "it has no image"});
    if (!image) {
      left_out_.push_back({frame.name, image.error().message});
      return {};
    }
    const bool png = options_.images == StoredImages::Png || options_.keep_as_png;
    const bool jpeg = !png && image->depth() == CV_8U;
    auto stored = keep ? detail::own_bytes(frame)
                       : detail::encode_image(*image, jpeg, options_.jpeg_quality, frame.name);
    if (!stored) return stored.error();
    const std::string stem = plain_stem(frame.name), extension = stored->extension;
    std::string file = stem + extension;
    for (int k = 2; !files_.insert(file).second; ++k)
      file = stem + "_" + std::to_string(k) + extension;
    const auto& bytes = stored->bytes;
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
