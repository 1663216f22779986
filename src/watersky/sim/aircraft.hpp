// SPDX-License-Identifier: MIT
#pragma once
/// A virtual aircraft: where it is and how it lies at any moment, in closed form.
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/base/result.hpp"
#include "watersky/sim/band_limited_noise.hpp"
#include "watersky/sim/hover.hpp"

namespace watersky::sim {

/// Legs of a survey, or a multirotor over one place.
struct AircraftParameters {
  HoverParameters hover;
  int legs = 6;
  double leg_length_m = 330.0;
  double leg_spacing_m = 50.0;
  double leg_azimuth_deg = 0.0;
  double survey_north_m = 0.0;
  double survey_east_m = 0.0;
  double height_m = 100.0;
  double speed_m_s = 18.0;
  double turn_radius_m = 60.0;
  double trim_pitch_deg = 2.0;
  double crab_deg = 3.0;
  double gust_roll_deg = 2.0;
  double gust_pitch_deg = 1.2;
  double gust_yaw_deg = 1.5;
  double gust_height_m = 0.7;
  double gust_aside_m = 0.7;
  double gust_band_hz = 0.8;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    HoverParameters::describe(self.hover, visit);
    visit(self.legs, ParameterInfo{"legs", "1", "parallel legs of the survey", 1, 1000});
    visit(self.leg_length_m, ParameterInfo{"leg_length_m", "m", "length of a leg", 1, 100000});
    visit(self.leg_spacing_m,
          ParameterInfo{"leg_spacing_m", "m",
                        "between legs; each lies to the right of the one before", 0.1, 10000});
    visit(self.leg_azimuth_deg,
          ParameterInfo{"leg_azimuth_deg", "deg",
                        "direction of the first leg, clockwise from north", -360, 360});
    visit(self.survey_north_m,
          ParameterInfo{"survey_north_m", "m", "middle of the survey north of the scene's anchor",
                        -20000, 20000});
    visit(self.survey_east_m,
          ParameterInfo{"survey_east_m", "m", "middle of the survey east of the scene's anchor",
                        -20000, 20000});
    visit(self.height_m, ParameterInfo{"height_m", "m", "height above the sea", 0.5, 20000});
    visit(self.speed_m_s, ParameterInfo{"speed_m_s", "m/s", "speed over ground", 0.1, 300});
    visit(self.turn_radius_m,
          ParameterInfo{"turn_radius_m", "m",
                        "radius of turns; their bank angle follows from it and the speed", 0.1,
                        10000});
    visit(self.trim_pitch_deg,
          ParameterInfo{"trim_pitch_deg", "deg", "nose up in level flight", -30, 30});
    visit(self.crab_deg,
          ParameterInfo{"crab_deg", "deg", "nose right of the track, as in wind from the right",
                        -60, 60});
    visit(self.gust_roll_deg,
          ParameterInfo{"gust_roll_deg", "deg", "one sigma of roll in gusts", 0, 45});
    visit(self.gust_pitch_deg,
          ParameterInfo{"gust_pitch_deg", "deg", "one sigma of pitch in gusts", 0, 45});
    visit(self.gust_yaw_deg,
          ParameterInfo{"gust_yaw_deg", "deg", "one sigma of yaw in gusts", 0, 45});
    visit(self.gust_height_m,
          ParameterInfo{"gust_height_m", "m", "one sigma of height in gusts", 0, 100});
    visit(self.gust_aside_m,
          ParameterInfo{"gust_aside_m", "m", "one sigma of the distance from the track in gusts", 0,
                        100});
    visit(self.gust_band_hz,
          ParameterInfo{"gust_band_hz", "Hz",
                        "gusts hold no faster motion of attitude, a quarter of it for position",
                        0.01, 20});
  }
};

/// Flies legs joined by turns to the right and left in turn: quarter circles with a straight
/// between them, or, where the legs lie closer than twice the turn radius, a bulb of three arcs.
/// Roll in turns is that of coordinated flight, rolled in over a second. With hover.hovers it is
/// a Hover instead, all of it one leg.
class Aircraft {
 public:
  /// Usage for a parameter out of its range or a turn that would need more than 70° of bank.
  [[nodiscard]] static Result<Aircraft> make(const AircraftParameters& parameters,
                                             std::uint64_t seed);

  /// Any time is answered: before 0 and after duration_s() it flies straight on.
  [[nodiscard]] AircraftState at(double t_s) const;
  [[nodiscard]] double duration_s() const;

 private:
  struct Segment {
    double start_m, length_m;
    double curvature_1_m;  ///< positive to the right
    double north_m, east_m, azimuth_rad;
    double bank_integral;  ///< of the coordinated bank, up to its start
    bool leg;
  };
  Aircraft(const AircraftParameters& parameters, std::uint64_t seed);
  void append(double length_m, double curvature_1_m, bool leg);
  [[nodiscard]] const Segment& segment_at(double along_m) const;
  [[nodiscard]] double bank(double curvature_1_m) const;
  [[nodiscard]] double bank_integral(double along_m) const;

  AircraftParameters p_;
  std::optional<Hover> hover_;
  std::vector<Segment> segments_;
  BandLimitedNoise roll_, pitch_, yaw_, up_, aside_;
};

}  // namespace watersky::sim
