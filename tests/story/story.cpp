// SPDX-License-Identifier: MIT
#include "story.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace watersky::story {
namespace {

template <class T>
T told(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(result).value();
}

}  // namespace

sim::Sea sea(std::string_view drawing, const Drawing& scale) {
  return told(sim::Sea::from_ascii(drawing, scale.cell_m, scale.isolation_gap_m));
}

sim::Simulation simulation(const sim::Sea& sea, const Survey& survey) {
  sim::Scenario s;
  s.seed = survey.seed;
  s.scene_north_m = survey.scene_north_m;
  s.scene_east_m = survey.scene_east_m;
  s.drift_north_m_s = survey.drift_north_m_s;
  s.drift_east_m_s = survey.drift_east_m_s;
  s.lens.width_px = 320;
  s.lens.height_px = 256;
  s.lens.focal_px = 300.0;
  s.lens.k1 = -0.2;
  s.lens.k2 = 0.05;
  s.sensor.contrast_counts = 60.0;
  s.sensor.ice_darker = survey.ice_darker;
  s.camera.mount_pitch_deg = -90.0 + survey.tilt_deg;
  s.camera.frame_rate_hz = 2.0;

  // The whole sea and half a swath around it, so that its edges are seen too; neighbouring legs
  // share a third of their swath.
  const double swath_m = survey.height_m * s.lens.width_px / s.lens.focal_px;
  const double azimuth = survey.azimuth_deg * 3.14159265358979323846 / 180.0;
  const double n = sea.extent().north_m, e = sea.extent().east_m;
  const double along_m = std::abs(n * std::cos(azimuth)) + std::abs(e * std::sin(azimuth));
  const double across_m = std::abs(n * std::sin(azimuth)) + std::abs(e * std::cos(azimuth));
  s.aircraft.height_m = survey.height_m;
  s.aircraft.leg_azimuth_deg = survey.azimuth_deg;
  s.aircraft.leg_spacing_m = 0.66 * swath_m;
  s.aircraft.legs = 1 + static_cast<int>(std::ceil(across_m / s.aircraft.leg_spacing_m));
  const double forward_m =
      survey.height_m * std::tan(survey.tilt_deg * 3.14159265358979323846 / 180.0);
  s.aircraft.leg_length_m = along_m + 2.0 * forward_m + 0.5 * swath_m;
  return told(sim::simulate(s, sea));
}

Flight survey(const sim::Sea& sea, const Survey& survey) {
  return std::move(simulation(sea, survey).flight);
}

MappingOptions usual_options() {
  MappingOptions options;
  options.parameters.map.cell_m = 0.5;
  options.parameters.mosaic = false;
  return options;
}

Result<MapRun> map(const Flight& flight, const MappingOptions& options) {
  return map_flight(flight, options);
}

double p_ice(const MapRun& run, const sim::Truth& truth, double north_m, double east_m) {
  const Geodetic place = truth.sea.geodetic({north_m, east_m});
  const Eigen::Vector2d grid =
      run.reference.grid(told(run.reference.projection.forward(place.latitude, place.longitude)));
  const CellBox cell{static_cast<int>(std::lround(grid.x())),
                     static_cast<int>(std::lround(grid.y())), 1, 1};
  return run.map.probability(cell).at<float>(0, 0);
}

}  // namespace watersky::story
