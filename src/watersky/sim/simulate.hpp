// SPDX-License-Identifier: MIT
#pragma once
/// A virtual flight over a virtual sea: what an aircraft would have recorded, and the truth.
///
///   Scenario scenario = scenario_preset("not_easy").value();
///   scenario.seed = 7;
///   Result<Simulation> run = simulate(scenario);
///   if (!run) return run.error();
///   run->flight.frames[0].load({});       // rendered when asked for, the same each time
///   run->truth.sea.is_ice(12.0, -3.5);
#include <Eigen/Geometry>
#include <string_view>
#include <vector>

#include "watersky/flight/flight.hpp"
#include "watersky/sim/aircraft.hpp"
#include "watersky/sim/renderer.hpp"
#include "watersky/sim/sea_parameters.hpp"

namespace watersky::sim {

/// How the camera sits, when it fires, and what its clock says. mount_* is what the recording says
/// of the mount; the camera sits so but for the mount's errors.
struct CameraSetup {
  double mount_roll_deg = 0.0;
  double mount_pitch_deg = -90.0;
  double mount_yaw_deg = 0.0;
  double mount_x_m = 0.0, mount_y_m = 0.0, mount_z_m = 0.0;
  int gimbal = 0;
  double gimbal_jitter_deg = 0.2;
  double mount_error_deg = 0.0;
  double lever_error_m = 0.0;
  double frame_rate_hz = 1.0;
  bool images_in_turns = false;
  bool capture_recorded = true;
  bool counter_recorded = true;
  double arrival_delay_s = 0.15;
  double arrival_jitter_s = 0.0;
  bool arrival_two_sided = false;
  double arrival_drift_s = 0.0;
  double arrival_drift_correlation_s = 20.0;
  double drop_share = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.mount_roll_deg, ParameterInfo{"mount_roll_deg", "deg",
                                             "camera on the body, or with a gimbal where it points "
                                             "from level flight along the track",
                                             -180, 180});
    visit(self.mount_pitch_deg,
          ParameterInfo{"mount_pitch_deg", "deg", "-90 looks straight down, image top forward",
                        -180, 180});
    visit(self.mount_yaw_deg,
          ParameterInfo{"mount_yaw_deg", "deg", "-90 with pitch -90 puts the image top to the left",
                        -360, 360});
    visit(self.mount_x_m,
          ParameterInfo{"mount_x_m", "m", "camera forward of the body's origin, or the gimbal's",
                        -100, 100});
    visit(self.mount_y_m, ParameterInfo{"mount_y_m", "m", "camera to the right", -100, 100});
    visit(self.mount_z_m, ParameterInfo{"mount_z_m", "m", "camera down", -100, 100});
    visit(self.gimbal, ParameterInfo{"gimbal", "1",
                                     "0 fixed to the body, 1 stabilised with attitude recorded "
                                     "against the body, 2 against north, east, down",
                                     0, 2});
    visit(self.gimbal_jitter_deg,
          ParameterInfo{"gimbal_jitter_deg", "deg",
                        "one sigma of what the gimbal leaves of the motion (recorded)", 0, 45});
    visit(self.mount_error_deg,
          ParameterInfo{"mount_error_deg", "deg",
                        "the true mount is turned by this from the recorded one, about an axis "
                        "drawn by seed",
                        0, 180});
    visit(self.lever_error_m,
          ParameterInfo{"lever_error_m", "m",
                        "the true camera sits this far from its recorded place, in a direction "
                        "drawn by seed",
                        0, 100});
    visit(self.frame_rate_hz, ParameterInfo{"frame_rate_hz", "Hz", "images a second", 0.001, 1000});
    visit(self.images_in_turns,
          ParameterInfo{"images_in_turns", "1", "take images between the legs too"});
    visit(self.capture_recorded,
          ParameterInfo{"capture_recorded", "1",
                        "images carry the time of their capture, not only of their arrival"});
    visit(self.counter_recorded,
          ParameterInfo{"counter_recorded", "1", "images carry the camera's own frame count"});
    visit(self.arrival_delay_s,
          ParameterInfo{"arrival_delay_s", "s", "from capture to arrival", 0, 100});
    visit(self.arrival_jitter_s,
          ParameterInfo{"arrival_jitter_s", "s",
                        "one sigma of the delay, anew in each image; no image overtakes another", 0,
                        100});
    visit(self.arrival_two_sided,
          ParameterInfo{"arrival_two_sided", "1",
                        "jitter makes images early as often as late, else only late"});
    visit(self.arrival_drift_s,
          ParameterInfo{"arrival_drift_s", "s", "one sigma of the delay's slow wandering", 0, 100});
    visit(self.arrival_drift_correlation_s,
          ParameterInfo{"arrival_drift_correlation_s", "s",
                        "time in which the delay's wandering forgets itself", 0, 100000});
    visit(
        self.drop_share,
        ParameterInfo{"drop_share", "1",
                      "share of the images that never arrive; the counter shows the gap", 0, 0.99});
  }
};

/// What the navigation says of the truth. Errors are off by default.
struct NavigationParameters {
  double pose_rate_hz = 50.0;
  double nav_position_sigma_m = 0.0;
  double nav_attitude_sigma_deg = 0.0;
  double nav_correlation_s = 20.0;
  double nav_attitude_correlation_s = -1.0;
  double nav_height_bias_m = 0.0;
  double nav_delay_s = 0.0;
  bool nav_sigmas_recorded = true;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.pose_rate_hz, ParameterInfo{"pose_rate_hz", "Hz", "poses a second", 0.1, 1000});
    visit(self.nav_position_sigma_m,
          ParameterInfo{"nav_position_sigma_m", "m",
                        "one sigma of the recorded position, along each axis", 0, 1000});
    visit(self.nav_attitude_sigma_deg,
          ParameterInfo{"nav_attitude_sigma_deg", "deg",
                        "one sigma of the recorded attitude, about each axis", 0, 45});
    visit(self.nav_correlation_s,
          ParameterInfo{
              "nav_correlation_s", "s",
              "time in which navigation errors forget themselves; 0 makes them new in each pose", 0,
              100000});
    visit(self.nav_attitude_correlation_s,
          ParameterInfo{"nav_attitude_correlation_s", "s",
                        "the same for attitude alone; -1: nav_correlation_s", -1, 100000});
    visit(self.nav_height_bias_m,
          ParameterInfo{"nav_height_bias_m", "m",
                        "recorded heights are too large by this, as a barometer's", -1000, 1000});
    visit(self.nav_delay_s,
          ParameterInfo{"nav_delay_s", "s", "poses are stamped this much too late", -10, 10});
    visit(self.nav_sigmas_recorded,
          ParameterInfo{"nav_sigmas_recorded", "1", "poses say how uncertain they are"});
  }
};

/// What is known from outside the pictures: one anchor, and a range finder. Both off by default.
struct KnownPointParameters {
  bool anchor = false;
  double anchor_north_m = 0.0, anchor_east_m = 0.0, anchor_height_m = 0.0;
  double anchor_sigma_m = 0.1;
  double anchor_sigma_px = 0.5;
  int anchor_sightings = 5;
  double range_rate_hz = 0.0;
  double range_noise_m = 0.1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.anchor, ParameterInfo{"anchor", "1", "one point has a known place and is marked"});
    visit(self.anchor_north_m,
          ParameterInfo{"anchor_north_m", "m",
                        "the anchor north of the scene's anchor at the start", -20000, 20000});
    visit(self.anchor_east_m,
          ParameterInfo{"anchor_east_m", "m", "the anchor east of the scene's anchor at the start",
                        -20000, 20000});
    visit(self.anchor_height_m,
          ParameterInfo{"anchor_height_m", "m", "the anchor above the sea", 0, 1000});
    visit(self.anchor_sigma_m,
          ParameterInfo{"anchor_sigma_m", "m",
                        "one sigma of the anchor's recorded place, along each axis", 0, 1000});
    visit(self.anchor_sigma_px,
          ParameterInfo{"anchor_sigma_px", "px", "one sigma of a mark, along each axis", 0, 100});
    visit(self.anchor_sightings,
          ParameterInfo{"anchor_sightings", "1",
                        "in so many of the frames that see the anchor it is marked; 0: in all", 0,
                        1000000});
    visit(self.range_rate_hz,
          ParameterInfo{"range_rate_hz", "Hz",
                        "measurements a second of a range finder along the body's down axis", 0,
                        1000});
    visit(self.range_noise_m,
          ParameterInfo{"range_noise_m", "m", "one sigma of a measured range", 0, 100});
  }
};

/// All of a simulation, in numbers that describe themselves.
struct Scenario {
  int seed = 1;
  double datum_lat_deg = 78.9;
  double datum_lon_deg = 11.9;
  double datum_height_ellipsoid_m = 42.0;
  double datum_x_azimuth_deg = 0.0;
  double sea_height_ellipsoid_m = 30.0;
  double scene_north_m = 0.0;
  double scene_east_m = 0.0;
  double drift_north_m_s = 0.0;
  double drift_east_m_s = 0.0;
  SeaParameters sea;
  LensParameters lens;
  SensorParameters sensor;
  AircraftParameters aircraft;
  CameraSetup camera;
  NavigationParameters navigation;
  KnownPointParameters known_points;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.seed,
          ParameterInfo{"seed", "1",
                        "of everything but the sea's shape: gusts, noise, brightness, errors", 0,
                        2147483647});
    visit(self.datum_lat_deg,
          ParameterInfo{"datum_lat_deg", "deg", "latitude of the mission datum", -90, 90});
    visit(self.datum_lon_deg,
          ParameterInfo{"datum_lon_deg", "deg", "longitude of the mission datum", -180, 180});
    visit(self.datum_height_ellipsoid_m,
          ParameterInfo{"datum_height_ellipsoid_m", "m", "height of the mission datum above WGS-84",
                        -1000, 10000});
    visit(self.datum_x_azimuth_deg,
          ParameterInfo{"datum_x_azimuth_deg", "deg",
                        "direction of the mission frame's first axis, clockwise from north", -360,
                        360});
    visit(self.sea_height_ellipsoid_m,
          ParameterInfo{"sea_height_ellipsoid_m", "m", "height of the sea above WGS-84", -1000,
                        10000});
    visit(self.scene_north_m,
          ParameterInfo{"scene_north_m", "m",
                        "the scene's anchor north of the datum, in the datum's tangent plane",
                        -200000, 200000});
    visit(self.scene_east_m,
          ParameterInfo{"scene_east_m", "m",
                        "the scene's anchor east of the datum, in the datum's tangent plane",
                        -200000, 200000});
    visit(self.drift_north_m_s,
          ParameterInfo{
              "drift_north_m_s", "m/s",
              "motion of all ice to the north; truth is where it is when the first leg starts", -10,
              10});
    visit(self.drift_east_m_s,
          ParameterInfo{"drift_east_m_s", "m/s", "motion of all ice to the east", -10, 10});
    SeaParameters::describe(self.sea, visit);
    LensParameters::describe(self.lens, visit);
    SensorParameters::describe(self.sensor, visit);
    AircraftParameters::describe(self.aircraft, visit);
    CameraSetup::describe(self.camera, visit);
    NavigationParameters::describe(self.navigation, visit);
    KnownPointParameters::describe(self.known_points, visit);
  }
};

/// One frame as it was, exactly, at the middle of its exposure.
struct TrueFrame {
  Time captured_at;
  Rigid3<World, Camera> world_from_camera;
  Rigid3<World, Body> world_from_body;
  /// The position that the recorded poses give for this moment, less the true one, in World.
  Eigen::Vector3d navigation_error_m;
};

struct Truth {
  Sea sea;  ///< at its place, as it is at `start`
  Datum datum;
  Time start;  ///< when the first leg starts
  Eigen::Vector2d drift_north_east_m_s = Eigen::Vector2d::Zero();
  Mount mount;                    ///< as the camera sits; Flight::mount is what was recorded
  std::vector<TrueFrame> frames;  ///< in the order of Flight::frames

  /// A point of the scene at `start`, in World.
  [[nodiscard]] Point<World> world(const Eigen::Vector2d& north_east_m) const;
  /// Where a point of the scene at `start` is at another time.
  [[nodiscard]] Eigen::Vector2d drifted(const Eigen::Vector2d& north_east_m, Time time) const;
  /// Of the navigation's position, over all frames, in World: what no image can tell.
  [[nodiscard]] Eigen::Vector3d mean_navigation_error_m() const;
};

struct Simulation {
  Flight flight;
  Truth truth;
};

/// Makes the sea and flies over it. Usage for a parameter at fault.
[[nodiscard]] Result<Simulation> simulate(const Scenario& scenario);
/// Flies over a given sea, which is moved to the scenario's place; scenario.sea is not used.
[[nodiscard]] Result<Simulation> simulate(const Scenario& scenario, const Sea& sea);

/// `not_easy`: nadir, distorting lens, contrast four times the noise; the acceptance flight.
/// `not_easy_oblique`: the same, 30° from nadir. `far`: the same 40 km from the datum. `fog`:
/// thermal, ice darker, fog. `gimbal`: a stabilised fisheye. `visible`: colour, 1600x1200.
/// `laboratory`: the thesis's laboratory (4.1.1), a multirotor at 1.1 to 1.9 m over eight paper
/// patches, exact poses at 120 Hz, images at 30 Hz with rolling shutter and JPEG that arrive
/// 272 ± 54 ms later, 4 % of them never, the mount off by 2° and 5 cm. `outdoor`: an X8 at 100 m,
/// 15 m/s, in overlapping legs over ice, GNSS of 1 m over 60 s, attitude of 0.7° over 10 s, images
/// at 5 Hz that arrive about 0.26 s later, the mount off by 2° and 5 cm. In these two neither the
/// capture times, nor the errors of mount and navigation are recorded.
/// NotFound, naming these, for another name.
[[nodiscard]] Result<Scenario> scenario_preset(std::string_view name);
[[nodiscard]] std::vector<std::string_view> scenario_preset_names();

}  // namespace watersky::sim
