// SPDX-License-Identifier: MIT
#include "cases.hpp"

#include <algorithm>
#include <cmath>

namespace watersky::study {

namespace {

/// Fewer and larger pixels behind the same lens.
void reduce(sim::LensParameters& lens, double share) {
  lens.width_px = static_cast<int>(std::lround(share * lens.width_px));
  lens.height_px = static_cast<int>(std::lround(share * lens.height_px));
  for (double* length_px : {&lens.focal_px, &lens.centre_right_px, &lens.centre_down_px})
    *length_px *= share;
}

/// Hovers at one height with hardly any motion: nothing tells a delay, nor a mount.
void hold_still(sim::HoverParameters& hover, double height_m, double reach_m) {
  hover.hovers = true;
  hover.hover_reach_x_m = hover.hover_reach_y_m = reach_m;
  hover.hover_lowest_m = height_m - reach_m;
  hover.hover_highest_m = height_m + reach_m;
  hover.hover_reach_yaw_deg = 1.0;
  hover.hover_least_tilt_deg = 0.2;
  hover.hover_most_tilt_deg = 0.4;
}

}  // namespace

Result<std::vector<Case>> cases(double duration_s, double share) {
  WATERSKY_TRY(sim::Scenario laboratory, sim::scenario_preset("laboratory"));
  laboratory.aircraft.hover.hover_duration_s = duration_s;
  laboratory.camera.frame_rate_hz = 10.0;  // a third of it: three times the seeds in the same time
  reduce(laboratory.lens, share);

  WATERSKY_TRY(sim::Scenario outdoor, sim::scenario_preset("outdoor"));
  reduce(outdoor.lens, share);
  // Two legs and the turn between them, which is a bulb of some 240 m.
  constexpr double kTurn_m = 240.0;
  outdoor.aircraft.legs = 2;
  outdoor.aircraft.leg_length_m =
      std::max(60.0, 0.5 * (outdoor.aircraft.speed_m_s * duration_s - kTurn_m));

  std::vector<Case> all;
  const auto add = [&all](const char* name, const char* title, const sim::Scenario& like,
                          const auto& change) {
    all.push_back({name, title, like});
    change(all.back().scenario);
  };
  const auto as_it_is = [](sim::Scenario&) {};
  const auto drop = [](sim::Scenario& s) { s.camera.drop_share = 0.3; };
  const auto err = [](sim::Scenario& s) {
    s.navigation.nav_position_sigma_m = 0.010;
    s.navigation.nav_attitude_sigma_deg = 0.7;
    s.navigation.nav_correlation_s = 2.0;
  };

  add("laboratory", "laboratory", laboratory, as_it_is);
  add("laboratory_noise", "laboratory, navigation noise of 10 mm, 0.7 deg", laboratory, err);
  add("laboratory_still", "laboratory, hovering nearly still", laboratory,
      [](sim::Scenario& s) { hold_still(s.aircraft.hover, 1.5, 0.01); });
  add("laboratory_still_noise", "laboratory, nearly still, with that noise", laboratory,
      [&](sim::Scenario& s) {
        hold_still(s.aircraft.hover, 1.5, 0.01);
        err(s);
      });
  add("laboratory_drops", "laboratory, 30 % of the frames lost", laboratory, drop);

  add("outdoor", "outdoors", outdoor, as_it_is);
  add("outdoor_straight", "outdoors, straight at one speed, no gusts", outdoor,
      [duration_s](sim::Scenario& s) {
        sim::AircraftParameters& a = s.aircraft;
        a.legs = 1;
        a.leg_length_m = a.speed_m_s * duration_s;
        a.gust_roll_deg = a.gust_pitch_deg = a.gust_yaw_deg = 0.0;
        a.gust_height_m = a.gust_aside_m = 0.0;
      });
  add("outdoor_still", "outdoors, hovering nearly still", outdoor, [duration_s](sim::Scenario& s) {
    hold_still(s.aircraft.hover, s.aircraft.height_m, 0.3);
    s.aircraft.hover.hover_duration_s = duration_s;
  });
  add("outdoor_open_water", "outdoors, no ice", outdoor, [](sim::Scenario& s) {
    s.sea.concentration = 0.0;
    s.sea.isolated_count = s.sea.lead_count = 0;
  });
  add("outdoor_drops", "outdoors, 30 % of the frames lost", outdoor, drop);
  return all;
}

}  // namespace watersky::study
