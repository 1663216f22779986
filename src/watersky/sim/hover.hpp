// SPDX-License-Identifier: MIT
#pragma once
/// A multirotor that looks over one place: a room, a floe.
#include <array>
#include <cstdint>

#include "watersky/base/parameters.hpp"
#include "watersky/base/result.hpp"
#include "watersky/sim/band_limited_noise.hpp"

namespace watersky::sim {

/// Where the aircraft is, relative to the scene's anchor and the sea, and its attitude relative
/// to north, east, down where it is.
struct AircraftState {
  double north_m = 0.0, east_m = 0.0, height_m = 0.0;
  double yaw_rad = 0.0, pitch_rad = 0.0, roll_rad = 0.0;
  double course_rad = 0.0;  ///< of the track, without gusts: where a gimbal takes its heading
  bool on_leg = false;
};

/// The motion's box has axes of its own, as a room has: x along hover_azimuth_deg, y to the right
/// of it. Its middle is given in these axes, from the scene's anchor.
struct HoverParameters {
  bool hovers = false;
  double hover_duration_s = 60.0;
  double hover_azimuth_deg = 0.0;
  double hover_x_m = 0.0;
  double hover_y_m = 0.0;
  double hover_reach_x_m = 0.75;
  double hover_reach_y_m = 0.9;
  double hover_lowest_m = 1.1;
  double hover_highest_m = 1.9;
  double hover_speed_m_s = 0.5;
  double hover_yaw_deg = 0.0;
  double hover_reach_yaw_deg = 35.0;
  double hover_least_tilt_deg = 2.0;
  double hover_most_tilt_deg = 4.0;
  double hover_band_hz = 1.5;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.hovers, ParameterInfo{"hovers", "1", "a multirotor over one place, not a survey"});
    visit(self.hover_duration_s,
          ParameterInfo{"hover_duration_s", "s", "how long it flies", 1, 100000});
    visit(self.hover_azimuth_deg,
          ParameterInfo{"hover_azimuth_deg", "deg",
                        "direction of the box's x axis, clockwise from north", -360, 360});
    visit(self.hover_x_m,
          ParameterInfo{"hover_x_m", "m", "middle of the box along its x axis", -20000, 20000});
    visit(self.hover_y_m,
          ParameterInfo{"hover_y_m", "m", "middle of the box right of its x axis", -20000, 20000});
    visit(self.hover_reach_x_m,
          ParameterInfo{"hover_reach_x_m", "m", "farthest from the middle along x", 0, 10000});
    visit(self.hover_reach_y_m,
          ParameterInfo{"hover_reach_y_m", "m", "farthest from the middle along y", 0, 10000});
    visit(self.hover_lowest_m,
          ParameterInfo{"hover_lowest_m", "m", "least height above the sea", 0.3, 20000});
    visit(self.hover_highest_m,
          ParameterInfo{"hover_highest_m", "m", "greatest height above the sea", 0.3, 20000});
    visit(self.hover_speed_m_s, ParameterInfo{"hover_speed_m_s", "m/s", "never faster", 0.01, 100});
    visit(self.hover_yaw_deg,
          ParameterInfo{"hover_yaw_deg", "deg", "heading in the middle, from the box's x axis",
                        -360, 360});
    visit(self.hover_reach_yaw_deg,
          ParameterInfo{"hover_reach_yaw_deg", "deg", "farthest from that heading", 0, 180});
    visit(self.hover_least_tilt_deg,
          ParameterInfo{"hover_least_tilt_deg", "deg",
                        "one sigma of the tilt is drawn by seed from this", 0, 45});
    visit(self.hover_most_tilt_deg, ParameterInfo{"hover_most_tilt_deg", "deg", "to this", 0, 45});
    visit(self.hover_band_hz,
          ParameterInfo{"hover_band_hz", "Hz", "the tilt holds no faster motion", 0.01, 20});
  }
};

/// Swings through its box: each axis is the sum of a slow wave that covers it and a quicker one,
/// their periods and phases drawn by seed, so that the path is another in every flight and the
/// whole box comes under the camera within a minute.
class Hover {
 public:
  /// Usage for a parameter out of its range, or a lowest above a highest.
  [[nodiscard]] static Result<Hover> make(const HoverParameters& parameters, std::uint64_t seed);

  /// Any time is answered, and all of it is on the leg.
  [[nodiscard]] AircraftState at(double t_s) const;
  [[nodiscard]] double duration_s() const { return p_.hover_duration_s; }

 private:
  /// In [-1, 1].
  struct Swing {
    double slow_rad_s = 0.0, slow_phase = 0.0, quick_rad_s = 0.0, quick_phase = 0.0;
    [[nodiscard]] double at(double t_s) const;
    /// Of the swing: the steepest that it ever is.
    [[nodiscard]] double steepest_1_s() const;
  };
  Hover(const HoverParameters& parameters, std::uint64_t seed);

  HoverParameters p_;
  std::array<Swing, 4> swings_;  ///< of x, y, height and heading
  BandLimitedNoise roll_, pitch_;
};

}  // namespace watersky::sim
