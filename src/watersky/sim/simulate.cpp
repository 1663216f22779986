// SPDX-License-Identifier: MIT
#include "watersky/sim/simulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "watersky/camera/reduced_image.hpp"
#include "watersky/sim/detail/image_link.hpp"
#include "watersky/sim/detail/known_points.hpp"
#include "watersky/sim/detail/motion.hpp"
#include "watersky/sim/detail/random.hpp"

namespace watersky::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
/// 2026-04-01T12:00:00Z: a fixed day, so that a scenario gives the same bytes on any day.
constexpr std::int64_t kStart_s = 1775044800;
/// Poses before the first frame and after the last, so that all are bracketed.
constexpr double kMargin_s = 2.0;

struct DatumAxes {
  explicit DatumAxes(const Datum& datum)
      : axes(north_east_down(datum.origin()) * turned(datum.x_azimuth().radians(), 0.0, 0.0)),
        origin(earth_centred(datum.origin())) {}
  Eigen::Matrix3d axes;
  Eigen::Vector3d origin;

  template <Frame From>
  [[nodiscard]] Rigid3<World, From> world_from(const EarthPose& pose) const {
    return {Eigen::Quaterniond(Eigen::Matrix3d(axes.transpose() * pose.rotation)),
            Point<World>{axes.transpose() * (pose.origin_m - origin)}};
  }
};

Time at_second(double t_s) { return Time(std::chrono::seconds(kStart_s)) + seconds(t_s); }

Result<CameraModel> camera_model(const LensParameters& p) {
  const Lens lens(p);
  Eigen::Matrix3d matrix;
  matrix << p.focal_px, 0, lens.u0(), 0, p.focal_px, lens.v0(), 0, 0, 1;
  std::vector<double> distortion;
  if (p.fisheye) {
    distortion = {p.k1, p.k2, p.k3, p.k4};
  } else if (p.k4 != 0.0 || p.k5 != 0.0 || p.k6 != 0.0) {
    distortion = {p.k1, p.k2, p.p1, p.p2, p.k3, p.k4, p.k5, p.k6};
  } else {
    distortion = {p.k1, p.k2, p.p1, p.p2, p.k3};
  }
  return CameraModel::make(p.fisheye ? LensModel::Fisheye : LensModel::Pinhole, p.width_px,
                           p.height_px, matrix, distortion);
}

/// What all loaders of a flight share.
struct Studio {
  Renderer renderer;
  Motion motion;
};

ImageLoader loader(std::shared_ptr<const Studio> studio, double t_s, std::uint64_t frame) {
  return [studio = std::move(studio), t_s, frame](const ImageRequest& request) -> Result<cv::Mat> {
    const int reduction = request.reduction;
    if (reduction != 1 && reduction != 2 && reduction != 4 && reduction != 8)
      return Error{ErrorCode::InvalidInput,
                   "images are reduced by 1, 2, 4 or 8, not " + std::to_string(reduction)};
    cv::Mat image = studio->renderer.image(
        [&](double t) { return studio->motion.camera_in_scene(t); }, t_s, frame);
    if (!request.color && image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
    return reduction > 1 ? reduced_by(image, reduction) : image;
  };
}

Result<Trajectory> recorded_poses(const Scenario& scenario, const Motion& motion,
                                  const DatumAxes& datum, double from_s, double to_s) {
  const NavigationParameters& nav = scenario.navigation;
  Random random(static_cast<std::uint64_t>(scenario.seed), Stream::Navigation);
  const double step_s = 1.0 / nav.pose_rate_hz;
  const double attitude_correlation_s =
      nav.nav_attitude_correlation_s < 0.0 ? nav.nav_correlation_s : nav.nav_attitude_correlation_s;
  std::array<Wandering, 6> errors{Wandering(random, step_s, nav.nav_correlation_s),
                                  Wandering(random, step_s, nav.nav_correlation_s),
                                  Wandering(random, step_s, nav.nav_correlation_s),
                                  Wandering(random, step_s, attitude_correlation_s),
                                  Wandering(random, step_s, attitude_correlation_s),
                                  Wandering(random, step_s, attitude_correlation_s)};
  const double attitude_sigma = nav.nav_attitude_sigma_deg * kDegree;
  std::vector<StampedPose> poses;
  const auto count = static_cast<std::size_t>(std::ceil((to_s - from_s) / step_s)) + 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = from_s + static_cast<double>(i) * step_s;
    StampedPose pose;
    pose.time = at_second(t + nav.nav_delay_s);
    EarthPose body = motion.body(t);
    if (nav.nav_height_bias_m != 0.0)
      body.origin_m -= nav.nav_height_bias_m * north_east_down(geodetic_of(body.origin_m)).col(2);
    pose.world_from_body = datum.world_from<Body>(body);
    if (nav.nav_position_sigma_m > 0.0 || attitude_sigma > 0.0) {
      Eigen::Vector3d place, turn;
      for (int k = 0; k < 3; ++k) {
        place[k] = nav.nav_position_sigma_m * errors[static_cast<std::size_t>(k)].next();
        turn[k] = attitude_sigma * errors[static_cast<std::size_t>(k) + 3].next();
      }
      pose.world_from_body =
          Rigid3<World, Body>(pose.world_from_body.rotation() *
                                  Eigen::Quaterniond(turned(turn.z(), turn.y(), turn.x())),
                              Point<World>{pose.world_from_body.origin().v + place});
      if (nav.nav_sigmas_recorded)
        pose.sigma = PoseSigma{Eigen::Vector3d::Constant(nav.nav_position_sigma_m),
                               Eigen::Vector3d::Constant(attitude_sigma)};
    }
    poses.push_back(pose);
  }
  return Trajectory::make(std::move(poses));
}

Result<RotationTrack> recorded_gimbal(const Scenario& scenario, const Motion& motion, double from_s,
                                      double to_s) {
  std::vector<StampedRotation> rotations;
  const double step_s = 1.0 / scenario.navigation.pose_rate_hz;
  const auto count = static_cast<std::size_t>(std::ceil((to_s - from_s) / step_s)) + 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = from_s + static_cast<double>(i) * step_s;
    rotations.push_back({at_second(t), Eigen::Quaterniond(motion.recorded_gimbal(t))});
  }
  return RotationTrack::make(std::move(rotations));
}

}  // namespace

Point<World> Truth::world(const Eigen::Vector2d& north_east_m) const {
  const DatumAxes axes(datum);
  const Eigen::Vector3d p = SeaSurface(sea.anchor()).above(north_east_m.x(), north_east_m.y(), 0.0);
  return {axes.axes.transpose() * (p - axes.origin)};
}

Eigen::Vector2d Truth::drifted(const Eigen::Vector2d& north_east_m, Time time) const {
  return north_east_m + to_seconds(time - start) * drift_north_east_m_s;
}

Eigen::Vector3d Truth::mean_navigation_error_m() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TrueFrame& frame : frames) sum += frame.navigation_error_m;
  return frames.empty() ? sum : sum / static_cast<double>(frames.size());
}

Result<Simulation> simulate(const Scenario& scenario) {
  WATERSKY_TRY(const Sea sea, make_sea(scenario.sea));
  return simulate(scenario, sea);
}

Result<Simulation> simulate(const Scenario& scenario, const Sea& unplaced) {
  WATERSKY_CHECK(validate(scenario));
  const Geodetic datum_place{Angle::degrees(scenario.datum_lat_deg),
                             Angle::degrees(scenario.datum_lon_deg),
                             scenario.datum_height_ellipsoid_m};
  const Datum world(datum_place, Angle::degrees(scenario.datum_x_azimuth_deg));
  const DatumAxes datum(world);
  Geodetic anchor = geodetic_of(
      datum.origin + north_east_down(datum_place) *
                         Eigen::Vector3d(scenario.scene_north_m, scenario.scene_east_m, 0.0));
  anchor.height_ellipsoid_m = scenario.sea_height_ellipsoid_m;
  const Sea sea = unplaced.at(anchor);

  const auto seed = static_cast<std::uint64_t>(scenario.seed);
  const Eigen::Vector2d drift(scenario.drift_north_m_s, scenario.drift_east_m_s);
  WATERSKY_TRY(
      const Aircraft aircraft,
      Aircraft::make(scenario.aircraft, mix(seed, static_cast<std::uint64_t>(Stream::Gusts))));
  WATERSKY_TRY(Renderer renderer, Renderer::make(sea, scenario.lens, scenario.sensor, seed, drift));
  WATERSKY_TRY(CameraModel model, camera_model(scenario.lens));
  const auto studio = std::make_shared<const Studio>(
      Studio{std::move(renderer), Motion(scenario, aircraft, anchor)});
  const Motion& motion = studio->motion;

  Flight flight("simulation", world, std::move(model));
  Truth truth{sea, flight.datum, at_second(0.0), drift, {}, {}};
  truth.mount.rotation = Eigen::Quaterniond(motion.mount());
  truth.mount.lever_arm_m = motion.lever_arm_m();
  flight.calibration = {"the simulated camera's own numbers", 0.0};
  flight.mount.rotation = Eigen::Quaterniond(nominal_mount(scenario.camera));
  flight.mount.lever_arm_m = {scenario.camera.mount_x_m, scenario.camera.mount_y_m,
                              scenario.camera.mount_z_m};
  flight.readout_s = scenario.sensor.readout_s;
  const double sea_height = scenario.sea_height_ellipsoid_m;
  char text[64];
  std::snprintf(text, sizeof text, "%.3f m above the ellipsoid, as simulated", sea_height);
  flight.sea_level =
      SeaLevel{[sea_height](const Geodetic&) { return Result<double>(sea_height); }, text, 0.0};

  const CameraSetup& camera = scenario.camera;
  Random clock(seed, Stream::Clock);
  ImageLink link(camera, seed);
  const double period_s = 1.0 / camera.frame_rate_hz, duration_s = aircraft.duration_s();
  double t = clock.uniform(0.0, std::min(period_s, 0.5 * duration_s));
  for (std::uint64_t counter = 0; t <= duration_s; t += period_s, ++counter) {
    const ImageLink::Passage passage = link.pass(t, clock.normal());
    if (passage.lost || (!camera.images_in_turns && !aircraft.at(t).on_leg)) continue;
    ImageFrame frame;
    char name[32];
    std::snprintf(name, sizeof name, "frame_%05u.png", static_cast<unsigned>(counter));
    frame.name = name;
    const Time captured = at_second(t);
    if (camera.capture_recorded) frame.captured_at = captured;
    frame.received_at = captured + seconds(passage.delay_s);
    if (camera.counter_recorded) frame.counter = counter;
    // The time as it is stored, to the nanosecond, is also the time at which it is rendered.
    const double stored_s = to_seconds(captured - truth.start);
    frame.load = loader(studio, stored_s, counter);
    flight.frames.push_back(std::move(frame));
    truth.frames.push_back({captured, datum.world_from<Camera>(motion.camera(stored_s)),
                            datum.world_from<Body>(motion.body(stored_s)),
                            Eigen::Vector3d::Zero()});
  }
  if (flight.frames.empty())
    return Error{ErrorCode::Usage,
                 "the flight is too short for an image; raise frame_rate_hz or "
                 "leg_length_m"};

  // Poses do not fall on the frames: interpolation is part of what is simulated.
  const double from_s = -kMargin_s - clock.uniform(0.0, 1.0 / scenario.navigation.pose_rate_hz);
  WATERSKY_TRY(flight.trajectory,
               recorded_poses(scenario, motion, datum, from_s, duration_s + kMargin_s));
  for (TrueFrame& frame : truth.frames) {
    const auto recorded = flight.trajectory.at(frame.captured_at, seconds(kMargin_s));
    // A delay of the navigation longer than the margin leaves the first frames without a pose.
    if (recorded)
      frame.navigation_error_m =
          recorded->world_from_body.origin().v - frame.world_from_body.origin().v;
  }
  if (scenario.known_points.anchor) {
    std::vector<std::pair<std::string, double>> frames;
    for (std::size_t i = 0; i < flight.frames.size(); ++i)
      frames.emplace_back(flight.frames[i].name,
                          to_seconds(truth.frames[i].captured_at - truth.start));
    flight.anchors = {recorded_anchor(scenario, motion, anchor, frames, truth.start)};
  }
  if (scenario.known_points.range_rate_hz > 0.0)
    flight.ranges =
        recorded_ranges(scenario, motion, anchor, truth.start, -0.5 * kMargin_s, duration_s);
  if (camera.gimbal != 0) {
    flight.gimbal_reference =
        camera.gimbal == 1 ? GimbalReference::Body : GimbalReference::NorthEastDown;
    WATERSKY_TRY(flight.gimbal, recorded_gimbal(scenario, motion, from_s, duration_s + kMargin_s));
  }
  return Simulation{std::move(flight), std::move(truth)};
}

}  // namespace watersky::sim
