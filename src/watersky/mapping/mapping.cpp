// SPDX-License-Identifier: MIT
#include "watersky/mapping/mapping.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <future>
#include <map>
#include <opencv2/imgproc.hpp>

#include "watersky/geo/rotation.hpp"
#include "watersky/mapping/detail/frame_mask.hpp"
#include "watersky/mapping/detail/frame_watch.hpp"
#include "watersky/vision/duplicates.hpp"
#include "watersky/vision/mask.hpp"
#include "watersky/vision/sensor_correction.hpp"

namespace watersky {

namespace {

/// A frame whose pose is known.
struct LocatedFrame {
  const ImageFrame* frame = nullptr;
  CameraPose pose;
};

/// A frame whose view of the grid is worked out: when its turn comes, so that a long flight costs
/// no more memory than a short one.
struct PlannedFrame {
  const ImageFrame* frame = nullptr;
  CameraPose pose;
  SeaView view;
  GridView grid;
  int reduction = 1;
};

/// A frame's pixels, ready to be laid into the map.
struct PreparedFrame {
  cv::Mat image;     ///< 8 bit, for the mosaic; empty when none is wanted
  cv::Mat evidence;  ///< CV_32F log-odds minus the prior's; NaN: not known
  CameraModel camera;
  double ice_fraction = 0.0;
  bool known = false;             ///< whether anything in it could be told
  detail::FrameWatch::Seen seen;  ///< to tell what the camera did
};

/// A frame on its way into the map.
struct ReadyFrame {
  PlannedFrame planned;
  PreparedFrame prepared;
};

constexpr int kMostReduction = 8;  ///< of libjpeg

/// The strongest reduction while decoding that still leaves a cell more than one pixel: then
/// what a cell shows is decided by its own pixels, wherever they fall.
int choose_reduction(double pixels_per_cell) {
  constexpr double kLeast = 1.25;
  int reduction = 1;
  while (reduction < kMostReduction && pixels_per_cell / (2 * reduction) >= kLeast) reduction *= 2;
  return reduction;
}

Result<std::pair<cv::Mat, CameraModel>> load(const PlannedFrame& planned, const CameraModel& camera,
                                             bool color) {
  WATERSKY_TRY(const cv::Mat image,
               planned.frame->load({.color = color, .reduction = planned.reduction}));
  // A format that cannot be reduced while decoding comes in full size.
  const CameraModel reduced = camera.reduced_by(planned.reduction);
  for (const CameraModel& model : {reduced, camera})
    if (image.cols == model.width_px() && image.rows == model.height_px())
      return std::pair(image, model);
  return Error{ErrorCode::InvalidInput, "its image does not have the calibration's " +
                                            std::to_string(camera.width_px()) + "x" +
                                            std::to_string(camera.height_px()) +
                                            " pixels; give the calibration of this camera"};
}

/// What 16-bit counts are shown as black and white: one range for a flight, or its frames would
/// differ where their edges meet.
struct DisplayRange {
  float low = std::numeric_limits<float>::infinity();
  float high = -std::numeric_limits<float>::infinity();
};

/// Widens a range to hold the middle 98 % of an image.
void widen(DisplayRange& range, const cv::Mat& image) {
  if (image.depth() == CV_8U) return;
  std::vector<float> sample;
  const int step =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(image.total()) / 10000)));
  cv::Mat values;
  image.reshape(1).convertTo(values, CV_32F);
  for (int v = 0; v < values.rows; v += step)
    for (int u = 0; u < values.cols; u += step) sample.push_back(values.at<float>(v, u));
  std::sort(sample.begin(), sample.end());
  range.low = std::min(range.low, sample[sample.size() / 100]);
  range.high = std::max(range.high, sample[sample.size() - 1 - sample.size() / 100]);
}

cv::Mat displayable(const cv::Mat& image, const DisplayRange& range) {
  if (image.depth() == CV_8U) return image;
  const double scale = range.high > range.low ? 255.0 / (range.high - range.low) : 1.0;
  cv::Mat out;
  image.convertTo(out, CV_8U, scale, -scale * range.low);
  return out;
}

/// log-odds of P(ice) minus the prior's; NaN stays NaN.
cv::Mat to_evidence(const cv::Mat& p_ice, double prior, double& ice_fraction, bool& any_known) {
  cv::Mat out(p_ice.size(), CV_32F);
  const auto prior_log_odds = static_cast<float>(log_odds(prior));
  // Segmenters that classify return two values only: remember the last two conversions.
  std::array<std::pair<float, float>, 2> remembered{{{-1.0F, 0.0F}, {-2.0F, 0.0F}}};
  std::size_t ice = 0, known = 0;
  for (int v = 0; v < p_ice.rows; ++v) {
    const float* p = p_ice.ptr<float>(v);
    float* l = out.ptr<float>(v);
    for (int u = 0; u < p_ice.cols; ++u) {
      if (p[u] != remembered[0].first) {
        std::swap(remembered[0], remembered[1]);
        if (p[u] != remembered[0].first) {
          const double clamped = std::clamp(static_cast<double>(p[u]), 1e-6, 1 - 1e-6);
          remembered[0] = {p[u], std::isnan(p[u])
                                     ? p[u]
                                     : static_cast<float>(log_odds(clamped)) - prior_log_odds};
        }
      }
      l[u] = remembered[0].second;
      known += p[u] == p[u];
      ice += p[u] > 0.5F;
    }
  }
  any_known = known > 0;
  ice_fraction = known == 0 ? 0.0 : static_cast<double>(ice) / static_cast<double>(known);
  return out;
}

/// Gaussian softening that keeps unknown pixels unknown and takes nothing from them.
void soften(cv::Mat& evidence, double sigma_px) {
  if (!(sigma_px > 0.05)) return;
  // cv::compare says NaN == NaN of a matrix with itself, so the mask is made by hand.
  cv::Mat unknown(evidence.size(), CV_8U);
  std::transform(evidence.begin<float>(), evidence.end<float>(), unknown.begin<uchar>(),
                 [](float l) { return std::isnan(l) ? uchar{255} : uchar{0}; });
  evidence.setTo(0.0, unknown);
  cv::GaussianBlur(evidence, evidence, {}, sigma_px);
  evidence.setTo(std::numeric_limits<float>::quiet_NaN(), unknown);
}

Result<MapReference> choose_reference(const Flight& flight, const std::vector<LocatedFrame>& frames,
                                      const MappingOptions& options) {
  // The middle of the flight decides, so that its first frame, perhaps over the ship, does not.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const LocatedFrame& frame : frames) sum += frame.pose.world_from_camera.origin().v;
  const Geodetic middle =
      flight.datum.geodetic(Point<World>{sum / static_cast<double>(frames.size())});
  auto projection = options.projection ? Projection::from_text(*options.projection)
                                       : Projection::for_place(middle);
  if (!projection) return projection.error();
  WATERSKY_TRY(const Eigen::Vector2d en, projection->forward(middle.latitude, middle.longitude));
  // A whole number of tiles from the projection's origin: maps of one cell size and projection
  // then share their tiles, whatever flight made them.
  const double tile_m = kTileCells * options.parameters.map.cell_m;
  return MapReference{*projection, std::floor(en.x() / tile_m) * tile_m,
                      std::ceil(en.y() / tile_m) * tile_m, options.parameters.map.cell_m};
}

std::string commonest(const std::vector<LeftOut>& left_out) {
  std::map<std::string, int> count;
  for (const LeftOut& l : left_out) ++count[l.reason];
  const auto most = std::max_element(
      count.begin(), count.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most->first;
}

std::string describe_mount(const Flight& flight) {
  const YawPitchRoll angles =
      yaw_pitch_roll(flight.mount.rotation * forward_right_down_from_camera().conjugate());
  char text[120];
  std::snprintf(text, sizeof text, "roll %.2f°, pitch %.2f°, yaw %.2f° on the %s%s",
                angles.roll.degrees(), angles.pitch.degrees(), angles.yaw.degrees(),
                flight.gimbal_reference ? "gimbal" : "body",
                flight.mount.assumed ? ", assumed" : "");
  return text;
}

/// How uncertain the place of a point of the sea is by a camera's covariance: cells².
PositionCovariance place_covariance(const CameraPose& pose, const Eigen::Matrix2d& shared_m2,
                                    const GridView& grid) {
  const Eigen::Matrix2d cells_from_m = grid.sea_from_grid.topLeftCorner<2, 2>().inverse();
  return [&pose, shared_m2, &grid, cells_from_m](const Eigen::Vector2d& at) -> Eigen::Matrix2d {
    const Eigen::Vector2d place = (grid.sea_from_grid * at.homogeneous()).head<2>();
    const Eigen::Vector3d& camera = pose.sea_from_camera.origin().v;
    const Eigen::Vector3d ray(place.x() - camera.x(), place.y() - camera.y(), -camera.z());
    // A camera moved by dp and turned by dφ: the ray's foot moves by dp + dφ × ray, slid along the
    // ray back to the sea.
    Eigen::Matrix<double, 3, 6> moved;
    moved << Eigen::Matrix3d::Identity(), -skew(ray);
    Eigen::Matrix<double, 2, 3> to_sea;
    to_sea << 1, 0, -ray.x() / ray.z(), 0, 1, -ray.y() / ray.z();
    const Eigen::Matrix<double, 2, 6> by_pose = to_sea * moved;
    const Eigen::Matrix2d on_sea = by_pose * *pose.covariance * by_pose.transpose() + shared_m2;
    return cells_from_m * on_sea * cells_from_m.transpose();
  };
}

class FlightMapper {
 public:
  FlightMapper(const Flight& flight, const MappingOptions& options, const Progress& progress,
               Segmenter& segmenter)
      : flight_(flight), options_(options), progress_(progress), segmenter_(segmenter) {}

  Result<MapRun> run();

 private:
  [[nodiscard]] std::vector<LocatedFrame> locate(std::vector<LeftOut>& left_out) const;
  [[nodiscard]] Result<PlannedFrame> plan(const LocatedFrame& located,
                                          const MapReference& reference) const;
  [[nodiscard]] Status prepare_masks(const MapReference& reference);
  void observe(const std::vector<LocatedFrame>& frames, const MapReference& reference);
  [[nodiscard]] Result<std::pair<cv::Mat, CameraModel>> loaded(const PlannedFrame& planned) const;
  /// CV_8U, or empty where all of the frame may be used.
  [[nodiscard]] cv::Mat valid(const PlannedFrame& planned, const CameraModel& camera) const;
  [[nodiscard]] Result<PreparedFrame> prepare(const PlannedFrame& planned) const;
  [[nodiscard]] Result<ReadyFrame> make_ready(const LocatedFrame& located,
                                              const MapReference& reference) const;
  /// The reason where it could not be done.
  [[nodiscard]] Status integrate(const ReadyFrame& ready, MapRun& run, std::size_t& untold);

  const Flight& flight_;
  const MappingOptions& options_;
  const Progress& progress_;
  Segmenter& segmenter_;
  DisplayRange display_;
  SensorCorrection sensor_;
  detail::FrameWatch watch_;
  detail::ExcludedAreas excluded_;
  std::map<int, cv::Mat> camera_masks_;  ///< by the width of the image
  /// Frames that observe() decoded and prepare() will ask for again.
  std::map<const ImageFrame*, std::pair<cv::Mat, CameraModel>> decoded_;
};

std::vector<LocatedFrame> FlightMapper::locate(std::vector<LeftOut>& left_out) const {
  std::vector<LocatedFrame> located;
  for (const ImageFrame& frame : flight_.frames) {
    auto pose = flight_.camera_pose(frame, seconds(options_.parameters.max_pose_gap_s));
    if (pose) {
      located.push_back({&frame, *pose});
    } else {
      left_out.push_back({frame.name, pose.error().message});
    }
  }
  // Evidence is clamped, so the order counts: that of capture, whatever the recording's.
  std::stable_sort(
      located.begin(), located.end(),
      [](const LocatedFrame& a, const LocatedFrame& b) { return a.pose.time < b.pose.time; });
  return located;
}

Result<PlannedFrame> FlightMapper::plan(const LocatedFrame& located,
                                        const MapReference& reference) const {
  const ViewLimits limits{Angle::degrees(options_.parameters.min_grazing_deg)};
  const auto& [frame, pose] = located;
  WATERSKY_TRY(const Eigen::Matrix3d sea_from_grid, reference.sea_from_grid(pose.sea_below));
  WATERSKY_TRY(SeaView view, SeaView::make(flight_.camera, pose.sea_from_camera, limits));
  WATERSKY_TRY(GridView grid, make_grid_view(view, sea_from_grid, pose.shutter));
  const int reduction = choose_reduction(grid.pixels_per_cell);
  return PlannedFrame{frame, pose, std::move(view), std::move(grid), reduction};
}

Status FlightMapper::prepare_masks(const MapReference& reference) {
  WATERSKY_TRY(excluded_, detail::ExcludedAreas::make(options_.excluded, reference));
  if (options_.camera_mask.empty()) return {};
  const auto add = [this](const CameraModel& camera) -> Status {
    cv::Mat& mask = camera_masks_[camera.width_px()];
    if (!mask.empty()) return {};
    auto made = valid_from_mask(options_.camera_mask, {camera.width_px(), camera.height_px()});
    if (!made) return made.error();
    mask = *std::move(made);
    return {};
  };
  for (int reduction = 1; reduction <= kMostReduction; reduction *= 2)
    WATERSKY_CHECK(add(flight_.camera.reduced_by(reduction)));
  return {};
}

cv::Mat FlightMapper::valid(const PlannedFrame& planned, const CameraModel& camera) const {
  const auto mask = camera_masks_.find(camera.width_px());
  return both_valid(mask == camera_masks_.end() ? cv::Mat() : mask->second,
                    excluded_.valid(planned.view, planned.grid, camera));
}

Result<std::pair<cv::Mat, CameraModel>> FlightMapper::loaded(const PlannedFrame& planned) const {
  if (const auto found = decoded_.find(planned.frame); found != decoded_.end())
    return found->second;
  return load(planned, flight_.camera, options_.parameters.mosaic);
}

void FlightMapper::observe(const std::vector<LocatedFrame>& frames, const MapReference& reference) {
  // Enough to know the flight's ice and water by; more would only decode twice.
  constexpr std::size_t kObserved = 16;
  constexpr std::size_t kCacheBytes = std::size_t{256} << 20;
  std::size_t cached = 0;
  const std::size_t count = std::min(kObserved, frames.size());
  const auto each = [&](const auto& body) {
    for (std::size_t i = 0; i < count; ++i) {
      report(progress_, "looking", i, count);
      // What cannot be planned or loaded make_ready() meets again and reports.
      const auto planned = plan(frames[i * frames.size() / count], reference);
      if (!planned) continue;
      if (auto image = loaded(*planned)) body(*planned, *image, valid(*planned, image->second));
    }
  };
  if (options_.parameters.correct_sensor) {
    each([&](const PlannedFrame& planned, std::pair<cv::Mat, CameraModel>& image,
             const cv::Mat& valid) {
      sensor_.observe(image.first, valid);
      const std::size_t bytes = image.first.total() * image.first.elemSize();
      if (cached + bytes > kCacheBytes || decoded_.contains(planned.frame)) return;
      cached += bytes;
      decoded_.emplace(planned.frame, image);
    });
    sensor_.learn();
  }
  each([&](const PlannedFrame& planned, std::pair<cv::Mat, CameraModel>& image,
           const cv::Mat& valid) {
    const cv::Mat corrected = sensor_.correct(image.first);
    segmenter_.observe(corrected, valid);
    widen(display_, corrected);
    const std::size_t bytes = image.first.total() * image.first.elemSize();
    if (cached + bytes > kCacheBytes || decoded_.contains(planned.frame)) return;
    cached += bytes;
    decoded_.emplace(planned.frame, std::move(image));
  });
}

Result<PreparedFrame> FlightMapper::prepare(const PlannedFrame& planned) const {
  const MappingParameters& p = options_.parameters;
  WATERSKY_TRY(const auto decoded, loaded(planned));
  const auto& [raw, camera] = decoded;
  const cv::Mat valid = this->valid(planned, camera);
  if (!valid.empty() && cv::countNonZero(valid) == 0)
    return Error{ErrorCode::OutOfRange, "the masks leave nothing of it"};
  const cv::Mat image = sensor_.correct(raw);
  WATERSKY_TRY(const cv::Mat p_ice, segmenter_.segment(image, valid));
  PreparedFrame prepared{.image = {}, .evidence = {}, .camera = camera, .seen = {}};
  // As it came: what the camera did must not be told from what we made of it.
  prepared.seen = detail::FrameWatch::seen(raw, p.skip_duplicates, p.correct_sensor);
  prepared.evidence = to_evidence(p_ice, p.map.prior, prepared.ice_fraction, prepared.known);
  soften(prepared.evidence,
         p.sigma_m / planned.view.gsd_m() * camera.focal_px() / flight_.camera.focal_px());
  if (p.mosaic) prepared.image = displayable(image, display_);
  return prepared;
}

Result<ReadyFrame> FlightMapper::make_ready(const LocatedFrame& located,
                                            const MapReference& reference) const {
  WATERSKY_TRY(PlannedFrame planned, plan(located, reference));
  WATERSKY_TRY(PreparedFrame prepared, prepare(planned));
  return ReadyFrame{std::move(planned), std::move(prepared)};
}

Status FlightMapper::integrate(const ReadyFrame& ready, MapRun& run, std::size_t& untold) {
  const auto& [planned, prepared] = ready;
  // Here and not while preparing: which frame came before must not depend on threads.
  if (const auto reason = watch_.judge(planned.frame->name, planned.pose.time, planned.grid,
                                       prepared.camera, prepared.seen))
    return Error{ErrorCode::InvalidInput, *reason};
  const GridView view = planned.grid.with(prepared.camera);
  WATERSKY_TRY(const std::size_t touched,
               run.map.update(view, prepared.evidence, planned.pose.time));
  if (planned.pose.covariance && options_.parameters.soften_by_pose && touched > 0)
    run.uncertainty.add(planned.grid,
                        place_covariance(planned.pose, flight_.shared_covariance_m2, planned.grid));
  // A frame in fog is where it is, and belongs in the mosaic; it only says nothing of the ice.
  untold += prepared.known ? 0 : 1;
  if (touched == 0 && prepared.known)
    return Error{ErrorCode::OutOfRange,
                 "it fills no cell of the map: its footprint is smaller than a cell"};
  if (!prepared.image.empty())
    if (const Status s = run.mosaic.add(view, prepared.image); !s)
      run.notes.push_back(planned.frame->name +
                          " is in the map but not in the mosaic: " + s.error().message);

  UsedFrame used{
      .file = planned.frame->name,
      .time = planned.pose.time,
      .camera = planned.pose.camera,
      .optical_axis = planned.pose.sea_from_camera.rotation() * Eigen::Vector3d::UnitZ()};
  used.footprint_easting_northing_m.reserve(planned.grid.footprint.size());
  for (const Eigen::Vector2d& corner : planned.grid.footprint)
    used.footprint_easting_northing_m.push_back(
        run.reference.easting_northing_m(corner.x(), corner.y()));
  used.gsd_m = planned.view.gsd_m();
  used.height_above_sea_m = planned.view.height_m();
  used.ice_fraction = prepared.ice_fraction;
  used.cut_by_grazing_limit = planned.view.cut_by_grazing_limit();
  run.used.push_back(std::move(used));
  return {};
}

Result<MapRun> FlightMapper::run() {
  const auto started = std::chrono::steady_clock::now();
  if (!flight_.sea_level)
    return Error{ErrorCode::NotFound,
                 "the height of the sea is not known; give it with --sea-level"};

  const std::size_t total = flight_.frames.size() + flight_.left_out.size();
  std::vector<LeftOut> left_out = flight_.left_out;
  const std::vector<LocatedFrame> located = locate(left_out);
  const auto none = [&](const std::vector<LeftOut>& reasons) {
    return Error{ErrorCode::OutOfRange,
                 "none of " + std::to_string(total) + " frames could be used" +
                     (reasons.empty() ? "" : "; most often: " + commonest(reasons))};
  };
  if (located.empty()) return none(left_out);

  WATERSKY_TRY(MapReference reference, choose_reference(flight_, located, options_));
  WATERSKY_TRY(IceMap map, IceMap::make(options_.parameters.map));
  MapRun run{.flight_name = flight_.name,
             .reference = std::move(reference),
             .map = std::move(map),
             .left_out = std::move(left_out),
             .frames_total = total,
             .notes = flight_.notes,
             .options = options_,
             .calibration = flight_.calibration.description,
             .mount = describe_mount(flight_),
             .sea_level = flight_.sea_level->description,
             .datum = flight_.datum,
             .times_are_utc = flight_.times_are_utc};

  WATERSKY_CHECK(prepare_masks(run.reference));
  observe(located, run.reference);
  // Frames are decoded, looked at and turned to evidence side by side, as many as there are
  // threads; into the map they go one by one, in order of capture, whatever the threads.
  // One more than threads, so that none waits while this thread brings a frame into the map.
  const std::size_t window =
      options_.threads > 1 ? static_cast<std::size_t>(options_.threads) + 1 : 1;
  std::deque<std::future<Result<ReadyFrame>>> ahead;
  std::size_t next = 0, untold = 0;
  for (std::size_t i = 0; i < located.size(); ++i) {
    report(progress_, "mapping", i, located.size());
    for (; next < located.size() && next < i + window; ++next)
      ahead.push_back(std::async(
          window == 1 ? std::launch::deferred : std::launch::async,
          [this, &run, &frame = located[next]] { return make_ready(frame, run.reference); }));
    const auto ready = ahead.front().get();
    ahead.pop_front();
    const Status done = ready ? integrate(*ready, run, untold) : Status(ready.error());
    if (!done) run.left_out.push_back({located[i].frame->name, done.error().message});
  }
  report(progress_, "mapping", located.size(), located.size());
  if (run.used.empty()) return none(run.left_out);
  if (untold == run.used.size())
    return Error{ErrorCode::OutOfRange,
                 "in none of " + std::to_string(untold) +
                     " frames could ice be told from water: they show no contrast that could be "
                     "either"};
  if (untold > 0)
    run.notes.push_back(std::to_string(untold) +
                        " frames show nothing that could be told to be ice or water, as in fog; "
                        "they are in the mosaic and add nothing to the map.");

  run.sensor_events = watch_.events();
  for (auto& note : sensor_.findings().notes()) run.notes.push_back(std::move(note));
  for (auto& note : detail::notes_on(run.sensor_events)) run.notes.push_back(std::move(note));
  const Findings found = segmenter_.findings();
  run.ice = found.polarity ? found.polarity->polarity : IcePolarity::Auto;
  const auto still = std::count_if(located.begin(), located.end(), [](const LocatedFrame& l) {
    return l.pose.shutter.readout_s == 0.0;
  });
  if (flight_.readout_s > 0 && still > 0)
    run.notes.push_back("The shutter rolls (readout_s), but how the camera moved is not known of " +
                        std::to_string(still) + " frames: all their rows have one pose.");
  run.notes.insert(run.notes.end(), found.notes.begin(), found.notes.end());
  if (const double half_life_s = options_.parameters.map.half_life_s; half_life_s > 0) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "Cells forget: half of what is known of one is gone %.4g s after its last look; "
                  "the map is as known at the last frame.",
                  half_life_s);
    run.notes.emplace_back(text);
  }
  const auto cut = std::count_if(run.used.begin(), run.used.end(),
                                 [](const UsedFrame& u) { return u.cut_by_grazing_limit; });
  if (cut > 0) {
    char text[160];
    std::snprintf(
        text, sizeof text,
        "%d frames see the horizon or sea flatter than %.3g°; that part of them was not used.",
        static_cast<int>(cut), options_.parameters.min_grazing_deg);
    run.notes.emplace_back(text);
  }
  run.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return run;
}

}  // namespace

cv::Mat located_probability(const MapRun& run, const CellBox& box) {
  return run.uncertainty.softened(run.map.probability(box), box);
}

Result<MapRun> map_flight(const Flight& flight, const MappingOptions& options,
                          const Progress& progress) {
  WATERSKY_CHECK(validate(options.parameters));
  WATERSKY_TRY(const auto segmenter,
               make_segmenter(options.method, options.parameters.segmentation, options.ice));
  return FlightMapper(flight, options, progress, *segmenter).run();
}

}  // namespace watersky
