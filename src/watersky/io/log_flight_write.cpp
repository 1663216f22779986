// SPDX-License-Identifier: MIT
#include "watersky/io/log_flight_write.hpp"

#include <cmath>
#include <cstdio>
#include <map>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/detail/stored_image.hpp"
#include "watersky/io/files.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

const char* log_name(LogFormat format) {
  switch (format) {
    case LogFormat::Tlog: return "flight.tlog";
    case LogFormat::DataFlash: return "flight.bin";
    case LogFormat::Lsf: break;
  }
  return "Data.lsf";
}

std::optional<Time> time_of(const ImageFrame& frame) {
  return frame.captured_at ? frame.captured_at : frame.received_at;
}

Result<EncodedImage> image_of(const ImageFrame& frame, const WriteRecordingOptions& options) {
  if (detail::has_own_bytes(frame)) return detail::own_bytes(frame);
  WATERSKY_TRY(const cv::Mat image, frame.load({}));
  return detail::encode_image(image, options.jpeg, options.jpeg_quality, frame.name);
}

/// To a millionth: as people give it, not as it was rounded on the way.
std::string number(double x) { return format_number(std::round(x * 1e6) / 1e6 + 0.0); }

/// The options by which the flight is read as it was.
Result<std::vector<std::string>> options_to_tell(const Flight& flight, bool arrivals) {
  std::vector<std::string> out;
  if (!flight.mount.assumed) {
    const YawPitchRoll mount =
        yaw_pitch_roll(flight.mount.rotation * forward_right_down_from_camera().conjugate());
    out.push_back("--mount " + number(mount.roll.degrees()) + "," + number(mount.pitch.degrees()) +
                  "," + number(mount.yaw.degrees()));
  }
  if (const Eigen::Vector3d& arm = flight.mount.lever_arm_m; !arm.isZero())
    out.push_back("--lever-arm " + number(arm.x()) + "," + number(arm.y()) + "," + number(arm.z()));
  if (flight.sea_level) {
    WATERSKY_TRY(const double sea_m, flight.sea_level->height_ellipsoid_m(flight.datum.origin()));
    out.push_back("--sea-level ellipsoid:" + number(sea_m));
  }
  if (arrivals && flight.delay_s) out.push_back("--delay-s " + number(*flight.delay_s));
  return out;
}

}  // namespace

Result<WrittenLogFlight> write_log_flight(const Flight& flight, const fs::path& folder,
                                          LogFormat format, const WriteRecordingOptions& options,
                                          const Progress& progress) {
  std::error_code ec;
  if (!options.replace && fs::exists(fs::symlink_status(folder, ec)))
    return Error{ErrorCode::Exists, folder.string() + ": is already there; give another name"};
  WATERSKY_TRY(PartialFolder partial, PartialFolder::beside(folder));
  WrittenLogFlight out;
  Flight written = flight;
  written.frames.clear();
  // Readers take photographs by name, and a name is a time.
  std::map<Time, const ImageFrame*> by_time;
  bool arrivals = false;
  for (const ImageFrame& frame : flight.frames) {
    const auto time = time_of(frame);
    if (!time) {
      out.left_out.push_back({frame.name, "it has no time"});
    } else if (!by_time.emplace(std::chrono::floor<std::chrono::microseconds>(*time), &frame)
                    .second) {
      out.left_out.push_back({frame.name, "another frame has the same time"});
    }
    arrivals |= !frame.captured_at;
  }
  std::size_t done = 0;
  for (const auto& [time, frame] : by_time) {
    report(progress, "writing images", done++, by_time.size());
    const auto image = image_of(*frame, options);
    if (!image) {
      out.left_out.push_back({frame->name, image.error().message});
      continue;
    }
    char name[40];
    std::snprintf(
        name, sizeof name, "%016lld",
        static_cast<long long>(
            std::chrono::floor<std::chrono::microseconds>(time.time_since_epoch()).count()));
    WATERSKY_CHECK(
        write_file(partial.path() / (name + image->extension),
                   {reinterpret_cast<const char*>(image->bytes.data()), image->bytes.size()}));
    written.frames.push_back(*frame);
  }
  report(progress, "writing images", by_time.size(), by_time.size());
  WATERSKY_CHECK(write_file(partial.path() / "camera.yaml", format_calibration(flight.camera)));
  WATERSKY_TRY(const AutopilotLog log, autopilot_log_of(written));
  WATERSKY_TRY(const std::vector<std::uint8_t> bytes, encode_log(log, format));
  WATERSKY_CHECK(write_file(partial.path() / log_name(format),
                            {reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  WATERSKY_TRY(out.options, options_to_tell(flight, arrivals));
  out.options.push_back("--camera " + (folder / "camera.yaml").string());
  WATERSKY_CHECK(partial.publish());
  return out;
}

}  // namespace watersky
