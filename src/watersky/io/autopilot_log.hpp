// SPDX-License-Identifier: MIT
#pragma once
/// What an autopilot's telemetry log says about the motion of one vehicle.
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/flight/known_points.hpp"
#include "watersky/flight/trajectory.hpp"
#include "watersky/geodesy/wgs84.hpp"

namespace watersky {

struct AttitudeSample {
  Time time;
  Eigen::Quaterniond ned_from_body;
};

struct PositionSample {
  Time time;
  Angle latitude, longitude;
  double height_geoid_m = 0.0;  ///< above EGM96
};

/// That the camera took an image: CAMERA_FEEDBACK in a .tlog, CAM in a .bin.
struct CameraFeedback {
  Time time;
  int image_index = 0;
};

/// Times are UTC by the clock that stamped the log.
struct AutopilotLog {
  int system = 0;                         ///< MAVLink's, or IMC's address
  int component = 0;                      ///< MAVLink's
  std::vector<AttitudeSample> attitudes;  ///< by strictly rising time
  std::vector<PositionSample> positions;  ///< likewise
  std::vector<StampedRotation> gimbal;    ///< north, east, down from gimbal; likewise
  std::vector<CameraFeedback> feedback;   ///< in the log's order
  std::string feedback_name = "CAMERA_FEEDBACK messages";  ///< what the log calls them
  std::vector<RangeSample> ranges;                         ///< by strictly rising time
  /// Of the place of take-off; nullopt where the log does not tell.
  std::optional<double> home_height_geoid_m;
  std::vector<std::string> notes;
};

/// Reads a .tlog. A stamp says when a message arrived, time_boot_ms when it was measured: boot
/// time is taken to UTC by the line under all (boot time, stamp - boot time), as delay is never
/// negative; anew after each reboot. NotFound when no system sends both attitude and position.
[[nodiscard]] Result<AutopilotLog> parse_tlog(std::span<const std::uint8_t> bytes,
                                              const std::string& name);

/// Body poses at the attitudes' times, position linearly between GLOBAL_POSITION_INTs no more
/// than two seconds apart (a gap in position is left a gap); heights stand on EGM96.
[[nodiscard]] Result<Trajectory> make_trajectory(const AutopilotLog& log, const Datum& datum);

/// A line y = offset + slope (x - x0) that no point lies below, as near to them as can be.
struct LowerLine {
  double x0 = 0.0, offset = 0.0, slope = 0.0;
  [[nodiscard]] double at(double x) const { return offset + slope * (x - x0); }
};
/// `xy` by rising x, not empty. The slope is 0 where the points span less than `min_span` or it
/// would be steeper than `max_slope`.
[[nodiscard]] LowerLine fit_lower_line(std::span<const std::pair<double, double>> xy,
                                       double min_span, double max_slope);

}  // namespace watersky
