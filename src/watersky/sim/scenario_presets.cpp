// SPDX-License-Identifier: MIT
#include <string>

#include "watersky/sim/laboratory.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::sim {
namespace {

/// Delay, mount and navigation are all there is to find out, and nothing of them is recorded.
void tell_nothing(Scenario& s) {
  s.camera.capture_recorded = false;
  s.camera.mount_error_deg = 2.0;
  s.camera.lever_error_m = 0.05;
  s.navigation.nav_sigmas_recorded = false;
}

Scenario laboratory() {
  Scenario s;
  tell_nothing(s);
  s.datum_lat_deg = 63.4187;
  s.datum_lon_deg = 10.4017;
  s.datum_height_ellipsoid_m = s.sea_height_ellipsoid_m = 75.0;
  s.datum_x_azimuth_deg = 37.0;
  s.sea.paper_patches = true;
  s.sea.paper_azimuth_deg = s.datum_x_azimuth_deg;

  HoverParameters& hover = s.aircraft.hover;
  hover.hovers = true;
  hover.hover_azimuth_deg = s.datum_x_azimuth_deg;
  hover.hover_x_m = kPaperMiddle_m[0];
  hover.hover_y_m = kPaperMiddle_m[1];

  s.lens.width_px = 640;
  s.lens.height_px = 360;
  s.lens.focal_px = 700.0;
  s.lens.centre_right_px = 5.4;
  s.lens.centre_down_px = -3.2;
  s.lens.k1 = -0.12;
  s.lens.k2 = 0.05;
  s.lens.p1 = 0.0005;
  s.lens.p2 = -0.0003;

  s.sensor.water_counts = 60.0;
  s.sensor.contrast_counts = 130.0;
  s.sensor.noise_counts = 4.0;
  s.sensor.vignetting = 0.15;
  s.sensor.ice_texture = 0.02;
  s.sensor.water_texture = 0.05;
  s.sensor.floe_variation = 0.05;
  s.sensor.texture_cell_m = 0.005;
  s.sensor.exposure_s = 0.005;
  s.sensor.readout_s = 0.02;
  s.sensor.jpeg_quality = 70;

  s.camera.frame_rate_hz = 30.0;
  // What waits behind a late image arrives late as well, so 272 ± 54 ms come from less of delay
  // and more of jitter (measured over ten seeds).
  s.camera.arrival_delay_s = 0.24;
  s.camera.arrival_jitter_s = 0.066;
  s.camera.arrival_two_sided = true;
  s.camera.arrival_drift_s = 0.02;
  s.camera.arrival_drift_correlation_s = 20.0;
  s.camera.drop_share = 0.04;
  s.navigation.pose_rate_hz = 120.0;
  return s;
}

/// `s` has the lens of the acceptance flight.
Scenario outdoor(Scenario s) {
  tell_nothing(s);
  // The sea reaches beyond the turns, where the camera looks as well.
  s.sea.extent_north_m = 620.0;
  s.sea.extent_east_m = 420.0;
  s.aircraft.legs = 4;
  s.aircraft.leg_length_m = 300.0;
  s.aircraft.leg_spacing_m = 35.0;  // of a swath of 84 m: most of the ice is seen again
  s.aircraft.speed_m_s = 15.0;
  s.aircraft.turn_radius_m = 40.0;
  s.camera.images_in_turns = true;
  s.camera.frame_rate_hz = 5.0;
  s.camera.arrival_delay_s = 0.25;
  s.camera.arrival_jitter_s = 0.01;
  s.navigation.nav_position_sigma_m = 1.0;
  s.navigation.nav_correlation_s = 60.0;
  s.navigation.nav_attitude_sigma_deg = 0.7;
  s.navigation.nav_attitude_correlation_s = 10.0;
  return s;
}

}  // namespace

std::vector<std::string_view> scenario_preset_names() {
  return {"not_easy", "not_easy_oblique", "far",        "fog",
          "gimbal",   "visible",          "laboratory", "outdoor"};
}

Result<Scenario> scenario_preset(std::string_view name) {
  Scenario s;
  s.lens.k1 = -0.28;
  s.lens.k2 = 0.09;
  s.lens.p1 = 0.0006;
  s.lens.p2 = -0.0004;
  s.lens.k3 = -0.01;
  s.lens.centre_right_px = 4.3;
  s.lens.centre_down_px = -2.8;
  s.camera.mount_x_m = 0.3;
  s.camera.mount_z_m = 0.1;
  if (name == "not_easy") return s;
  if (name == "not_easy_oblique") {
    s.camera.mount_pitch_deg = -60.0;
    return s;
  }
  if (name == "far") {
    s.scene_north_m = 24000.0;
    s.scene_east_m = 32000.0;
    return s;
  }
  if (name == "fog") {
    s.sensor.ice_darker = true;
    s.sensor.bits = 16;
    s.sensor.water_counts = 7400.0;
    s.sensor.contrast_counts = 220.0;
    s.sensor.noise_counts = 8.0;
    s.sensor.pattern_counts = 3.0;
    s.sensor.vignetting = 0.001;
    s.sensor.fog_per_m = 0.012;
    s.camera.mount_pitch_deg = -60.0;
    return s;
  }
  if (name == "gimbal") {
    s.camera.gimbal = 2;
    s.camera.mount_pitch_deg = -70.0;
    s.lens.fisheye = true;
    s.lens.focal_px = 330.0;
    s.lens.p1 = s.lens.p2 = 0.0;
    s.lens.k1 = -0.02;
    s.lens.k2 = 0.004;
    s.lens.k3 = -0.001;
    return s;
  }
  if (name == "visible") {
    s.lens.width_px = 1600;
    s.lens.height_px = 1200;
    s.lens.focal_px = 1350.0;
    s.sensor.color = true;
    s.sensor.water_counts = 46.0;
    s.sensor.contrast_counts = 150.0;
    s.sensor.noise_counts = 3.0;
    s.sensor.vignetting = 0.25;
    s.sensor.water_texture = 0.025;
    s.sensor.readout_s = 0.02;
    s.sensor.exposure_s = 0.001;
    return s;
  }
  if (name == "laboratory") return laboratory();
  if (name == "outdoor") return outdoor(s);
  std::string known;
  for (const std::string_view preset : scenario_preset_names())
    known += (known.empty() ? "" : ", ") + std::string(preset);
  return Error{ErrorCode::NotFound,
               "no scenario is called '" + std::string(name) + "'; there are " + known};
}

}  // namespace watersky::sim
